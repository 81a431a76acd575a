"""Finished work is never lost, and what comes of it in the end is what an undisturbed run gives, bit for bit."""

import contextlib
import errno
import io
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus.cli.commands import main
from swarmcensus.engine import compiler
from swarmcensus.results import shards
from swarmcensus.results.partial import open_partial
from swarmcensus.results.values import ALL_VARIABLES, MARKS, Values
from swarmcensus.runs.resuming import hold_output
from swarmcensus.runs.running import run
from swarmcensus.runs.status_of_run import status
from swarmcensus.support.errors import InputError, Interrupted
from swarmcensus.support.formatting import counted
from swarmcensus.support.options import shell_options
from swarmcensus.support.owners import Owner
from tests.support.results import same
from tests.support.small import FAILS

pytestmark = pytest.mark.usefixtures("untraced_processes", "here")


STUDY = """
name = "resumed"
seed = 7
trials = 6
swarm = {robots = [3, 20], accuracy = [0.7, "U(0.525, 0.975)"]}
world = {topology = ["full", "ring", "moving"], density = 1, fill_ratio = [0.55, 0.95]}
schedule = {rounds = 60, ticks = 200}
measure = {checkpoints = [10, 60], local = false}
"""
# fixed networks alone: quicker, and some things are of them alone
FIXED = STUDY.replace(', "moving"', "").replace("density = 1, ", "").replace(", ticks = 200", "")


def study(text=STUDY, **changes):
    return sc.Study.parse(text).with_(**changes)


class Cut(BaseException):
    """Stands for whatever ends a process; shards of what was finished are written before it is raised."""


def cut_off(out, after, text=STUDY):
    """Run a study until so many trials are done, and leave its shards as a killed process would."""
    with pytest.MonkeyPatch.context() as patch:
        write_at_once(patch)
        assert cut_when(lambda p: p.done >= after, study(text), out)
    return shards.shard_files(shards.folder_of(Path(out)))


def write_at_once(patch):
    patch.setattr(shards, "AT_LEAST", 0.0)
    patch.setattr(shards, "OF_ELAPSED", 0.0)


@pytest.fixture(scope="module")
def whole():
    return sc.run(study(), jobs=2)


@pytest.fixture(autouse=True)
def small_bundles(monkeypatch):
    monkeypatch.setattr("swarmcensus.runs.pools.BUNDLE_SECONDS", 0.001)


@pytest.fixture
def here(here):
    Path("s.toml").write_text(STUDY)
    return here


def test_a_run_that_was_cut_off_goes_on(here, whole):
    cut_off("a.nc", 40)
    assert not Path("a.nc").exists()
    for left in ("a.nc.parts/.run-0123abcd.json", f"a.nc.parts/.000009-{32 * 'a'}-0123abcd.npz", ".a-0123abcd.nc"):
        Path(left).touch()  # of killed processes
    Path(".b-0123abcd.nc").touch()  # of another output, which may be written now
    lines, done = [], []
    again = run(study(), 1, lambda p: done.append(p.done), out="a.nc", say=lines.append)
    assert done[0] >= 40
    assert "of a run that was cut off" in lines[0]
    assert same(again, whole)
    assert same(sc.load("a.nc"), whole)
    assert sorted(p.name for p in here.iterdir()) == [".b-0123abcd.nc", "a.nc", "s.toml"]


@pytest.mark.long(only=["1"])
@pytest.mark.parametrize("times", [1, 2])
def test_ctrl_c_leaves_no_half_trial(times, here, whole, monkeypatch):
    put, pieces = Values.put, []

    def torn(self, setting, first, taken):
        pieces.append((setting, first))
        broken = 30 <= len(pieces) < 30 + times
        put(self, setting, first, {k: v for k, v in taken.items() if not (broken and k in MARKS)})
        if broken:
            raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(Values, "put", torn)
        with pytest.raises(Interrupted) as stopped:
            run(study(), 1, out="a.nc")
    data = sc.load("a.nc")
    assert 0 < stopped.value.done == data.attrs["trials_done"]
    setting, first = pieces[29]
    assert (data["convergence_round"].values[setting, first, 0] >= 0) == (times == 1)
    assert same(run(study(), 2, out="a.nc"), whole)


def test_nothing_is_run_twice(here, whole, monkeypatch):
    run(study(), 2, out="a.nc")
    before = Path("a.nc").read_bytes()
    monkeypatch.setattr("swarmcensus.runs.pools.run_bundle", lambda *_: pytest.fail("was run"))
    assert same(run(study(), 2, out="a.nc"), whole)
    assert Path("a.nc").read_bytes() == before


@pytest.mark.parametrize("after", [0, 30])
def test_ctrl_c_puts_what_is_done_into_the_output(after, here, whole):
    def stop(progress):
        if progress.done >= after and not progress.note:  # it compiles no more
            raise KeyboardInterrupt

    with pytest.raises(sc.Interrupted) as stopped:
        run(study(), 1, stop, out="a.nc")
    partial = sc.load("a.nc").attrs
    assert partial["trials_done"] == stopped.value.done >= after
    assert partial["trials_total"] == stopped.value.total == 144
    assert not shards.folder_of(Path("a.nc")).exists()
    assert same(run(study(), 2, out="a.nc"), whole)


def test_more_trials_and_settings_compute_only_what_is_missing(here):
    small = STUDY.replace("trials = 6", "trials = 4").replace("[3, 20]", "20").replace('0.7, "U', '"U')
    run(study(small), 2, out="a.nc")
    done, larger = [], study(STUDY.replace("trials = 6", "trials = 7").replace("0.7,", "0.6, 0.7,"))
    grown = run(larger, 2, lambda p: done.append((p.done, p.total)), out="a.nc")
    assert done[0] == (4 * 6, 7 * 36)
    assert same(grown, sc.run(larger, jobs=2))


def test_local_estimates_may_be_asked_for_later(here):
    run(study(FIXED), 2, out="a.nc")
    local = study(FIXED.replace("local = false", "local = true"))
    assert same(run(local, 2, out="a.nc"), sc.run(local, jobs=2))
    cut_when(lambda p: p.work_done > 0.9 * p.work_total, local, "b.nc")  # local is last
    for out in ("a.nc", "b.nc"):
        with pytest.raises(InputError, match="local_convergence_step, which this study does not ask for"):
            run(study(FIXED), out=out)


@pytest.mark.long(but=["cut"])
@pytest.mark.parametrize("damage", ["cut", "empty", "rename"])
def test_a_damaged_shard_is_named_and_redone(here, whole, damage):
    path = cut_off("a.nc", 60)[0]
    if damage == "rename":
        path.rename(path.with_name(f"000001-{32 * '0'}.npz"))
    else:
        path.write_bytes(path.read_bytes()[: path.stat().st_size // 2 if damage == "cut" else 0])
    named = next(p for p in shards.shard_files(shards.folder_of(Path("a.nc"))) if shards.read(p) is None)
    assert status("a.nc").damaged == [named]
    assert any("is damaged" in line for line in status("a.nc").sentences)
    with pytest.warns(UserWarning, match=f"{named.name} is damaged: what it held is run again"):
        assert same(run(study(), 2, out="a.nc"), whole)


def test_any_flipped_bit_is_noticed(here):
    path = cut_off("a.nc", 10)[0]
    data = path.read_bytes()
    for place in random.Random(4).sample(range(8 * len(data)), 200):
        changed = bytearray(data)
        changed[place // 8] ^= 1 << place % 8
        path.write_bytes(changed)
        assert shards.read(path) is None
    path.write_bytes(data)
    assert shards.read(path) is not None


@pytest.mark.long(but=["True-change0-seed is 7 there and 8 here"])
@pytest.mark.parametrize(("change", "said"), [
    (("seed = 7", "seed = 8"), "seed is 7 there and 8 here"),
    (("measure = {", "measure = {delta = 0.02, "), "delta is 0.01 there and 0.02 here"),
    (("0.7, ", ""), "swarm.accuracy is [0.7, 'U(0.525, 0.975)'] there and ['U(0.525, 0.975)'] here. --fresh runs"),
    (("trials = 6", "trials = 5"), "holds 6 trials a setting, this study asks for 5"),
])  # fmt: skip
@pytest.mark.parametrize("finished", [True, False])
def test_work_of_another_run_is_refused(change, said, finished, here, refused, monkeypatch):
    monkeypatch.setattr(shards, "SKETCH_AFTER", (0.0, 0.0))  # as after its first second
    if finished:
        assert main(["run", "s.toml", "--out", "a.nc"]) == 0
    else:
        cut_off("a.nc", 130)
    Path("t.toml").write_text(STUDY.replace(*change))
    assert said in refused("run", "t.toml", "--out", "a.nc")
    assert main(["run", "t.toml", "--out", "a.nc", "--fresh"]) == 0
    Path("t.toml").unlink()
    assert same(sc.load("a.nc"), sc.run(study(STUDY.replace(*change)), jobs=2))


def test_another_version_is_refused(here, monkeypatch):
    cut_off("a.nc", 20)
    monkeypatch.setattr("swarmcensus.runs.resuming.__version__", "99.0")
    with pytest.raises(InputError, match=r"version is '0.*' there and '99\.0' here"):
        run(study(), out="a.nc")


def test_a_brain_that_has_changed_is_refused_by_its_name(here, refused):
    source = sc.Study.parse(STUDY).swarm.brain[0].source
    Path("mine.py").write_text(source)
    Path("s.toml").write_text(FIXED.replace("swarm = {", 'swarm = {brain = "mine.py", ').replace('"full", ', ""))
    assert main(["run", "s.toml"]) == 0
    Path("mine.py").write_text(source + "\n# changed\n")
    says = "s.nc: mine.py has changed since it was made. --fresh runs everything again, --out another.nc keeps"
    assert says in refused("run", "s.toml")


def test_an_output_that_is_no_results_file_is_left_alone(here, refused):
    Path("a.nc").write_text("my notes")
    assert "not a readable netCDF-4 file" in refused("run", "s.toml", "--out", "a.nc")


def test_two_runs_on_one_output(here, capsys):
    def second(progress):
        if progress.done and not seen:
            seen.append(main(["run", "s.toml", "--out", "a.nc"]))
            found.append(status("a.nc"))

    seen, found = [], []
    run(study(), 1, second, out="a.nc")
    assert seen == [2]
    assert f"a.nc: another run is writing it (process {os.getpid()} on " in capsys.readouterr().err
    assert f"process {os.getpid()} on" in found[0].running
    assert 0 < found[0].total == 144
    assert not status("a.nc").running


@pytest.mark.long
def test_status_of_what_was_cut_off_and_of_what_is_done(here, accepted):
    with pytest.raises(InputError, match="there is no such file"):
        status("a.nc")
    with shell_options({"out": "a.nc"}, ["run", "s.toml", "--out", "a.nc", "--fresh"]):
        cut_off("a.nc", 50)
    assert "not running: swarmcensus run s.toml --out a.nc goes on from here" in accepted("status", "a.nc").out
    assert 40 <= status("a.nc").done < 144
    run(study(), out="a.nc")
    assert status("a.nc").sentences == ["resumed: 24 settings; 144 of 144 trials done (100.0 %)"]
    cut_off("b.nc", 50)
    (shards.folder_of(Path("b.nc")) / "run.json").write_text("{")
    with pytest.raises(InputError, match="is damaged"):
        status("b.nc")
    run(study(), out="b.nc")


@pytest.mark.long
def test_sigkill_at_random_moments(here, untraced, accepted):
    """Some while it starts, most after some shards more: a busy machine may take long to come that far."""
    often = "import sys; from swarmcensus.cli.commands import main; from swarmcensus.results import shards; "
    often += "shards.AT_LEAST = 0.02; sys.exit(main())"
    longer = STUDY.replace("trials = 6", "trials = 200").replace("= 60,", "= 2000,").replace("= 200}", "= 2000}")
    Path("s.toml").write_text(longer)
    moments, folder, found = random.Random(11), shards.folder_of(Path("a.nc")), 0
    for more in [0, 1, 1, 1, 2, 0, 1, 1, 1, 1]:
        wanted = len(shards.shard_files(folder)) + more
        run_again = [sys.executable, "-c", often, "run", "s.toml", "--out", "a.nc", "--jobs", "1"]
        with subprocess.Popen(run_again, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE) as process:
            while process.poll() is None and len(shards.shard_files(folder)) < wanted:
                time.sleep(0.01)
            time.sleep(moments.uniform(0.0, 0.1))
            assert process.poll() is None, "the study is too short for this test"
            process.send_signal(signal.SIGKILL)
            found += b"found" in process.stderr.read()
    assert found >= 6
    assert not Path("a.nc").exists()
    assert "of a run that was cut off" in accepted("run", "s.toml", "--out", "a.nc").err
    assert same(sc.load("a.nc"), sc.run(study(longer), jobs=2))
    assert not folder.exists()


def test_a_full_disk_as_the_system_tells_it(here, whole, monkeypatch):
    write_at_once(monkeypatch)
    folder = shards.folder_of(Path("a.nc"))

    def full(_):
        if len(shards.shard_files(folder)) >= 3:
            raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr("swarmcensus.support.files.os.fsync", full)
        with pytest.raises(InputError, match="No space left on device"):
            run(study(), 1, out="a.nc")
    assert len(shards.shard_files(folder)) == 3
    assert not [p for p in folder.iterdir() if p.name.startswith(".")]
    assert same(run(study(), 2, out="a.nc"), whole)


def test_a_trial_that_fails_fails_alone(here, capsys):
    Path("bad.py").write_text(FAILS)
    text = FIXED.replace("robots = [3, 20]", 'brain = ["minimalistic", "bad.py"], robots = 20')
    text = text.replace('"full", ', "").replace("[0.55, 0.95]", "[0.3, 0.32]")
    Path("s.toml").write_text(text)
    assert main(["run", "s.toml"]) == 2
    data = sc.load("s.nc")
    failed = json.loads(data.attrs["failed"])
    done = data["convergence_round"].values[:, :, 0] >= 0
    assert {(one["setting"], one["trial"]) for one in failed} == {tuple(place) for place in np.argwhere(~done).tolist()}
    assert 0 < len(failed) < done[4:].size  # some of the bad brain's trials fail and some do not
    assert done[:4].all()
    mine = next(k for k, line in enumerate(FAILS.splitlines(), start=1) if "me.t - me.t" in line)
    assert f"ZeroDivisionError: division by zero, at bad.py, line {mine}: " in failed[0]["why"]
    said = "".join(capsys.readouterr())
    assert f"setting {failed[0]['setting']}, trial {failed[0]['trial']}" in said
    assert failed[0]["why"] in said
    # what did not fail is what the same brain gives without the fault, which is never reached there
    good = sc.run(sc.Study.parse(text.replace(', "bad.py"', "")), jobs=2)
    kept = data["final_estimate"].values[4:]
    assert np.array_equal(kept[done[4:]], good["final_estimate"].values[done[4:]])


def test_fresh_run_is_resumed(here, whole):
    run(study(seed=8, trials=2), out="a.nc")
    found = cut_when(lambda p: p.done >= 40, study(), "a.nc", fresh=True)
    lines = []
    assert same(run(study(), out="a.nc", say=lines.append), whole)
    assert f"in {counted(found, 'shard')} of a run" in lines[0]
    assert same(sc.load("a.nc"), whole)
    assert sorted(p.name for p in here.iterdir()) == ["a.nc", "s.toml"]


def cut_when(holds, one, out, **options):
    def die(progress):
        if holds(progress):
            raise Cut

    with pytest.raises(Cut):
        run(one, 1, die, out=out, **options)
    return len(shards.shard_files(shards.folder_of(Path(out))))


def test_a_fresh_run_that_is_stopped_at_once_leaves_the_output(here, whole):
    def stop(*_):
        raise KeyboardInterrupt

    run(study(), out="a.nc")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("swarmcensus.runs.running._run_stages", stop)
        with pytest.raises(Interrupted):
            run(study(seed=8), out="a.nc", fresh=True)
    assert same(run(study(), out="a.nc"), whole)
    assert sorted(p.name for p in here.iterdir()) == ["a.nc", "s.toml"]


@pytest.mark.long
def test_a_mended_brain_does_not_cost_the_others(here, capsys):
    shipped, compile_brain = sc.brains.load("minimalistic"), compiler.compile_brain
    text = FIXED.replace("swarm = {", 'swarm = {brain = ["minimalistic", "mine.py"], ').replace('"full", ', "")
    Path("s.toml").write_text(text)
    Path("mine.py").write_text(shipped.source.replace("    me.t += looks\n", "    me.t += looks / 0.0\n", 1))
    assert main(["run", "s.toml"]) == 2
    before = sc.load("s.nc")
    Path("mine.py").write_text(shipped.source)
    with pytest.MonkeyPatch.context() as patch:  # a copy is the same code: there is no need to compile it
        patch.setattr(compiler, "compile_brain", lambda _, *how, **more: compile_brain(shipped, *how, **more))
        assert main(["run", "s.toml"]) == 0
    assert "found 48 of 96 trials" in capsys.readouterr().err
    after = sc.load("s.nc")
    assert "failed" not in after.attrs
    assert np.array_equal(after["final_estimate"][:8], before["final_estimate"][:8], equal_nan=True)


@pytest.mark.long(only=["False"])
@pytest.mark.parametrize("finished", [True, False])
def test_only_what_a_run_wrote_is_removed(finished, here, whole):
    folder = shards.folder_of(Path("a.nc"))
    mine = ["mine.npz", "000001-0123.npz", ".mine.npz", ".000001-0123abcd.npz", f".000001-{32 * 'a'}-mine.npz"]
    if not finished:
        cut_off("a.nc", 40)
    folder.mkdir(exist_ok=True)
    for name in mine:
        (folder / name).write_text("my notes")
    (here / "elsewhere.npz").write_text("my notes")
    (folder / f"000001-{32 * '0'}.npz").symlink_to(here / "elsewhere.npz")
    (folder / f".000001-{32 * 'a'}-0123abcd.npz").symlink_to(here / "elsewhere.npz")
    assert same(run(study(), 1, out="a.nc"), whole)
    assert same(run(study(), 1, out="a.nc", fresh=True), whole)
    assert (here / "elsewhere.npz").read_text() == "my notes"
    assert all((folder / name).read_text() == "my notes" for name in mine)
    assert len(list(folder.iterdir())) == len(mine) + 2


@pytest.mark.parametrize("name", ["", "lock", "run.json", "fresh", shards.SKETCH])
def test_a_link_where_a_run_keeps_its_work_is_refused(name, here):
    folder = shards.folder_of(Path("a.nc"))
    (here / "elsewhere").mkdir()
    if name:
        folder.mkdir()
        (here / "elsewhere" / "notes").write_text("my notes")
        (folder / name).symlink_to(here / "elsewhere" / "notes")
    else:
        (here / "elsewhere" / f"000001-{32 * '0'}.npz").write_text("my notes")
        folder.symlink_to(here / "elsewhere")
    with pytest.raises(InputError, match="is a link: a run keeps its work there"):
        run(study(), out="a.nc", fresh=True)
    (kept,) = (here / "elsewhere").iterdir()
    assert kept.read_text() == "my notes"
    assert not Path("a.nc").exists()


def test_a_run_that_was_killed_has_an_early_picture(here, monkeypatch, accepted):
    """What the shards hold is shown, drawn and exported, and nothing is altered by that."""
    text = STUDY.replace("local = false", "estimates = true")
    monkeypatch.setattr(shards, "SKETCH_AFTER", (0.0, 0.0))
    cut_off("a.nc", 50, text)
    folder = shards.folder_of(Path("a.nc"))
    before = {p.name: p.read_bytes() for p in folder.iterdir()}
    done = status("a.nc").done
    assert json.loads(status("a.nc").to_json())["trials_done"] == done < 144
    says = f"a.nc is not written yet: this is what its run has so far, {done} of 144 trials\n"
    out, error = accepted("show", "a.nc", "--limit", "0")
    assert error.startswith(says)
    assert f"{done} of 144 trials done" in out
    assert accepted("plot", "a.nc", "--kind", "lines", "--x", "checkpoint", "--where", "setting < 3").err == says
    assert {p.name: p.read_bytes() for p in folder.iterdir()} == before
    early = open_partial("a.nc")
    final = run(study(text), out="a.nc")
    for name in ALL_VARIABLES:
        if name in early:
            there = early[name].values
            same_places = final[name].isel(trial=slice(early.sizes["trial"])).values
            known = there != -1 if there.dtype.kind == "i" else ~np.isnan(there)
            assert known.any() or name == "true_fill_ratio"
            assert (there[known] == same_places[known]).all()
    assert not folder.exists()


def test_file_systems_need_no_locks(here, whole, monkeypatch):
    fcntl = pytest.importorskip("fcntl")

    def flock(*_):
        raise OSError(errno.ENOLCK, "no locks")

    with monkeypatch.context() as patch:
        patch.setattr(fcntl, "flock", flock)
        assert same(run(study(), 1, out="a.nc"), whole)
    with open("a.nc", "rb") as locked:
        fcntl.flock(locked, fcntl.LOCK_EX)
        assert same(sc.load("a.nc"), whole)
        assert main(["show", "a.nc"]) == 0


def test_a_run_whose_output_another_has_taken_writes_nothing_more(here):
    lock = shards.folder_of(Path("a.nc")) / "lock"

    def removed(_):
        if not other:
            lock.unlink()
            other.append(stack.enter_context(Owner(lock)))

    other = []

    with contextlib.ExitStack() as stack:
        with pytest.raises(InputError, match=r"a\.nc: another run has taken it over"):
            run(study(), 1, removed, out="a.nc")
        assert lock.exists()
    assert not Path("a.nc").exists()


def test_unfinished_output_is_recognised(here, refused):
    cut_off("a.nc", 50)  # too short for an early picture
    for command in ("show", "plot", "export", "verify"):
        assert "not written yet, its run was cut off: the same swarmcensus run goes on" in refused(command, "a.nc")
    with Owner(shards.folder_of(Path("a.nc")) / "lock"):
        assert "a run is at work on it" in refused("verify", "a.nc")


def test_what_cannot_be_shared(here, refused):
    for wrong in ("0/3", "4/3", "1/7"):
        assert f"share {wrong}" in refused("run", "s.toml", "--share", wrong)
    Path("s.toml").write_text(STUDY.replace("trials = 6", 'trials = {until = "convergence_error median +- 0.1"}'))
    assert "a study whose trials follow a rule cannot be shared" in refused("run", "s.toml", "--share", "1/2")


# ---- what a run finds at its output and leaves there: links, other checkpoints, vanished folders, unfinished results
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

    path, packed = cut_off("a.nc", 10)[0], io.BytesIO()
    with np.load(path) as arrays:
        np.savez(packed, **dict(arrays) | {"final_estimate": np.array([Pickle()], object)})
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
    text = STUDY.replace("checkpoints = [10, 60], ", "")
    longer = study(text.replace("rounds = 60", "rounds = [60, 100]").replace("ticks = 200", "ticks = [200, 300]"))
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

    cut_when(lambda p: p.total > 16 * 6, ruled, "a.nc")
    found = status("a.nc")
    assert found.total > found.done >= 16 * 6  # the first stage is done, and more trials are wanted
    assert "trials are added until: convergence_error median +- 0.01" in found.sentences
    data = run(ruled, 2, out="a.nc")
    assert status("a.nc").done == status("a.nc").total == data.attrs["trials_done"]


def test_estimates_are_kept_in_all_trials_or_in_none():
    kept = FIXED.replace("[10, 60]", "[10, 60], estimates = true")
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
