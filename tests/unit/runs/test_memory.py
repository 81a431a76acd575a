"""What a study of large swarms keeps in memory while it runs, and what it does not."""

import tracemalloc

import pytest

import swarmcensus as sc
from swarmcensus.results import shards, values as arrays
from swarmcensus.runs import pools
from swarmcensus.runs.running import run
from swarmcensus.support.errors import InputError
from tests.support.small import SEED, settings_of
from tests.support.trials import record_trial

ROBOTS = 60_000
BYTES = 36 * ROBOTS  # of results, a setting


def crowds(settings, robots=ROBOTS, trials=1):
    return sc.Study(
        trials=trials, swarm={"robots": robots, "accuracy": [round(0.6 + 0.02 * k, 2) for k in range(settings)]},
        world={"topology": "ring", "fill_ratio": 0.55}, schedule={"rounds": 2},
    )  # fmt: skip


@pytest.fixture
def small_arrays(monkeypatch):
    """Arrays of a megabyte are large."""
    monkeypatch.setattr(arrays, "LARGE_BYTES", 1_000_000)
    monkeypatch.setattr(arrays, "FRESH_BYTES", 1_000_000)
    monkeypatch.setattr(shards, "SPOOLED_BYTES", 1_000_000)


def peak(settings, out):
    """The most bytes that a run has at once, but for what lies in files; and its dataset."""
    tracemalloc.start()
    try:
        data = run(crowds(settings), 1, progress=False, out=out)
        return tracemalloc.get_traced_memory()[1], data
    finally:
        tracemalloc.stop()


def test_the_numbers_of_large_settings_do_not_add_up_in_memory(small_arrays, tmp_path, monkeypatch):
    """Ten settings take no more than one and some that wait to be written, of which there are four at the most."""
    monkeypatch.setattr(pools, "BUNDLE_SECONDS", 0.0)
    monkeypatch.setattr(shards, "AT_LEAST", 0.0)  # as of trials that take seconds
    monkeypatch.setattr(shards, "OF_ELAPSED", 0.0)
    monkeypatch.setattr(shards, "SKETCH_AFTER", (0.0, 0.0))
    run(crowds(1, 10), 1, progress=False)  # compiles, and imports what is imported late
    one, _ = peak(1, tmp_path / "one.nc")
    ten, data = peak(10, tmp_path / "ten.nc")
    assert ten - one < 5 * BYTES
    assert {path.name for path in tmp_path.iterdir()} == {"one.nc", "ten.nc"}
    assert sc.load(tmp_path / "ten.nc").equals(data)
    assert sc.load(tmp_path / "one.nc").equals(sc.load(tmp_path / "ten.nc").sel(setting=[0]))


def test_a_folder_without_space_for_results_is_reported(small_arrays, tmp_path, monkeypatch):
    def full(**_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(arrays.tempfile, "TemporaryFile", full)
    with pytest.raises(InputError, match=r"cannot keep results in .*: No space left on device"):
        run(crowds(5), 1, progress=False, out=tmp_path / "a.nc")
    assert not list(tmp_path.iterdir())


def test_a_replay_of_a_single_round_begins_before_it():
    (setting,) = settings_of(rounds=1)
    fields, estimates, _ = record_trial(setting, SEED, 0)
    assert (fields["t"][0] == 0.0).all()
    assert (estimates[0] == 0.5).all()
