"""PARAMETERS: numbers that a brain only reads, and a study sweeps."""

import itertools
import re

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus.engine import compiler
from swarmcensus.studies import addresses
from tests.support.second import MEANS, brain, changed

OF_PRIOR = "return (me.n + me.prior * me.among[1]) / (me.t + me.prior) * (1.0 - me.among[0])"
PRIOR = changed(
    ("MEMORY =", 'PARAMETERS = {"prior": 10.0, "among": (0.25, 0.75)}\nMEMORY ='),
    ("return me.n / me.t if me.t > 0.0 else 0.5", OF_PRIOR),
)
STUDY = """
name = "swept"
seed = 4
trials = 2
swarm.brain = ["plain.py", {file = "prior.py", prior = [1, 10.0, 40], among = [[0.25, 0.75], [0.0, 0.5]]}]
swarm.robots = 4
swarm.accuracy = 0.8
world = {topology = "ring", fill_ratio = 0.55}
schedule.rounds = 6
"""


@pytest.fixture
def here(here):
    (here / "plain.py").write_text(MEANS)
    (here / "prior.py").write_text(PRIOR)
    (here / "s.toml").write_text(STUDY)
    return here


@pytest.mark.interpreted
def test_every_combination_is_a_setting(here):
    data = sc.run(sc.Study.load("s.toml"), jobs=1)
    told = list(zip(data["brain"].values, data["prior"].values, data["among"].values, strict=True))
    assert told[0][0] == "plain.py"
    assert np.isnan(told[0][1])
    assert [one[1:] for one in told[1:]] == [*itertools.product((1.0, 10.0, 40.0), ("(0.25, 0.75)", "(0, 0.5)"))]
    assert len(set(data["fingerprint"].values.tolist())) == 7


@pytest.mark.interpreted
def test_the_values_are_what_the_brain_reads(here):
    """By hand: the estimate is what the formula makes of the counts of the brain that has no prior."""
    data = sc.run(sc.Study.load("s.toml"), jobs=1)
    black = data["final_estimate"].values[0] * 60.0
    for k, (low, high) in zip(range(1, 7), [(0.25, 0.75), (0.0, 0.5)] * 3, strict=True):
        prior = float(data["prior"][k])
        expected = (black + prior * high) / (60.0 + prior) * (1.0 - low)
        assert data["final_estimate"].values[k] == pytest.approx(expected, rel=1e-14)


def test_the_files_own_value_need_not_be_said(here):
    said, unsaid = (
        sc.Study.parse(STUDY.replace("prior = [1, 10.0, 40], among = [[0.25, 0.75], [0.0, 0.5]]", text)).settings()[1]
        for text in ("prior = 10, among = [0.25, 0.75]", "among = [0.25, 0.75]")
    )
    assert said == unsaid
    assert addresses.fingerprint(said, 4) == addresses.fingerprint(unsaid, 4)


def test_other_values_need_no_other_machine_code():
    plain = brain(PRIOR)
    swept = plain.with_parameters({"prior": 3, "among": (0.5, 0.5)})
    assert compiler.compile_brain(plain) is compiler.compile_brain(swept)
    assert (compiler.array_layout(swept).blank.view(np.float64) == [0, 0, 3, 0.5, 0.5, 0, 0]).all()


@pytest.mark.parametrize(("old", "new", "said"), [
    ("prior = [1", "prio = [1", "no parameter 'prio': did you mean 'prior'"),
    ('["plain.py"', '[{file = "plain.py", prior = 1}', "'plain.py' has no parameter 'prior': it has none"),
    ("[1, 10.0, 40]", "true", "prior = True: not a number"),
    ("[1, 10.0, 40]", "nan", "prior = nan: not a number"),
    ("[1, 10.0, 40]", "[]", "prior = []"),
    ("[1, 10.0, 40]", "[1, 1.0]", "two entries of swarm.brain have one name: plain.py, prior.py prior=1.0"),
    ("[1, 10.0, 40]", "[[1, 2]]", "prior = [1, 2]"),
    ("[[0.25, 0.75], [0.0, 0.5]]", "[0.1, 0.2, 0.3]", "among = [0.1, 0.2, 0.3]"),
    ("[[0.25, 0.75], [0.0, 0.5]]", "0.5", "among = 0.5"),
    ("[[0.25, 0.75], [0.0, 0.5]]", "[[0.1, nan]]", "among = [0.1, nan]: not a number"),
    ('file = "prior.py", ', "", "a brain with parameters is a table such as"),
])  # fmt: skip
def test_wrong_values_are_named(here, old, new, said):
    assert old in STUDY
    with pytest.raises(sc.InputError, match=rf"(?=.*swarm\.brain).*{re.escape(said)}"):
        sc.Study.parse(STUDY.replace(old, new))


@pytest.mark.parametrize("name", ["robots", "trial", "final_estimate", "members"])
def test_a_name_that_results_have_taken_is_refused(here, name):
    (here / "prior.py").write_text(PRIOR.replace('"prior"', f'"{name}"').replace("me.prior", f"me.{name}"))
    with pytest.raises(sc.InputError, match=f"a parameter '{name}', a name that is taken in the results"):
        sc.Study.parse(STUDY.replace("prior = [1, 10.0, 40], ", ""))
