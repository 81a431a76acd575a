"""Readers are told where a robot converged before it had seen anything."""

import tomllib
import warnings
from pathlib import Path

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus.cli.commands import main
from swarmcensus.results import cautions_of_needs
from swarmcensus.results.cautions import settled_at_start, warn_of_start
from swarmcensus.support.files import shipped_study
from tests.support.small import study_of

STUDY = """
trials = 4
[swarm]
robots = 400
accuracy = 0.9
[world]
topology = "full"
fill_ratio = [0.5, 0.7]
[schedule]
rounds = 20
observations_per_round = 100
"""


def test_shares_are_of_the_robots_that_were_run(small_results):
    data = small_results.copy(deep=True)
    when = data["convergence_round"]
    when[:] = np.where(when >= 0, 5, when)
    assert (settled_at_start(data) == 0).all()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warn_of_start(data)
    robots = int(data["robots"][3])
    when[3, 0, :robots] = 0  # one trial of four
    when[3, 3] = -1
    when[4] = -1
    shares = settled_at_start(data)
    assert shares[3] == pytest.approx(1 / 3)
    assert np.isnan(shares[4])
    when[7, 0, 0] = 0
    with pytest.warns(UserWarning, match=r"^setting 3: 33 % of the robots have K = 0"):
        warn_of_start(data)
    when[:] = 0
    with pytest.warns(UserWarning, match=r"^settings 0, 1, 2, 3, 4, 5, 6, 7, \.\.\.: up to 100 % of"):
        warn_of_start(data)


def test_python_warns_of_what_the_shell_warns_of():
    study = sc.Study.parse(STUDY.replace("= 400", "= 2").replace("= 20", "= 1").replace("0.5, 0.7", "0.7"))
    with pytest.warns(UserWarning, match="fill ratio 0.7 lies on the edge between two of the 10 bins") as given:
        results = sc.run(study, jobs=1)
    assert [Path(one.filename).name for one in given] == ["test_cautions.py"], "once, at the caller's line"
    with pytest.warns(UserWarning, match="fill ratio 0.7 lies on the edge"):
        sc.summary(results)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sc.run(study, jobs=1, cautions=False)


def test_truths_on_the_edge_of_a_bin_are_warned_of(here, capsys):
    text = STUDY.replace("[0.5, 0.7]", "[0.2, 0.55, 0.7, 1.0]") + "[measure]\nestimates = true\n"
    (here / "s.toml").write_text(text)
    assert main(["run", "s.toml"]) == 0
    says = "warning: fill ratio 0.2, 0.7 lie on the edge between two of the 10 bins: about half of good estimates"
    assert capsys.readouterr().err.count(says) == 1
    assert main(["show", "s.nc", "--bins", "7"]) == 0
    assert "edge" not in capsys.readouterr().err
    assert main(["plot", "s.nc", "--kind", "decisions", "--bins", "20"]) == 0
    assert "fill ratio 0.2, 0.55, 0.7 lie on the edge between two of the 20 bins" in capsys.readouterr().err
    right = sc.load("s.nc")["correct"].isel(checkpoint=-1).mean("trial").values
    assert right[0] < 0.8 < 0.99 < right[1], "what it is about"


# claims about rivals are of decisions, asked where their sources asked
SHIPPED = [path for path in sorted(shipped_study("paper").parent.rglob("*.toml")) if path.parent.name != "claims"]


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_no_study_that_is_shipped_lies_on_an_edge(path):
    tables = tomllib.loads(path.read_text())
    ends = np.array([one["to"] if isinstance(one, dict) else one for one in listed(tables["world"]["fill_ratio"])])
    bins = tables.get("measure", {}).get("bins", 10)
    assert not np.isin(ends, np.arange(1, bins) / bins).any()


def listed(value):
    return value if isinstance(value, list) else [value]


@pytest.mark.interpreted
def test_brains_out_of_range_are_cautioned_of():
    study = study_of(["gated-mean", "alone", "voter"], 8, rounds=20, trials=2, measure={"bins": 2})
    data = sc.run(study, 1, cautions=False)
    late = (
        "gated-mean says nothing before round 451; this study has 20 (phase = 450, run = 0). It takes readings for the "
        "truth, so an accuracy of 0.7 biases its estimates (debiased = 0)"
    )
    early = "voter needs 230 rounds; this study has 20 (disseminate = 100, explore = 100, listen = 30)"
    silent = "gated-mean sent nothing in some trials, so robots were alone"
    assert cautions_of_needs(data.isel(setting=[1])) == []
    assert cautions_of_needs(data.isel(setting=[0, 1]), ["correct"]) == [late, silent]
    assert cautions_of_needs(data.isel(setting=[2]), ["right_side"])[0] == early
    asked = "voter: the answer is on which side of one half f is, so right_side measures it, not final_error"
    assert cautions_of_needs(data, ["final_error"])[-1] == asked
    assert {late, silent, asked} <= set(sc.compare(data, "final_error").cautions)
