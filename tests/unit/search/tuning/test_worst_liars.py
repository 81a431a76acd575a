"""A search for the worst liar: it finds what is known to harm most, speaks of harm, and says what it cannot do."""

import re
import tomllib
from pathlib import Path

import pytest

import swarmcensus as sc
from swarmcensus.support.errors import InputError
from tests.support.options import with_usual
from tests.support.second import changed

LIAR = '''"""It says `goal` plus a bump: the lie is largest at at = 0.6."""
PARAMETERS = {"at": 0.1, "idle": 1.0}
KNOWS = ("t",)

def lie(me, x):
    return max(1.0 - 2.0 * abs(me.at - 0.6), 0.0) if me.t > 0.0 else x
'''
# it believes the last message, and 0 if it has heard none
BRAIN = changed(
    ("MEMORY = {", 'PARAMETERS = {"share": 1.0}\nMEMORY = {"x": 0.0, '),
    ("(estimate(me),)", "(0.0,)"),
    ("message):\n    pass", "message):\n    me.x = max(me.x, me.share * message[0])"),
    ("return me.n / me.t if me.t > 0.0 else 0.5", "return me.x"),
)
STUDY = """
name = "harmed"
seed = 1
trials = 8
swarm = {brain = ["heard.py", "alone"], robots = 5, accuracy = 0.9}
world = {topology = ["full", "line"], fill_ratio = 0.0}
schedule = {rounds = 3}
[[members]]
robots = [0, 1]
brain  = [{file = "bump.py", at = 0.2}, "always-white"]
honest = false
[[members]]
robots   = 1
accuracy = 0.8
"""
pytestmark = pytest.mark.interpreted
TUNE = ["tune", "s.toml", "--adversary", "bump.py", "--brain", "heard.py", "--trials", "1"]
AT = ["--parameter", "at=0:1"]


@pytest.fixture
def here(here):
    for name, text in (("bump.py", LIAR), ("heard.py", BRAIN), ("s.toml", STUDY)):
        Path(name).write_text(text)
    return here


@pytest.mark.long
def test_worst_lie_is_found_and_written(here, refused, accepted):
    """The honest believe the largest of what is said: 1 - 2 |at - 0.6|, which is their error, as f is 0."""
    command = [*TUNE, "--parameter", "at=0:1", "--parameter", "idle=0:9", "--budget", "157"]
    out, err = accepted(*command)
    assert "searching bump.py" in err
    assert " idle=1 is worse for the swarm than bump.py at=0.2 idle=1 over all 2 worlds: better in 0%, w" in out
    assert "with the study's other liars: " in out
    assert "idle changes nothing in final_error, and stays at 1" in out
    assert out.splitlines()[-1].startswith("bump-worst.toml: ")
    text = Path("bump-worst.toml").read_text()
    [table] = tomllib.loads(text)["members"]
    [liar] = table.pop("brain")
    assert table == {"robots": [0, 1], "honest": False}
    assert liar.pop("at") == pytest.approx(0.6, abs=0.05)
    assert liar == {"file": "bump.py", "idle": 1.0}
    assert text.startswith("# bump.py, to harm heard.py most in the study 'harmed'")
    data = sc.load("bump-worst.nc")
    assert set(data["brain"].values) == {"heard.py", "alone"}
    assert len(set(data["adversary"].values)) == 4  # before, found, the other, nobody
    before = {path: path.read_bytes() for path in here.iterdir()}
    assert "found " in accepted(*command).err
    assert {path: path.read_bytes() for path in before} == before
    other = refused("tune", "s.toml", "--parameter", "share=0:1", "--budget", "13", "--out", "bump-worst.toml")
    assert "bump-worst.csv is of another search" in other
    members = re.search(r"\[\[members\]\]\n(.*\n)+?honest = false\n", STUDY)[0]
    pasted = STUDY.replace(members, re.sub("(?m)^#.*\n", "", text))
    assert sc.Study.parse(pasted, context={"base": here}).members[0].brain[0].parameters["at"] != 0.2


def test_a_liar_that_does_no_more_harm_is_reported(here):
    Path("s.toml").write_text(STUDY.replace("at = 0.2", "at = 0.6"))
    found = sc.tune("s.toml", ["at=0.7:0.9"], "heard.py", budget=13, trials=1, adversary="bump.py")
    assert found.verdict == "better"
    assert "is better for the swarm than bump.py at=0.6" in found.sentences[0]
    assert "There is no evidence that its values are worth anything" in found.text
    flat = sc.tune("s.toml", ["idle=0:1"], "heard.py", budget=13, trials=1, adversary="bump.py")
    assert (flat.verdict, flat.adversary) == ("not compared", flat.before)


MEMBERS = '[[members]]\nrobots = 1\nbrain = "bump.py"\nhonest = false\n'


@pytest.mark.parametrize(("old", "new", "changed", "said"), [
    ("", "", ["--adversary", "bum.py"], "--adversary bum.py"),
    ("", "", ["--adversary", "always-white"], "--adversary always-white"),
    ("", "", ["--parameter", "share=0:1"], "there is no 'share': the adversary 'bump.py' has at, idle"),
    ("", "", ["--budget", "5"], "--budget 5"),
    ('"alone"', '"oracle"', ["--brain", "oracle"], "--brain oracle"),
    ("[[members]]\nrobots   = 1\naccuracy = 0.8", MEMBERS, [], "members [0, 1] have it, and a search"),
    ("{file = \"bump.py\", at = 0.2}, ", "", [], "--adversary bump.py"),
])  # fmt: skip
def test_what_cannot_be_is_one_sentence(old, new, changed, said, here, refused):
    Path("s.toml").write_text(STUDY.replace(old, new) if old else STUDY)
    assert said in refused(*TUNE[:2], *with_usual(changed, TUNE[2:]), *AT)


def test_of_several_brains_one_is_named(here, refused):
    assert "--brain" in refused(*(word for word in TUNE if word not in ("--brain", "heard.py")), *AT)
    with pytest.raises(InputError, match=r"^adversary='bmp\.py': did you mean 'bump\.py'"):
        sc.tune("s.toml", ["at=0:1"], adversary="bmp.py")
