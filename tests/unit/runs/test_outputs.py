"""What a run finds at its output and leaves there: links, other checkpoints, vanished folders, unfinished results."""

import io
import os
import shutil
from pathlib import Path

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus.cli.commands import main
from swarmcensus.results import shards
from swarmcensus.runs.resuming import hold_output
from swarmcensus.runs.running import run
from swarmcensus.runs.status_of_run import status
from swarmcensus.support.errors import InputError
from tests.support.results import same
from tests.support.resuming import FIXED, STUDY, Cut, cut_off, study

pytestmark = pytest.mark.usefixtures("here")


@pytest.fixture(scope="module")
def whole():
    return sc.run(study(), jobs=2)


def test_links_to_one_output_lock_each_other():
    Path("real").mkdir()
    Path("a.nc").symlink_to("real/b.nc")
    with hold_output(Path("a.nc"), study(), [], [], False, print), pytest.raises(InputError, match="another run"):
        run(study(), out="real/b.nc")


def test_a_folder_that_vanishes_during_a_run_is_made_again(whole):
    def vanish(progress):
        if progress.done == progress.total:
            shutil.rmtree("made")

    assert same(run(study(), 1, vanish, out="made/a.nc"), whole)
    assert same(sc.load("made/a.nc"), whole)
    assert [p.name for p in Path("made").iterdir()] == ["a.nc"]


def test_a_pickle_in_a_shard_is_not_opened():
    class Pickle:
        def __reduce__(self):
            return os.mkdir, ("opened",)

    path = cut_off("a.nc", 10)[0]
    with np.load(path) as arrays:
        held = dict(arrays)
    packed = io.BytesIO()
    np.savez(packed, **held | {"final_estimate": np.array([Pickle()], object)})
    path = path.with_name(f"000009-{shards.HASH(packed.getvalue()).hexdigest()}.npz")
    path.write_bytes(packed.getvalue())
    assert shards.read(path) is None
    assert not Path("opened").exists()


@pytest.mark.long
def test_checkpoints_of_results_and_of_a_study_differ(whole):
    """Fewer are enough, others are refused; settings of more rounds are added."""
    more, missing = (STUDY.replace("[10, 60]", f"[10, {k}, 60]") for k in (20, 30))
    run(study(more), 2, out="a.nc")
    assert same(run(study(), 2, out="a.nc"), whole)
    with pytest.raises(InputError, match="no decisions at round 30"):
        run(study(missing), out="a.nc")
    parts = [sc.run(study(text.replace("[3, 20]", n)), jobs=2) for text, n in ((STUDY, "3"), (more, "20"))]
    sc.save(sc.merge(parts), "m.nc")
    with pytest.raises(InputError, match="no decisions at round 20"):
        run(study(more), out="m.nc")
    assert same(run(study(), 2, out="m.nc"), whole)
    text = STUDY.replace("checkpoints = [10, 60]", "")
    longer = study(text.replace("rounds = 60", "rounds = [60, 100]").replace("ticks  = 200", "ticks  = [200, 300]"))
    cut_off("b.nc", 20, text)
    assert same(run(longer, 2, out="b.nc"), sc.run(longer, jobs=2))


@pytest.mark.long
def test_status_of_shares_of_merged_results_and_of_a_rule():
    for k in (1, 2):
        run(study(), 2, out=f"{k}.nc", share=(k, 3))
    assert status("1.nc").sentences[1] == "share 1/3, which swarmcensus merge puts together with the others"
    sc.save(sc.merge(["1.nc", "2.nc"]), "m.nc")
    assert (status("m.nc").done, status("m.nc").total) == (96, 144)
    assert status("m.nc").sentences[1].startswith("not running: swarmcensus run of its study, with --out m.nc")
    rule = '{until = "convergence_error median +- 0.01", at_least = 6, at_most = 40}'
    ruled = study(FIXED.replace("trials = 6", f"trials = {rule}"))

    def die(progress):
        if progress.total > 16 * 6:
            raise Cut

    with pytest.raises(Cut):
        run(ruled, 1, die, out="a.nc")
    found = status("a.nc")
    assert found.total > found.done >= 16 * 6  # the first stage is done, and more trials are wanted
    assert "trials are added until: convergence_error median +- 0.01" in found.sentences
    data = run(ruled, 2, out="a.nc")
    assert status("a.nc").done == status("a.nc").total == data.attrs["trials_done"]


def test_estimates_are_kept_in_all_trials_or_in_none():
    kept = FIXED.replace("[10, 60]", "[10, 60]\nestimates = true")
    for first, second, said in ((kept, FIXED, "holds estimates, which"), (FIXED, kept, "has no estimates, which")):
        run(study(first), 2, out="a.nc", fresh=True)
        with pytest.raises(InputError, match=f"{said} this study"):
            run(study(second), out="a.nc")


def test_merge_leaves_the_work_of_a_run_that_was_cut_off(whole, refused):
    cut_off("m.nc", 40)
    sc.save(whole, "a.nc")
    assert "holds the work of a run that was cut off" in refused("merge", "a.nc", "--out", "m.nc")
    assert main(["merge", "a.nc", "--out", "m.nc", "--fresh"]) == 0
    assert same(sc.load("m.nc"), whole)
