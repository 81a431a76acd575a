"""Readers are told where a robot converged before it had seen anything."""

import re
import tomllib
import warnings
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import swarmcensus as sc
from swarmcensus.cli.commands import main
from swarmcensus.results.values import AGREEMENT
from swarmcensus.summaries.cautions import cautions_of_needs, cautions_of_start, settled_at_start, settled_far_off
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
    assert cautions_of_start(data) == []
    robots = int(data["robots"][3])
    when[3, 0, :robots] = 0  # one trial of four
    when[3, 3] = -1
    when[4] = -1
    shares = settled_at_start(data)
    assert shares[3] == pytest.approx(1 / 3)
    assert np.isnan(shares[4])
    when[7, 0, 0] = 0
    assert cautions_of_start(data)[0].startswith("setting 3: up to 33 % of the robots have K = 0")
    when[:] = 0
    assert cautions_of_start(data)[0].startswith("settings 0, 1, 2, 3, 4, 5, 6, 7, ...: up to 100 % of")


def test_python_warns_of_what_the_shell_warns_of():
    study = sc.Study.parse(STUDY.replace("= 400", "= 2").replace("= 20", "= 1").replace("0.5, 0.7", "0.7"))
    with pytest.warns(UserWarning, match="fill ratios on the edge between two of the 10 bins, 0.7: ") as given:
        results = sc.run(study, jobs=1)
    assert [Path(one.filename).name for one in given] == ["test_cautions.py"], "once, at the caller's line"
    with pytest.warns(UserWarning, match="on the edge between two of the 10 bins, 0.7: "):
        sc.summary(results)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sc.run(study, jobs=1, cautions=False)
        seen = []
        with pytest.raises(UserWarning, match=r"bins, 0\.7: "):
            sc.run(study, jobs=1, progress=seen.append)
    assert not seen, "before anything is run"


@pytest.fixture(scope="module")
def misjudged():
    """Robots misjudge their sensors. In a ring they stay apart; in a full network they agree."""
    swarm = {"robots": 30, "accuracy": 0.8, "assumed_accuracy": {"error": "U(-0.15, 0.15)"}}
    world = {"topology": ["full", "ring"], "fill_ratio": 0.35}
    return sc.run(sc.Study(trials=6, swarm=swarm, world=world, schedule={"rounds": 300}), jobs=1, cautions=False)


def test_robots_that_settle_early_and_apart_are_cautioned_of(misjudged, here, capsys):
    data = misjudged
    early = np.median(data["convergence_round"].values.astype(float), axis=(1, 2)) < 150
    assert early.all()
    assert settled_far_off(data).tolist() == [False, True]
    says = "setting 1 (minimalistic): K is early and misleads, since robots end far from each other or from the true "
    with pytest.warns(UserWarning, match=re.escape(says)):
        table = sc.summary(data)
    assert table["final_disagreement"][1] > 3 * 0.01 > 3 * table["final_disagreement"][0]
    assert [one.startswith(says) for one in sc.compare(data, factor="topology").cautions].count(True) == 1
    assert not any("misleads" in one for one in sc.compare(data, "final_error", factor="topology").cautions)
    sc.save(data, "s.nc")
    assert main(["show", "s.nc"]) == 0
    assert f"caution: {says}" in " ".join(capsys.readouterr().out.split())
    note = "K misleads in setting 1: settled early, but far from each other or from f"
    for draw, options in (
        (sc.plot.scatter, {}), (sc.plot.heatmap, {}), (sc.plot.lines, {"y": "convergence_round"})
    ):  # fmt: skip
        for settings, has in (([0], False), ([0, 1], True)):
            figure = draw(data.isel(setting=settings), **options)
            assert (note in " ".join(sc.plot.caption(figure).split())) == has
    assert "misleads" not in sc.plot.caption(sc.plot.heatmap(data, z="convergence_error"))


def test_robots_that_settle_late_or_decide_are_not_cautioned_of(misjudged):
    late, decided = misjudged.copy(deep=True), misjudged.copy()
    late["convergence_round"][:] = 200
    decided["decision"] = xr.zeros_like(misjudged["final_estimate"])
    before = misjudged.drop_vars([*AGREEMENT])  # a file of an earlier version
    assert [settled_far_off(one)[1] for one in (late, decided, before)] == [False, False, True]
    misjudged.attrs["delta"] = 0.05
    assert not settled_far_off(misjudged).any()


def test_truths_on_the_edge_of_a_bin_are_warned_of(here, capsys):
    text = STUDY.replace("[0.5, 0.7]", "[0.2, 0.55, 0.7, 1.0]") + "[measure]\nestimates = true\n"
    (here / "s.toml").write_text(text)
    assert main(["run", "s.toml"]) == 0
    says = "warning: fill ratios on the edge between two of the 10 bins, 0.2, 0.7: about half of good estimates"
    assert capsys.readouterr().err.count(says) == 1
    assert main(["show", "s.nc"]) == 0
    assert says.replace("warning", "caution") in capsys.readouterr().out
    assert main(["show", "s.nc", "--bins", "7"]) == 0
    assert "edge" not in "".join(capsys.readouterr())
    assert main(["plot", "s.nc", "--kind", "lines", "--x", "checkpoint", "--bins", "20"]) == 0
    edges = "on the edge between two of the 20 bins, 0.2, 0.55, 0.7: "
    assert capsys.readouterr().err.count(edges) == 1
    for kind, *asked in (
        ("lines", "--y", "correct"),
        ("heatmap", "--option", "z=correct"),
        ("lines", "--y", "final_error"),
        ("compare", "--option", "factor=fill_ratio", "--option", "metric=correct"),
        ("ranks", "--option", "factor=fill_ratio", "--option", "metric=correct"),
    ):
        assert main(["plot", "s.nc", "--kind", kind, *asked]) == 0
        assert ("bins, 0.2, 0.7: " in capsys.readouterr().err) == ("correct" in asked[-1])
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
    silent = "gated-mean sent nothing in all trials or some, so robots were alone there"
    assert cautions_of_needs(data.isel(setting=[1])) == []
    assert cautions_of_needs(data.isel(setting=[0, 1]), ["correct"]) == [late, silent]
    assert cautions_of_needs(data.isel(setting=[2]), ["right_side"])[0] == early
    asked = "voter: the answer is on which side of one half f is, so right_side measures it, not final_error"
    assert cautions_of_needs(data, ["final_error"])[-1] == asked
    assert {late, silent, asked} <= set(sc.compare(data, "final_error").cautions)
