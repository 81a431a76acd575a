"""Summaries: what `swarmcensus show` and `summary` say of results, of those that are not whole too."""

import io
import json
import re
import tomllib
import warnings
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from rich.console import Console

import swarmcensus as sc
from swarmcensus.results.values import AGREEMENT
from swarmcensus.summaries import measures, table_of_summary
from swarmcensus.summaries.cautions import cautions_of_needs, cautions_of_start, settled_at_start, settled_far_off
from swarmcensus.summaries.table_of_summary import Summary
from swarmcensus.support import intervals
from swarmcensus.support.files import shipped_study
from swarmcensus.support.printed_tables import REST
from swarmcensus.support.quantities import nine_of_ten
from tests.support.small import study_of

MANY = """
trials   = 6
swarm    = {robots = [2, 3], accuracy = [0.6, 0.7, 0.8, 0.9, "U(0.525,0.975)", {black = 0.9, white = 0.625}]}
world    = {topology = ["ring", "full"], fill_ratio = 0.55}
schedule = {rounds = [5, 8]}
measure  = {checkpoints = [2, 5, 8]}
"""


@pytest.fixture(scope="module")
def many():
    return sc.run(sc.Study.parse(MANY))


@pytest.fixture(scope="module")
def partial(many):
    """Trials from 2 on are missing in setting 1, all in setting 2; a trial of setting 4 failed."""
    data = many.copy(deep=True)
    for setting, trials in ((1, slice(2, None)), (2, slice(None)), (4, slice(3, 4))):
        for name in ("convergence_round", "convergence_error", "final_estimate", "agreement_round", "components",
                     "mean_degree", "messages_sent", "messages_heard"):  # fmt: skip
            data[name].values[setting, trials] = np.nan
        for name in ("correct", "disagreement"):
            data[name].values[setting, :, trials] = np.nan
    data.attrs["failed"] = json.dumps([{"setting": 4, "trial": 3, "why": "division by zero"}])
    data.attrs["trials_done"] -= 4 + 6 + 1
    return data


@pytest.fixture
def file(many, here):
    sc.save(many, "many.nc")
    return "many.nc"


def test_error_90_is_the_smallest_error_that_nine_of_ten_robots_keep():
    random = np.random.default_rng(5)
    by_hand = [nine_of_ten(random.permutation(robots) + 1.0) for robots in (1, 2, 9, 10, 11, 17, 20, 21, 100)]
    assert by_hand == [1, 2, 9, 9, 10, 16, 18, 19, 90]
    for robots in range(1, 200):
        errors = random.integers(0, 40, robots) / 100
        assert nine_of_ten(errors) == min(one for one in errors if 10 * (errors <= one).sum() >= 9 * robots)
    assert np.isnan(nine_of_ten(np.array([[0.1, np.nan]])))


def test_a_row_is_what_numpy_says_of_the_setting(many):
    for k, row in enumerate(sc.summary(many).to_dict("records")):
        robots, rounds = int(many["robots"][k]), int(many["rounds"][k])
        for name in ("convergence_round", "convergence_error"):
            values = many[name].values[k, :, :robots].astype(float)
            _, low, high = intervals.estimate(values, "median")
            high = min(high, rounds) if "round" in name else high
            assert row[name] == np.median(values)
            assert (row[f"{name}_low"], row[f"{name}_high"]) == (max(low, 0), high)
        right = many["correct"].sel(checkpoint=rounds).values[k]
        assert row["checkpoint"] == rounds
        assert row["correct"] == pytest.approx(right.mean())
        ends = intervals.estimate(right[:, np.newaxis], "mean", share=True)[1:]
        assert (row["correct_low"], row["correct_high"]) == ends
        assert (row["trials"], row["failed"], row["setting"]) == (6, 0, k)


def test_what_is_missing_is_said(partial):
    frame = sc.summary(partial)
    assert frame["trials"].tolist()[:6] == [6, 2, 0, 6, 5, 6]
    assert frame["failed"].tolist()[:6] == [0, 0, 0, 0, 1, 0]
    robots = int(partial["robots"][1])
    assert frame["convergence_error"][1] == np.median(partial["convergence_error"].values[1, :2, :robots])
    assert frame["correct"][1] == partial["correct"].sel(checkpoint=8).values[1, :2].mean()
    assert np.isnan(frame["convergence_error_low"][[1, 2, 4]]).all()  # fewer than 6 trials
    assert np.isnan(frame[["convergence_round", "convergence_error", "correct"]].loc[2]).all()
    assert frame.drop(index=[1, 2, 4]).notna().drop(columns=["density", "side"]).all(axis=None)


def test_the_round_of_right_can_be_chosen(many):
    frame = sc.summary(many, checkpoint=8)
    short = many["rounds"].values == 5
    assert (frame["checkpoint"] == np.where(short, -1, 8)).all()
    assert (frame["correct"].isna() == short).all()
    early = sc.summary(many, "rounds == 5", checkpoint=2)
    assert early["correct"].tolist() == many["correct"].values[short, 0].mean(axis=1).tolist()
    with pytest.raises(sc.InputError, match="checkpoint=3: decisions were recorded after round 2, 5, 8"):
        sc.summary(many, checkpoint=3)


def test_show_prints_a_line_a_setting_whole(file, accepted, monkeypatch):
    """Neither folded nor cut short where there is no terminal, however narrow one is said to be."""
    monkeypatch.setenv("COLUMNS", "40")
    first, same, heads, *lines = accepted("show", file, "--limit", "0").out.splitlines()
    assert first == f"{file}: many (seed 0, swarmcensus {sc.__version__}): 48 settings, 288 of 288 trials done"
    assert heads.split()[:5] == ["setting", "topology", "robots", "accuracy", "rounds"]
    for k, (line, row) in enumerate(zip(lines, sc.summary(file).to_dict("records"), strict=False)):
        shown = [str(k), row["topology"], str(row["robots"]), *row["accuracy"].split()]
        assert line.split()[: len(shown)] == shown
        assert line.count("[") == line.count("]") >= 5  # agreement has none if it is never reached
    assert not any("…" in line or "..." in line for line in lines)
    assert len(lines) == 48 + 2
    assert same == "all with brain minimalistic, fill_ratio 0.55, observations_per_round 10"


@pytest.mark.long
def test_show_sorts(file, many, accepted):
    def shown(*options):
        words = [line.split() for line in accepted("show", file, "--limit", "0", *options).out.splitlines()]
        return [int(first) for first, *_ in words if first.isdigit()]

    frame = sc.summary(many)
    assert shown("--sort", "error at K") == frame.sort_values("convergence_error", kind="stable")["setting"].tolist()
    assert (np.diff(frame["convergence_error"][shown("--sort", "error at K", "--reverse")]) <= 0).all()
    last = frame["rounds"][shown("--sort", "right", "--checkpoint", "8", "--reverse")].tolist()
    assert last == [8] * 24 + [5] * 24  # what is missing comes last, whichever way


def test_large_results_are_summed_up_in_blocks(partial, monkeypatch):
    whole = sc.summary(partial)
    monkeypatch.setattr(measures, "BLOCK", 50)
    pd.testing.assert_frame_equal(sc.summary(partial), whole)


@pytest.mark.parametrize(("options", "said"), [
    (["--checkpoint", "7"], "checkpoint 7: decisions were recorded after round 2, 5, 8"),
    (["--sort", "eror"], "--sort eror"),
    (["--reverse"], "--reverse needs --sort"),
])  # fmt: skip
def test_what_cannot_be_shown(options, said, file, refused):
    assert said in refused("show", file, *options)


def test_failed_and_missing_trials_are_shown(partial, here, accepted):
    sc.save(partial, "x.nc")
    out, error = accepted("show", "x.nc", "--limit", "6")
    head, caution, _, _, columns, *lines = out.splitlines()
    assert head.endswith("48 settings, 277 of 288 trials done, 1 failed")
    assert caution == "caution: setting 4, trial 3: division by zero"
    assert columns.split()[-2:] == ["trials", "failed"]
    assert [line.split()[-2:] for line in lines[:6]] == [[n, f] for n, f in zip("620656", "000010", strict=True)]
    assert lines[2].split()[-5:-2] == ["-", "-", "-"]
    assert error == ""
    assert "caution" not in accepted("show", "x.nc", "--where", "setting != 4").out


def test_json_is_the_table(partial, here, accepted):
    sc.save(partial, "x.nc")
    out, error = accepted("show", "x.nc", "--json", "--where", "robots == 2")
    assert not error
    about = json.loads(out, parse_constant=pytest.fail)  # neither NaN nor Infinity is JSON
    assert (about["format"], about["delta"], about["trials_done"]) == ("swarmcensus answer 1", 0.01, 277)
    assert about["failed"] == [{"setting": 4, "trial": 3, "why": "division by zero"}]
    frame = sc.summary(partial, "robots == 2").to_dict("records")
    assert len(about["rows"]) == len(frame) == 24
    for found, row in zip(about["rows"], frame, strict=True):
        for key in ("setting", "topology", "robots", "accuracy", "rounds", "trials", "failed"):
            assert found[key] == row[key]
    assert about["rows"][0]["density"] is None


@pytest.mark.parametrize("width", [24, 40, 58, 80, 200])
def test_a_row_is_a_line_of_any_terminal(many, width):
    """What does not fit is left out and named: the final error stays, and what tells settings apart longest."""
    stream = io.StringIO()
    Summary(many, many).print_on(Console(file=stream, width=width, markup=False, highlight=False), limit=4)
    lines = [line for line in stream.getvalue().splitlines() if " of 48 settings;" not in line]  # to be copied
    assert [line.split()[0] for line in lines if re.match(r" {6}\d", line)] == ["0", "1", "2", "3"]
    assert max(map(len, lines)) <= width
    text = " ".join(" ".join(lines).split())
    for word in ("setting", "topology", "robots", "accuracy", "fill_ratio", "rounds", "minimalistic"):
        assert word in text
    assert "final error: |x - f|" in text, "it stays as long as what tells settings apart"
    assert ("they do not fit into" in text) == (width < 200)


def test_legends_of_floors_and_rules(here, accepted):
    rule = {"until": "convergence_error median +- 0.3", "at_least": 6, "at_most": 12}
    moving = study_of(accuracy=[0.7, 0.9], ticks=20, trials=rule, measure={"truth": "floor"}, density=1)
    sc.save(sc.run(moving), "floor.nc")
    out = accepted("show", "floor.nc").out
    assert "f: the black share of the trial's own floor" in out
    assert "+-: of the rule convergence_error median +- 0.3: wider" in out


def test_parameters_that_no_study_sets_are_not_shown(many):
    brains, z = np.resize(["census", "steadfast"], 48), np.resize([5.0, 4.0], 48)
    data = many.assign_coords(brain=("setting", brains), z=("setting", z))
    data.attrs["parameters"] = '{"census": ["z"], "steadfast": ["z"]}'
    assert "z" not in table_of_summary.varied_and_same(data)[0]
    data.attrs["study"] = '[swarm]\nbrain = ["census", {name = "steadfast", z = 4.0}]'
    assert table_of_summary.varied_and_same(data)[0]["z"][:2] == ["5", "4"]


def test_an_agreement_from_the_start_is_explained(many, tmp_path, accepted):
    for value, said in ((0.0, True), (3.0, False)):
        sc.save(many.assign(agreement_round=many["agreement_round"] * 0 + value), tmp_path / "a.nc")
        shown = accepted("show", tmp_path / "a.nc").out
        assert ("agreement round 0: robots begin with one estimate and stay together" in shown) == said


def test_a_time_that_is_not_reached_is_never(many):
    ends = {"agreement_round": [np.inf, 512.4, 600.0], "agreement_round_low": [np.inf, 490.0, 580.0]}
    frame = pd.DataFrame(ends | {"agreement_round_high": [np.inf, np.inf, 620.0]})
    column = table_of_summary._values(many, frame, "agreement_round", REST)
    assert column.cells == ["never", "512", "600"]
    assert column.intervals == ["", "[490, never]", "[580, 620]"]


# ---- readers are told where a robot converged before it had seen anything
STUDY = """
trials = 4
swarm = {robots = 400, accuracy = 0.9}
world = {topology = "full", fill_ratio = [0.5, 0.7]}
schedule = {rounds = 20, observations_per_round = 100}
"""


def test_shares_are_of_the_robots_that_were_run(small_results):
    data = small_results.copy(deep=True)
    when = data["convergence_round"]
    when[:] = np.where(when >= 0, 5, when)
    assert (settled_at_start(data) == 0).all()
    assert cautions_of_start(data) == []
    when[3, 0, : int(data["robots"][3])] = 0  # one trial of four
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
    assert [Path(one.filename).name for one in given] == ["test_summaries.py"], "once, at the caller's line"
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


def test_robots_that_settle_early_and_apart_are_cautioned_of(misjudged, here, accepted):
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
    assert f"caution: {says}" in " ".join(accepted("show", "s.nc").out.split())
    note = "K misleads in setting 1: settled early, but far from each other or from f"
    for draw, options in (sc.plot.scatter, {}), (sc.plot.heatmap, {}), (sc.plot.lines, {"y": "convergence_round"}):
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


def test_truths_on_the_edge_of_a_bin_are_warned_of(here, accepted):
    text = STUDY.replace("[0.5, 0.7]", "[0.2, 0.55, 0.7, 1.0]") + "[measure]\nestimates = true\n"
    (here / "s.toml").write_text(text)
    says = "warning: fill ratios on the edge between two of the 10 bins, 0.2, 0.7: about half of good estimates"
    assert accepted("run", "s.toml").err.count(says) == 1
    assert says.replace("warning", "caution") in accepted("show", "s.nc").out
    for kind, *asked in (
        ("lines", "--y", "correct"),
        ("heatmap", "--option", "z=correct"),
        ("lines", "--y", "final_error"),
        ("compare", "--option", "factor=fill_ratio", "--option", "metric=correct"),
        ("ranks", "--option", "factor=fill_ratio", "--option", "metric=correct"),
    ):
        assert ("bins, 0.2, 0.7: " in accepted("plot", "s.nc", "--kind", kind, *asked).err) == ("correct" in asked[-1])
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
