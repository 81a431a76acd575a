"""What users begin with: `new`, `list studies` and `doctor`."""

import json
import shlex
import shutil
import subprocess
import sys
import tomllib

import pytest

import swarmcensus as sc
from swarmcensus.brains import load
from swarmcensus.checks.contract_checks import PROMISES
from swarmcensus.checks.suite import examine
from swarmcensus.cli.commands import doctor, main
from swarmcensus.studies.study import Study
from swarmcensus.support.files import shipped_studies
from tests.support.places import ROOT

pytestmark = pytest.mark.usefixtures("here")


def test_a_new_study_runs_and_has_its_file_s_name(here, accepted):
    printed = accepted("new", "study", "first try.toml")
    assert printed == ("first try.toml\n", "next: swarmcensus run 'first try.toml'\n")
    study = Study.load(here / "first try.toml")
    assert study.name == "first-try"
    assert "run first try.toml" in study.text
    assert len(sc.run(study.with_(trials=1), jobs=1)["setting"]) == len(study.settings()) == 48


def test_what_a_new_study_has_in_comments_is_right_too(here):
    main(["new", "study"])
    lines = (here / "my_study.toml").read_text().splitlines()
    taken = [line.removeprefix("# ") if " = " in line or line.startswith("# [[") else line for line in lines]
    still = [line for line in taken if not line.startswith(("topology     =", "rounds", "observations"))]
    found = Study.parse("\n".join(still))
    assert {setting.topology.name for setting in found.settings()} == {"moving"}
    assert all(setting.members and setting.faults for setting in found.settings())


def test_a_new_brain_keeps_the_contract(here, accepted):
    assert accepted("new", "brain") == ("my_brain.py\n", "next: swarmcensus brains --check my_brain.py\n")
    assert [one.fault for one in list(examine(load(here / "my_brain.py"), PROMISES))] == [None] * len(PROMISES)
    assert "THIS_FILE" not in (here / "my_brain.py").read_text()


def test_a_name_that_the_command_chose_is_printed_with_quiet_too(here, accepted):
    for words, out in (("study", "my_study.toml"), ("ring", "ring.toml"), ("study other.toml", "")):
        assert accepted("new", "--quiet", *words.split()).out.strip() == out


def test_all_shipped_studies_are_listed_with_what_they_are(accepted):
    _, *lines = accepted("list", "studies").out.splitlines()
    printed = dict(line.split(maxsplit=1) for line in lines)
    assert list(printed) == list(shipped_studies())
    assert all(len(words.split()) >= 3 for words in printed.values())
    assert printed["paper/local"].rstrip().endswith("Fig. 2a")


@pytest.mark.long(but_every=4)
@pytest.mark.long(only=["leaderboard", "beyond/changing", "rivals/opinions", "formats"])
@pytest.mark.parametrize("name", shipped_studies())
def test_each_is_copied_with_what_it_names(name, here, accepted):
    files = accepted("new", name, "copied/mine.toml").out.split()
    assert sorted(files) == sorted(str(path.relative_to(here)) for path in here.rglob("*") if path.is_file())
    copied, known = Study.load(here / "copied" / "mine.toml"), Study.load(shipped_studies()[name])
    assert len(copied.settings()) == len(known.settings())


OFFERED = {
    "pl": "plan plot", "plot --th": "--theory", "doctor --completion ": "bash fish zsh", "list ad": "adversaries",
    "run ri": "ring.toml", "brains --check ri": "ring.toml", "brains --show al": "alone", "deploy swi": "swift",
    "deploy swift --target k": "kilobot", "new stu": "study", "reproduce ri": "rivals", "new paper/mo": "paper/moving",
    "plot --kind hea": "heatmap",
}  # fmt: skip


@pytest.mark.skipif(shutil.which("bash") is None, reason="no bash here")
def test_bash_completes(here, accepted):
    (here / "ring.toml").write_text("")
    asked = accepted("doctor", "--completion", "bash").out
    for line in OFFERED:
        words = ["swarmcensus", *line.split(" ")]
        asked += f"COMP_WORDS=({' '.join(map(shlex.quote, words))}); COMP_CWORD={len(words) - 1}; COMPREPLY=()\n"
        asked += "_swarmcensus; echo ${COMPREPLY[@]}\n"
    printed = subprocess.run(["bash"], input=asked, check=True, capture_output=True, encoding="utf-8").stdout
    assert [" ".join(sorted(line.split())) for line in printed.splitlines()] == [*OFFERED.values()]


def test_a_doctor_names_what_there_is(here, monkeypatch, accepted):
    monkeypatch.setenv("SWARMCENSUS_CACHE", str(here / "cache"))  # whose size changes while other tests compile
    printed = accepted("doctor").out
    found = json.loads(accepted("doctor", "--json").out)
    parts = {row["part"]: row["found"] for row in found["rows"]}
    assert parts["swarmcensus"] == sc.__version__
    assert found["python"] == ".".join(map(str, sys.version_info[:3]))
    assert all(part in printed and text in printed for part, text in parts.items())
    assert {*doctor.LIBRARIES} < {row["part"] for row in found["rows"] if row["works"]}
    assert found["sentences"] == ["all that is required works"]
    assert {"usable"} < found["card"].keys()
    assert "graphics card" in parts
    declared = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"]
    works = {row["part"].removeprefix("extra "): row["works"] for row in found["rows"]}
    assert declared.keys() < works.keys()
    assert not works["gpu12"]  # another version of what the tests' own extra has
    assert all(works[name] for name in ("parquet", "film", "cluster", "tune", "watch", "ros", "test"))


def test_it_says_what_is_missing(here, monkeypatch, capsys):
    (here / "file").write_text("")
    monkeypatch.setenv("SWARMCENSUS_CACHE", str(here / "file" / "cache"))
    monkeypatch.setattr(doctor, "LIBRARIES", ("numpy", "swarmcensus-of-bees"))
    monkeypatch.setattr(doctor, "_version", lambda name: "9" * (name == "numpy"))
    assert main(["doctor"]) == 2
    printed = capsys.readouterr().out
    assert "not installed: pip install 'swarmcensus[film]'" in printed
    assert "swarmcensus-of-bees: not installed: pip install swarmcensus" in printed
    assert "no compiled code can be stored there, every run compiles: set $SWARMCENSUS_CACHE to another" in printed
    monkeypatch.setattr("importlib.metadata.Distribution.discover", lambda **_: iter(()))  # as in a checkout as it is
    main(["doctor"])
    assert "graphics card" in capsys.readouterr().out


def test_new_files_overwrite_nothing(here, refused):
    for words in ("new brain", "new example/compare own/c.toml", "new example/ranking own/r.toml"):
        assert main(words.split()) == 0
    assert "another my_brain.py exists, and the study needs its own" in refused("new", "example/compare")
    assert "my_brain.py already exists: name another file" in refused("new", "brain")
    names = {"my_brain.py", "own", "own/c.toml", "own/r.toml", "own/my_brain.py"}
    assert {str(path.relative_to(here)) for path in here.rglob("*")} == names
    shipped = shipped_studies()["example/compare"].with_name("my_brain.py")
    assert (here / "own" / "my_brain.py").read_text() == shipped.read_text()


def test_a_link_that_leads_nowhere_is_not_written_through(here, refused):
    (here / "my_brain.py").symlink_to("gone.py")
    assert "my_brain.py already exists" in refused("new", "brain")
    assert not (here / "gone.py").exists()
