"""The command line, as a user meets it: what it prints, what it writes, how it fails."""

import os
import re
import signal
import subprocess
import sys
import time

import pytest

import swarmcensus as sc
from swarmcensus import brains
from swarmcensus.cli.commands import main
from tests.support.small import SMALL

HELLO = """
trials = 3
[swarm]
robots = 6
accuracy = [0.7, 0.9]
[world]
topology = "ring"
fill_ratio = [0.55, 0.95]
[schedule]
rounds = 20
"""


@pytest.fixture(autouse=True)
def hello(here):
    (here / "hello.toml").write_text(HELLO)


def test_a_first_session(here, capsys):
    assert main(["run", "hello.toml", "--jobs", "2"]) == 0
    out = capsys.readouterr().out
    assert "4 settings of 3 trials" in out
    assert "right" in out
    assert main(["export", "hello.nc", "--where", "accuracy == 0.7"]) == 0
    assert "36 rows" in capsys.readouterr().out
    for kind in ("scatter", "lines", "heatmap", "curves"):
        assert main(["plot", "hello.nc", "--kind", kind]) == 0
        assert (here / f"hello-{kind}.png").stat().st_size > 10_000
        assert (here / f"hello-{kind}.svg").exists()
    assert main(["plot", "hello.nc", "--where", "fill_ratio < 0.6", "--out", "x.pdf"]) == 0
    assert (here / "x.pdf").exists()
    capsys.readouterr()
    replay = ["replay", "hello.nc", "--setting", "1", "--trial", "2", "--out", "t.nc", "--plot", "t.png"]
    assert main([*replay, "--recording", "rec"]) == 0
    assert "accuracy 0.7, f = 0.95" in capsys.readouterr().out
    infer = ["infer", "rec/observations.csv", "--links", "rec/links.csv", "--accuracy", "0.7"]
    assert main([*infer, "--out", "again.csv"]) == 0
    assert (here / "again.png").exists()
    assert {p.suffix for p in here.iterdir() if p.is_file()} == {".toml", ".nc", ".csv", ".png", ".svg", ".pdf", ".txt"}
    last = (here / "again.csv").read_text().splitlines()[-1].split(",")
    assert float(last[-1]) == sc.load("hello.nc")["final_estimate"].values[1, 2, -1]


def test_seed_and_trials_and_a_share_can_be_given(here, capsys):
    assert main(["run", "hello.toml", "--trials", "2", "--seed", "5", "--out", "a.nc"]) == 0
    data = sc.load("a.nc")
    assert (data.sizes["trial"], data.attrs["seed"]) == (2, 5)
    assert main(["run", "hello.toml", "--share", "1/2", "--out", "b.nc"]) == 0
    said = capsys.readouterr()
    assert "b.nc: share 1/2 of 4 settings of 3 trials" in said.out
    assert "next: with the other shares, swarmcensus merge b.nc ... --out ALL.nc" in said.err
    assert main(["replay", "a.nc", "--setting", "0", "--trial", "1"]) == 0


def test_brains(here, capsys, untraced_processes):
    assert main(["brains"]) == 0
    out = capsys.readouterr().out
    assert re.search(r"minimalistic +48 +8  ", out)  # as wide as the longest name asks
    estimates, opinions, *_ = re.split(r"^brain ", out, flags=re.MULTILINE)[1:]
    assert "\nlegacy " in estimates
    assert "\nvoter* " in opinions  # whose estimate is 0 or 1
    assert re.search(r"forger +value 1, names 1,000,000  It says", out)
    (here / "mine.py").write_text(brains.load("minimalistic").source.replace("def fuse", "def fuze"))
    assert main(["brains", "--check", "mine.py"]) == 2
    assert "the function fuse is missing" in capsys.readouterr().out


@pytest.mark.long
def test_a_brain_that_conforms_is_said_to(here, capsys, untraced_processes):
    (here / "mine.py").write_text(brains.load("minimalistic").source)
    assert main(["brains", "--check", "mine.py"]) == 0
    assert "mine.py keeps the contract" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("robots", "robot"), "study file hello.toml: unknown key swarm.robot"),
        (("= 6", '= "six"'), 'swarm.robots = "six"'),
        (("[0.7, 0.9]", "[]"), "swarm.accuracy = []"),
        (("= 20", "= -20"), "schedule.rounds = -20"),
        (('"ring"', '{name = "x", edges = [[0, 6]]}'), "edge (0, 6) of topology 'x' leads to a robot"),
        (("[swarm]", '[swarm]\nbrain = "broken.py"'), "broken.py, line 1: not Python"),
        (("[swarm]", '[swarm]\nbrain = "lame.py"'), "lame.py: the function fuse is missing"),
    ],
)
def test_bad_studies(change, said, here, refused):
    (here / "hello.toml").write_text(HELLO.replace(*change))
    (here / "broken.py").write_text("def observe(:\n")
    (here / "lame.py").write_text(brains.load("minimalistic").source.replace("def fuse", "def fuze"))
    assert said in refused("run", "hello.toml")


def test_an_empty_text_is_no_file(refused):
    assert """STUDY.toml '': should name a file or folder""" in refused("run", "")


@pytest.mark.parametrize(
    ("command", "said"),
    [
        ("run none.toml", "study file none.toml: there is no such file"),
        ("leaderboard none.py", "brain 'none.py': there is no such file"),
        ("run hello.toml --out hello.toml/x.nc", "cannot write hello.toml/x.nc"),
        ("run hello.toml --out folder.nc", "cannot write folder.nc: it is a folder"),
        ("run hello.toml --jobs 9999", "swarmcensus: --jobs 9999: should be 1 to "),
        ("run folder.nc", "study file folder.nc: cannot be read: Is a directory"),
        ("run /dev/zero", "study file /dev/zero: cannot be read: it is a device"),
        ("run good.nc", "good.nc holds results, not a study: see them with swarmcensus show good.nc"),
        ("verify good.nc --all --seed 3", "--seed 3"),
        ("show cut.nc", "results file cut.nc: not a readable netCDF-4 file"),
        ("show /dev/null", "results file /dev/null: it is no file"),
        ("show hello.toml", "hello.toml is a study, not results: first run it with swarmcensus run hello.toml"),
        ("show good.nc --where setting==1==1", "a chain has a coordinate between"),
        ("merge good.nc folder.nc --out x.nc", "results file folder.nc: it is a folder"),
        ("plot good.nc --where robots==99", "no setting is so"),
        ("plot good.nc --out x.bmp", "figures are written as"),
        ("plot good.nc --kind heatmap --local", "--local goes with --kind scatter"),
        ("plot good.nc --local", "local"),
        ("plot good.nc --local --delta 0.1", "--local does not go with --delta"),
        ("replay good.nc --setting 77 --trial 0", "setting 77: these results hold"),
        ("replay good.nc --setting 0 --trial 0 --out new.nc --recording obs.csv", "obs.csv is a file, not a folder"),
        ("export good.nc --format parquet --out x.csv", "--format parquet is written as .parquet"),
        ("infer none.csv --accuracy 0.8", "none.csv: there is no such file"),
        ("infer obs.csv --accuracy x", "accuracy 'x': there is no such file, and a sensor"),
        ("infer obs.csv --accuracy 0.8 --links bad.csv", "names a robot that is not there"),
        ("infer obs.csv --accuracy 0.8 --plot folder.png", "cannot write folder.png: it is a folder"),
        ("reproduce --out hello.toml/x", "cannot write"),
    ],
)
def test_bad_commands(command, said, here, refused, small_file):
    whole = small_file.read_bytes()
    (here / "good.nc").write_bytes(whole)
    (here / "cut.nc").write_bytes(whole[: len(whole) // 2])
    (here / "obs.csv").write_text("1,1\n0,1\n")
    (here / "bad.csv").write_text("0,2\n")
    for name in ("folder.nc", "folder.png"):
        (here / name).mkdir()
    assert said in refused(*command.split())


@pytest.mark.parametrize(
    ("command", "said"),
    [
        ("deploy commons robot --accuracy nan --target udp", "--accuracy nan: "),
        ("deploy commons --robot -1", "deploy: --robot -1: should be a whole number from 0"),
        ("run hello.toml --jobs 0", "run: --jobs 0: should be a whole number from 1"),
        ("run x.toml --trials", "run: --trials: a value is missing after it"),
        ("run -- x.toml --trials 2", "run: --trials stands after --, where only names of files do"),
        ("run x.toml y.toml", "run: y.toml is an argument too many: 'swarmcensus run --help' shows what there is"),
        ("merge --ouu x a.nc", "merge: --ouu is no option of this command: did you mean '--out'?"),
        ("new study --schme", "new: --schme is no option of this command: did you mean '--schema'?"),
        ("show x.nc --quiet=3", "show: --quiet takes no value, but has '3'"),
        ("swarm sure --jiter 2", "swarm: --jiter is no option of this command: did you mean '--jitter'?"),
        ("swarm --jit=2", "swarm: --jit is no option of this command: did you mean '--jitter'?"),
        ("show x.nc --sort=", "show: --sort '': should not be empty"),
        ("compare x.nc --margin 1_0", "compare: --margin 1_0: should be a number, or NAME=number"),
        ("run x.toml --share ١/٤", "should be such as 1/4"),
        ("swarm", "swarm: BRAIN|STUDY.toml is missing: 'swarmcensus swarm --help' shows what there is"),
        ("replay x.nc", "replay: --setting is missing: 'swarmcensus replay --help' shows what there is"),
        ("brains --show a --check b", "brains: --show does not go with --check"),
        ("brains --show commons --json", "--json does not go with an option that prints a program or a document"),
        ("show x.nc --quiet --verbose", "show: --verbose does not go with --quiet"),
        ("run x.toml --trials 3 --trials 4", "run: --trials is given twice, and holds one value"),
        ("brains --cost swift --cost sure", "--cost is given twice, and holds one value"),
        ("brains swift", "swift is an argument too many: did you mean 'swarmcensus brains --show swift'?"),
        ("brains x.py", "did you mean 'swarmcensus brains --check x.py'?"),
        ("show x.nc --where a==1 --where b==2", "show: --where is given twice, and holds one value"),
    ],
)
def test_errors_of_options_are_one_sentence(command, said, refused):
    assert said in refused(*command.split())


def test_blind_sensors_are_allowed_with_a_warning(here, capsys):
    (here / "hello.toml").write_text(HELLO.replace("[0.7, 0.9]", "0.5"))
    assert main(["run", "hello.toml"]) == 0
    assert "warning: study file hello.toml: accuracy 0.5 carries no information" in capsys.readouterr().err
    assert (sc.load("hello.nc")["final_estimate"] == 0.5).all()


def test_a_folder_without_permission(refused, monkeypatch):
    monkeypatch.setattr(os, "access", lambda path, mode: False)
    assert "cannot be written" in refused("run", "hello.toml", "--out", "locked/x.nc")


@pytest.mark.long(but=["a user without a home"])
@pytest.mark.parametrize("known", [True, False], ids=["a home that is a file", "a user without a home"])
def test_run_without_a_cache_folder_warns_once(here, known):
    """Interpreted, so that it is quick: where brains go is settled before they are compiled."""
    (here / "hello.toml").write_text(HELLO.replace("[swarm]", '[swarm]\nbrain = ["minimalistic", "legacy"]'))
    (here / "scratch").mkdir()
    code = "import os, pwd, sys; from swarmcensus.cli.commands import main"
    if not known:  # as in a container that runs under a number
        code += "\ndef nobody(_): raise KeyError\npwd.getpwuid = nobody"
    kept = {k: v for k, v in os.environ.items() if k not in ("HOME", "XDG_CACHE_HOME", "SWARMCENSUS_CACHE")}
    kept |= {"NUMBA_DISABLE_JIT": "1", "TMPDIR": str(here / "scratch")}
    ran = subprocess.run(
        [sys.executable, "-c", f"{code}\nsys.exit(main(['run', 'hello.toml', '--trials', '1']))"],
        env=kept | ({"HOME": str(here / "hello.toml")} if known else {}),
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert ran.returncode == 0, ran.stderr
    warned = [line for line in ran.stderr.splitlines() if "for this run alone" in line]
    assert len(warned) == 1
    assert ("hello.toml/.cache/swarmcensus cannot be used" if known else "there is no home folder") in warned[0]
    assert sc.load("hello.nc").attrs["trials_done"] == 8
    assert list((here / "scratch").iterdir()) == []


def test_ctrl_c_stops_within_a_second_and_keeps_what_is_done(here):
    text = SMALL.replace("trials = 4", "trials = 300").replace("rounds                 = 60", "rounds = 200_000")
    (here / "long.toml").write_text(text.replace("[10, 60]", "[10]"))
    code = (
        "from swarmcensus.cli.commands import main; from swarmcensus.runs import progress; "
        "progress.LINE_SECONDS = 0.2; raise SystemExit(main())"
    )
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
    done = int((~data["final_estimate"].isel(robot=0).isnull()).sum())
    assert data.attrs["trials_done"] == done > 0
    assert took < 10  # saving is most of it; that threads stop at once is tested in the engine


def test_a_study_without_a_name_is_called_as_its_file_is(here, capsys):
    assert main(["run", "hello.toml", "--jobs", "1"]) == 0
    assert sc.load("hello.nc").attrs["title"] == "hello"
    assert sc.load("hello.nc").attrs["study"] == f'name = "hello"\n{HELLO}'
    assert main(["verify", "hello.nc", "--all"]) == 0
    assert main(["merge", "hello.nc", "--out", "both.nc"]) == 0
    assert main(["verify", "both.nc"]) == 0
    assert sc.load("both.nc").attrs["title"] == "hello"
    sc.save(sc.run(sc.Study.parse(HELLO), jobs=1), "hello.nc")
    assert sc.load("hello.nc").attrs["title"] == "study"
    assert main(["verify", "hello.nc", "--all"]) == 0
    capsys.readouterr()
    assert main(["run", "hello.toml", "--jobs", "1", "--trials", "4"]) == 0
    assert "found 12 of 16 trials" in capsys.readouterr().err
    assert sc.load("hello.nc").attrs["title"] == "hello"


def test_ctrl_c_elsewhere_does_not_stop_a_background_run(no_ctrl_c, small_study, small_results):
    """A shell sends Ctrl-C to all that it began, and has what is in the background ignore it."""
    data = sc.run(small_study, jobs=1, progress=lambda _: signal.raise_signal(signal.SIGINT))
    assert data.drop_attrs(deep=False).identical(small_results.drop_attrs(deep=False))
