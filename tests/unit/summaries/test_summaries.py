"""Summaries: what `swarmcensus show` and `summary` say of results, of those that are not whole too."""

import io
import json
import re

import numpy as np
import pandas as pd
import pytest
from rich.console import Console

import swarmcensus as sc
from swarmcensus.cli.commands import main
from swarmcensus.summaries import measures, table_of_summary
from swarmcensus.summaries.table_of_summary import Summary
from swarmcensus.support import intervals
from swarmcensus.support.printed_tables import REST
from swarmcensus.support.quantities import nine_of_ten

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
        for name in (
            "convergence_round", "convergence_error", "final_estimate", "agreement_round", "components", "mean_degree",
        ):  # fmt: skip
            data[name].values[setting, trials] = np.nan
        for name in ("correct", "disagreement"):
            data[name].values[setting, :, trials] = np.nan
        for name in ("messages_sent", "messages_heard"):
            data[name].values[setting, trials] = np.nan
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
    frame = sc.summary(many)
    for k, row in enumerate(frame.to_dict("records")):
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
    with pytest.raises(sc.InputError, match="checkpoint 3: decisions were recorded after round 2, 5, 8"):
        sc.summary(many, checkpoint=3)


def test_show_prints_a_line_a_setting_whole(file, capsys, monkeypatch):
    """Neither folded nor cut short where there is no terminal, however narrow one is said to be."""
    monkeypatch.setenv("COLUMNS", "40")
    assert main(["show", file, "--limit", "0"]) == 0
    first, same, heads, *lines = capsys.readouterr().out.splitlines()
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
def test_show_sorts(file, many, capsys):
    def shown(*options):
        assert main(["show", file, "--limit", "0", *options]) == 0
        return [int(line.split()[0]) for line in capsys.readouterr().out.splitlines() if line.split()[0].isdigit()]

    frame = sc.summary(many)
    assert shown("--sort", "error") == frame.sort_values("convergence_error", kind="stable")["setting"].tolist()
    assert (np.diff(frame["convergence_error"][shown("--sort", "error at K", "--reverse")]) <= 0).all()
    last = frame["rounds"][shown("--sort", "right", "--checkpoint", "8", "--reverse")].tolist()
    assert last == [8] * 24 + [5] * 24  # what is missing comes last, whichever way


def test_large_results_are_summed_up_in_blocks(partial, monkeypatch):
    whole = sc.summary(partial)
    monkeypatch.setattr(measures, "BLOCK", 50)
    pd.testing.assert_frame_equal(sc.summary(partial), whole)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--checkpoint", "7"], "checkpoint 7: decisions were recorded after round 2, 5, 8"),
        (["--sort", "eror"], "--sort eror"),
        (["--reverse"], "--reverse needs --sort"),
    ],
)
def test_what_cannot_be_shown(options, said, file, refused):
    assert said in refused("show", file, *options)


def test_failed_and_missing_trials_are_shown(partial, here, capsys):
    sc.save(partial, "x.nc")
    assert main(["show", "x.nc", "--limit", "6"]) == 0
    out, error = capsys.readouterr()
    head, caution, _, _, columns, *lines = out.splitlines()
    assert head.endswith("48 settings, 277 of 288 trials done, 1 failed")
    assert caution == "caution: setting 4, trial 3: division by zero"
    assert columns.split()[-2:] == ["trials", "failed"]
    assert [line.split()[-2:] for line in lines[:6]] == [[n, f] for n, f in zip("620656", "000010", strict=True)]
    assert lines[2].split()[-5:-2] == ["-", "-", "-"]
    assert error == ""
    assert main(["show", "x.nc", "--where", "setting != 4"]) == 0
    assert "caution" not in capsys.readouterr().out


def test_json_is_the_table(partial, here, capsys):
    sc.save(partial, "x.nc")
    assert main(["show", "x.nc", "--json", "--where", "robots == 2"]) == 0
    out, error = capsys.readouterr()
    assert not error
    about = json.loads(out, parse_constant=pytest.fail)  # neither NaN nor Infinity is JSON
    assert (about["format"], about["delta"], about["trials_done"]) == ("swarmcensus answer 1", 0.01, 277)
    assert about["failed"] == [{"setting": 4, "trial": 3, "why": "division by zero"}]
    frame = sc.summary(partial, "robots == 2").to_dict("records")
    assert len(about["rows"]) == len(frame) == 24
    for found, row in zip(about["rows"], frame, strict=True):
        for key in ("setting", "topology", "robots", "accuracy", "rounds", "trials", "failed"):
            assert found[key] == row[key]
        for name in ("convergence_round", "convergence_error", "correct"):
            for entry in (name, f"{name}_low", f"{name}_high"):
                assert found[entry] == (None if np.isnan(row[entry]) else row[entry])
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
    assert ("intervals" in text) == (width < 200)
    assert ("they do not fit into" in text) == (width < 200)


def test_legends_of_floors_and_rules(here, capsys):
    moving = sc.Study(
        trials={"until": "convergence_error median +- 0.3", "at_least": 6, "at_most": 12}, measure={"truth": "floor"},
        swarm={"robots": 5, "accuracy": [0.7, 0.9]}, world={"topology": "moving", "density": 1, "fill_ratio": 0.55},
        schedule={"ticks": 20},
    )  # fmt: skip
    sc.save(sc.run(moving), "floor.nc")
    assert main(["show", "floor.nc"]) == 0
    out = capsys.readouterr().out
    assert "f: the black share of the trial's own floor" in out
    assert "+-: of the rule convergence_error median +- 0.3: wider" in out


def test_parameters_that_no_study_sets_are_not_shown(many):
    brains, z = np.resize(["census", "steadfast"], 48), np.resize([5.0, 4.0], 48)
    data = many.assign_coords(brain=("setting", brains), z=("setting", z))
    data.attrs["parameters"] = '{"census": ["z"], "steadfast": ["z"]}'
    assert "z" not in table_of_summary.varied_and_same(data)[0]
    data.attrs["study"] = '[swarm]\nbrain = ["census", {name = "steadfast", z = 4.0}]'
    assert table_of_summary.varied_and_same(data)[0]["z"][:2] == ["5", "4"]


def test_an_agreement_from_the_start_is_explained(many, tmp_path, capsys):
    for value, said in ((0.0, True), (3.0, False)):
        sc.save(many.assign(agreement_round=many["agreement_round"] * 0 + value), tmp_path / "a.nc")
        main(["show", str(tmp_path / "a.nc")])
        assert (
            "agreement round 0: robots begin with one estimate and stay together" in capsys.readouterr().out
        ) == said


def test_a_time_that_is_not_reached_is_never(many):
    ends = {"agreement_round": [np.inf, 512.4, 600.0], "agreement_round_low": [np.inf, 490.0, 580.0]}
    frame = pd.DataFrame(ends | {"agreement_round_high": [np.inf, np.inf, 620.0]})
    column = table_of_summary._values(many, frame, "agreement_round", REST)
    assert column.cells == ["never", "512", "600"]
    assert column.intervals == ["", "[490, never]", "[580, 620]"]
