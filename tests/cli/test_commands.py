"""The command line, as a user meets it: what it prints, what it writes, how it fails."""

import os
import signal
import subprocess
import sys
import time

import pytest

import swarmcensus as sc
from swarmcensus.cli.commands import main
from tests.support.small import SMALL

HELLO = """
trials = 3
swarm = {robots = 6, accuracy = [0.7, 0.9]}
world = {topology = "ring", fill_ratio = [0.55, 0.95]}
schedule = {rounds = 20}
"""


@pytest.fixture(autouse=True)
def hello(here):
    (here / "hello.toml").write_text(HELLO)


def test_a_first_session(here, accepted):
    out = accepted("run", "hello.toml", "--jobs", "2").out
    assert "4 settings of 3 trials" in out
    assert "right" in out
    assert "36 rows" in accepted("export", "hello.nc", "--where", "accuracy == 0.7").out
    assert main(["plot", "hello.nc", "--kind", "lines"]) == 0  # every kind is drawn in tests/unit/figures
    assert (here / "hello-lines.png").stat().st_size > 10_000
    assert (here / "hello-lines.svg").exists()
    assert {p.suffix for p in here.iterdir() if p.is_file()} == {".toml", ".nc", ".csv", ".png", ".svg", ".txt"}


def test_a_trial_is_replayed_and_inferred_again(here, accepted):
    assert main(["run", "hello.toml", "-q"]) == 0
    replay = ["replay", "hello.nc", "--setting", "1", "--trial", "2", "--out", "t.nc"]
    assert "accuracy 0.7, f = 0.95" in accepted(*replay, "--recording", "rec").out
    infer = ["infer", "rec/observations.csv", "--links", "rec/links.csv", "--accuracy", "0.7"]
    assert main([*infer, "--out", "again.csv"]) == 0
    assert (here / "again.png").exists()
    last = (here / "again.csv").read_text().splitlines()[-1].split(",")
    assert float(last[-1]) == sc.load("hello.nc")["final_estimate"].values[1, 2, -1]


def test_seed_and_trials_and_a_share_can_be_given(here, accepted):
    assert main(["run", "hello.toml", "--trials", "2", "--seed", "5", "--out", "a.nc"]) == 0
    data = sc.load("a.nc")
    assert (data.sizes["trial"], data.attrs["seed"]) == (2, 5)
    said = accepted("run", "hello.toml", "--share", "1/2", "--out", "b.nc")
    assert "b.nc: share 1/2 of 4 settings of 3 trials" in said.out
    assert "next: with the other shares, swarmcensus merge b.nc ... --out ALL.nc" in said.err
    assert main(["replay", "a.nc", "--setting", "0", "--trial", "1"]) == 0


def test_a_folder_without_permission(refused, monkeypatch):
    monkeypatch.setattr(os, "access", lambda path, mode: False)
    assert "cannot be written" in refused("run", "hello.toml", "--out", "locked/x.nc")


@pytest.mark.long
def test_ctrl_c_stops_within_a_second_and_keeps_what_is_done(here):
    text = SMALL.replace("trials = 4", "trials = 300").replace("rounds = 60", "rounds = 200_000")
    (here / "long.toml").write_text(text.replace("[10, 60]", "[10]"))
    code = "from swarmcensus.cli.commands import main; from swarmcensus.runs import progress; "
    code += "progress.LINE_SECONDS = 0.2; raise SystemExit(main())"
    command = [sys.executable, "-c", code, "run", "long.toml", "--jobs", "1"]
    with subprocess.Popen(command, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as run:
        assert run.stderr is not None
        for line in run.stderr:  # plain lines; the first may come before any trial
            assert line.startswith("small: ")
            if "left" in line:
                break
        begun = time.monotonic()
        run.send_signal(signal.SIGINT)
        _, error = run.communicate(timeout=60)
    took = time.monotonic() - begun
    assert run.returncode == 130
    assert "stopped after" in error
    assert "Traceback" not in error
    data = sc.load(here / "long.nc")
    assert data.attrs["trials_done"] == int((~data["final_estimate"].isel(robot=0).isnull()).sum()) > 0
    assert took < 10  # saving is most of it; that threads stop at once is tested in the engine


def test_a_study_without_a_name_is_called_as_its_file_is(here, accepted):
    assert main(["run", "hello.toml", "--jobs", "1"]) == 0
    assert sc.load("hello.nc").attrs["title"] == "hello"
    assert sc.load("hello.nc").attrs["study"] == f'name = "hello"\n{HELLO}'
    assert main(["merge", "hello.nc", "--out", "both.nc"]) == 0
    assert sc.load("both.nc").attrs["title"] == "hello"
    sc.save(sc.run(sc.Study.parse(HELLO), jobs=1), "hello.nc")
    assert sc.load("hello.nc").attrs["title"] == "study"
    accepted("verify", "hello.nc", "--all")
    assert "found 12 of 16 trials" in accepted("run", "hello.toml", "--jobs", "1", "--trials", "4").err
    assert sc.load("hello.nc").attrs["title"] == "hello"


def test_ctrl_c_elsewhere_does_not_stop_a_background_run(no_ctrl_c, small_study, small_results):
    """A shell sends Ctrl-C to all that it began, and has what is in the background ignore it."""
    data = sc.run(small_study, jobs=1, progress=lambda _: signal.raise_signal(signal.SIGINT))
    assert data.drop_attrs(deep=False).identical(small_results.drop_attrs(deep=False))


@pytest.mark.long
def test_a_user_without_a_home_is_warned_once(here):
    """As in a container that runs under a number. Interpreted: where brains go is settled before they are compiled."""
    code = """
def nobody(_):
    raise KeyError
import pwd, sys
pwd.getpwuid = nobody
from swarmcensus.cli.commands import main
sys.exit(main(["run", "hello.toml", "--trials", "1"]))
"""
    kept = {k: v for k, v in os.environ.items() if k not in ("HOME", "XDG_CACHE_HOME", "SWARMCENSUS_CACHE")}
    (here / "scratch").mkdir()
    kept |= {"NUMBA_DISABLE_JIT": "1", "TMPDIR": str(here / "scratch")}
    ran = subprocess.run([sys.executable, "-c", code], env=kept, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr
    [warned] = [line for line in ran.stderr.splitlines() if "for this run alone" in line]
    assert "there is no home folder" in warned
    assert list((here / "scratch").iterdir()) == []
