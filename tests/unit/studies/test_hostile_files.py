"""Small files that would take minutes or all memory are refused in a sentence."""

import os
import time

import pytest

import swarmcensus as sc
from swarmcensus.studies import study as studies
from swarmcensus.support.errors import LONGEST
from swarmcensus.support.plugins import MOST_SOURCE

LONG = 50_000
STUDY = """trials = 2
swarm = {brain = BRAIN, robots = ROBOTS, accuracy = 0.8}
world = {topology = TOPOLOGY, fill_ratio = FILL}
"""
USUAL = {"BRAIN": '"minimalistic"', "ROBOTS": "5", "TOPOLOGY": '"ring"', "FILL": "0.5"}


def study(**values):
    text = STUDY
    for key, value in (USUAL | values).items():
        text = text.replace(key, value)
    return text


def shares(count):
    return f"[{', '.join(f'0.{k:06d}' for k in range(1, count))}]"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a." * LONG + "a = 1", "x.toml: its keys, tables or lists are nested over 32 deep"),
        ("a = {" + "a.b.c." * 5 + "a.b={" + "a.b.c." * 5 + "a = 1}}", "nested over 32 deep"),
        ("a = " + "[" * LONG, "nested over 32 deep"),
        ("a = " + "{a=" * LONG, "nested over 32 deep"),
        ("a = " + "9" * LONG, "x.toml: a whole number has too many digits"),
        ("k" * LONG + " = 1", "x.toml: unknown key kkk"),
        (study(TOPOLOGY=f'"{"k" * LONG}"'), "x.toml: 'kkk"),
        (study(BRAIN=f'"{"k" * LONG}.py"'), "x.toml: 'kkk"),
        (study(FILL=shares(4000), BRAIN='["alone", "minimalistic"]', ROBOTS=str([*range(3, 50)])),
         "x.toml: its lists span 375,906 settings; 250,000 is the most"),
        (study(ROBOTS=str([*range(3, 60_000)])), "swarm.robots has 59,997 values; 10,000 is the most"),
        (study(BRAIN=str([f"b{k}" for k in range(85_000)])), "swarm.brain has 85,000 values; 10,000 is the most"),
        ("[[case]]\nrobots = 1\n" * 40_000, "case has 40,000 values; 10,000 is the most"),
        (study(ROBOTS=str([*range(990_000, 1_000_000)])), "10,000 settings of 1 trial make "),
        (study(BRAIN='"big.py"'), "big.py: cannot be read: it is over 125,000 bytes"),
        (study(BRAIN='"deep.py"'), "deep.py: its brackets or operators are nested too deep"),
        (study(BRAIN='"pipe.py"'), "pipe.py"),
    ],
)  # fmt: skip
def test_small_files_take_little(text, said, here, refused, monkeypatch):
    monkeypatch.setattr(studies, "all_settings", lambda *_: pytest.fail("the settings were listed"))
    (here / "x.toml").write_text(text)
    (here / "big.py").write_text("x = 1\n" * (MOST_SOURCE // 6 + 1))
    (here / "deep.py").write_text("x = " + "-" * 100_000 + "1\n")
    os.mkfifo(here / "pipe.py")
    begun = time.process_time()
    error = refused("run", "x.toml")
    assert time.process_time() - begun < 20.0
    assert said in error
    assert len(error) < LONGEST + 200


def test_what_is_not_a_file_is_not_read(here, refused):
    os.mkfifo(here / "pipe.toml")
    assert "pipe.toml: cannot be read: it is a device or a pipe, not a file" in refused("run", "pipe.toml")


def test_many_values_of_a_parameter_are_of_one_file(here):
    brains = ", ".join(f'{{file = "bayes-bots", prior = {k}}}' for k in range(1, 1500))
    begun = time.process_time()
    assert len(sc.Study.parse(study(BRAIN=f"[{brains}]"), context={"base": here}).brains) == 1
    assert time.process_time() - begun < 20.0
