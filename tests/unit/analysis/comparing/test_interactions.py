"""Interactions: whether an effect differs between levels of another factor, by hand, by brute force and by chance."""

import json

import numpy as np
import pytest
import xarray as xr

import swarmcensus as sc
from swarmcensus.analysis.comparing.interactions import _difference
from swarmcensus.cli.commands import main
from swarmcensus.summaries import measures
from swarmcensus.support.errors import InputError
from swarmcensus.support.significance import holm
from tests.support.contending import by_every_deal, by_every_sign, made_up
from tests.support.drawing import study

HOW = {(True, True): "signed-rank", (False, True): "rank-sum", (True, False): "rank-sum", (False, False): "rank-sum"}
WORLD = {"topology": ["ring", "line"], "fill_ratio": [0.35, 0.6]}


@pytest.fixture(scope="module")
def ran():
    """Two brains on two networks with two fill ratios and two accuracies."""
    swarm = {"robots": 6, "brain": ["minimalistic", "legacy"], "accuracy": [0.6, 0.8]}
    schedule = {"rounds": 20, "observations_per_round": 2}
    return sc.run(sc.Study(trials=12, seed=5, swarm=swarm, world=WORLD, schedule=schedule))


def four(data, topology=("ring", "line"), of="final_error", **where):
    """Numbers of both brains on both networks, averaged over worlds, by the definition."""
    found = np.zeros((2, 2, data.sizes["trial"]))
    for a, brain in enumerate(("minimalistic", "legacy")):
        for b, name in enumerate(topology):
            rows = (data["brain"] == brain) & (data["topology"] == name)
            for key, value in where.items():
                rows = rows & (data[key] == value)
            found[a, b] = measures.numbers(data, of)[rows.values].mean(axis=0)
    return found


# ---- by hand


def test_an_example_by_hand():
    # effects 1, 2, 3 at the first level and 0, 4, 2 at the second: in trials 1, -2 and 1 apart
    numbers = np.array([[[5.0, 5.0, 5.0], [2.0, 6.0, 7.0]], [[4.0, 3.0, 2.0], [2.0, 2.0, 5.0]]])
    for sharing, test in HOW.items():
        row, tested = _difference(numbers, *sharing)
        assert (row["effect"], row["other_effect"], row["difference"], row["test"]) == (2.0, 2.0, 0.0, test)
        assert (row["trials"], row["other_trials"]) == (3, 3)
        assert np.isnan([row["difference_low"], row["difference_high"]]).all()  # too few trials
    row, tested = _difference(numbers, True, True)
    assert (int(tested.below), int(tested.above), float(tested.p)) == (1, 2, 1.0)  # ranks 3 against 1.5 + 1.5
    row, tested = _difference(numbers, False, True)  # 1, 2, 3 against 0, 4, 2: of 9 pairs 4 above, 1 equal, 4 below
    assert (int(tested.below), int(tested.equal), int(tested.above)) == (4, 1, 4)
    row, tested = _difference(numbers, True, False)  # effects of the other factor: 3, -1, -2 against 2, 1, -3
    assert (int(tested.below), int(tested.equal), int(tested.above)) == (4, 0, 5)


def test_trials_that_some_lack_are_left_out():
    numbers = np.arange(32.0).reshape(2, 2, 8) ** 1.5
    numbers[0, 0, 2] = numbers[1, 1, 5] = np.nan
    known = np.delete(numbers, [2, 5], axis=2)
    assert _difference(numbers, True, True)[0]["difference"] == _difference(known, True, True)[0]["difference"]
    row, _ = _difference(numbers, False, True)
    assert (row["trials"], row["other_trials"]) == (7, 7)
    assert row["difference"] == pytest.approx(row["effect"] - row["other_effect"])


# ---- rows, by brute force


def test_rows_are_those_of_the_definition(ran):
    found = sc.compare(ran, "final_error", interaction="topology")
    [row] = found.rows
    numbers = four(ran)
    each = (numbers[0, 0] - numbers[1, 0]) - (numbers[0, 1] - numbers[1, 1])
    assert (row["one"], row["other"], row["level"], row["other_level"]) == ("minimalistic", "legacy", "ring", "line")
    assert (row["worlds"], row["trials"], row["test"]) == (4, 12, "signed-rank")
    assert row["difference"] == pytest.approx(each.mean())
    assert row["difference"] == pytest.approx(row["effect"] - row["other_effect"])
    assert row["p"] == pytest.approx(by_every_sign(each))
    drawn = np.random.default_rng(1).choice(each, (20_000, each.size)).mean(axis=1)
    low, high = np.quantile(drawn, [0.025, 0.975])
    # the plain bootstrap's interval, which is too narrow for 12 trials: by a sixth
    assert (row["difference_high"] - row["difference_low"]) / (high - low) == pytest.approx(1.17, abs=0.06)
    values = {(cell["level"], cell["by"]): cell["value"] for cell in found.cells}
    assert values["legacy", "line"] == pytest.approx(numbers[1, 1].mean())


def test_levels_that_share_nothing_are_two_samples(ran):
    # readings depend on accuracy and the fill ratio, and networks of these two kinds on nothing
    ran = ran.isel(trial=slice(9))  # for which all deals are soon tried
    found = sc.compare(ran, "final_error", "fill_ratio == 0.6", interaction="accuracy")
    [row] = found.rows
    parts = [four(ran, accuracy=accuracy, fill_ratio=0.6).mean(axis=1) for accuracy in ("0.6", "0.8")]
    first, second = (part[0] - part[1] for part in parts)
    assert row["test"] == "rank-sum"
    assert row["difference"] == pytest.approx(first.mean() - second.mean())
    assert row["p"] >= by_every_deal(first, second) - 1e-9  # the larger one of two tests
    assert "two samples, p " in found.sentences[0]
    turned = sc.compare(ran, "final_error", "fill_ratio == 0.6", factor="accuracy", interaction="brain")
    [back] = turned.rows  # the same question the other way round
    assert back["difference"] == pytest.approx(row["difference"])
    assert (back["test"], back["p"]) == ("rank-sum", row["p"])


def test_all_tests_are_corrected_together(ran):
    found = sc.compare(ran, ["final_error", "correct"], factor=["topology", "fill_ratio"], interaction="brain")
    assert len(found.rows) == 2 * 6 * 1
    p, corrected = (np.array([row[name] for row in found.rows]) for name in ("p", "p_holm"))
    assert corrected == pytest.approx(holm(p))
    assert len(sc.compare(ran, "correct", factor="brain", against="legacy", interaction=["topology"]).rows) == 1
    assert all("after Holm's correction for 12 tests" in sentence for sentence in found.sentences)


def test_effects_that_are_the_same_in_every_trial_have_no_interval(ran):
    found = sc.compare(ran, "messages_sent", interaction="topology")
    assert np.isnan(found.rows[0]["difference_low"])
    said = "is the same with ring as with line, not told apart (0 against 0; paired by trial, p = 1.000)"
    assert found.sentences[0].endswith(said)
    found.rows[0]["difference"] = -2e-7  # as many digits as it needs
    assert " is 0.0000002 messages lower with ring than with line" in found.sentences[0]


def test_whoever_names_an_interaction_gets_a_sentence_that_adds_up():
    data = made_up(2, trials=20)
    error = data["final_estimate"] - 0.55
    high = (data["brain"] == "bayes-bots") & (data["topology"] == "full")
    data["final_estimate"] = 0.55 + error.where(~high, error + 0.5)
    found = sc.compare(data, "final_error", interaction="topology")
    [row], [sentence] = found.rows, found.sentences
    assert row["told_apart"]
    assert row["difference"] == pytest.approx(0.5, abs=0.02)
    assert sentence.startswith("the effect of minimalistic vs. bayes-bots on final error is 0.5")
    assert " higher with ring than with full (" in sentence
    assert "two samples, p < 0.001)" in sentence  # it is not known what these trials share
    said = json.loads(found.to_json())
    assert said["sentences"] == [sentence]
    assert said["rows"][0]["difference"] == row["difference"]
    assert len(said["cells"]) == 4


# ---- by chance


@pytest.mark.parametrize("skewed", [False, True], ids=["normal", "skewed"])
@pytest.mark.parametrize("sharing", [*HOW], ids=["paired", "across", "within", "none"])
@pytest.mark.long(but=["paired-normal"])
def test_intervals_hold_and_tests_err_as_often_as_they_say(sharing, skewed):
    """300 studies of 20 trials, without interaction: a 95 % interval fails in 5 %, and so does the test.

    By chance alone, more than 30 of 300 fail with probability 0.0002 where 5 % do; 16 comparisons.
    """
    random, missed, rejected = np.random.default_rng(3), 0, 0
    for _ in range(300):
        noise = random.normal(size=(2, 2, 20)) * np.array([[[1.0], [1.5]]])
        noise = np.exp(noise / 2) if skewed else noise
        noise += random.normal(size=20) if all(sharing) else 0.0
        row, test = _difference(noise, *sharing)
        missed += not row["difference_low"] <= 0.0 <= row["difference_high"]
        rejected += float(test.p) <= 0.05
    assert missed <= 30
    assert rejected <= 30
    assert missed >= 3  # an interval of any width would hold: 5 % of 300 are fewer with probability 0.0001


# ---- what cannot be answered


def test_what_cannot_be_answered_is_refused_with_the_reason(ran):
    refusals = [
        ({"interaction": "brain"}, "interaction='brain': it is the factor"),
        ({"interaction": "robots"}, "all settings have the same, 6"),
        ({"interaction": "topologie"}, "did you mean 'topology'"),
        ({"interaction": "topology", "margin": 0.1}, "does not go with an interaction"),
        ({"interaction": "topology", "against": "alone"}, "there are minimalistic, legacy"),
    ]
    for given, why in refusals:
        with pytest.raises(InputError, match=why):
            sc.compare(ran, **given)
    some = ran.isel(setting=~((ran["brain"] == "legacy") & (ran["topology"] == "line")).values)
    with pytest.raises(InputError, match="no trial has two levels of brain at each of two levels of topology"):
        sc.compare(some, interaction="topology")
    with pytest.raises(InputError, match=r"right_consensus_round.*: never comes in \d+ trials, and a difference"):
        sc.compare(made_up(2), "right_consensus_round", interaction="topology")
    usual = sc.compare(made_up(2), interaction="topology")
    assert "right_consensus_round" not in {measure.name for measure in usual.measures}
    assert any("never comes in" in caution for caution in usual.cautions)


# ---- the command, and coordinates by which worlds differ


def test_the_command_says_it(ran, here, capsys):
    sc.save(ran, "a.nc")
    how = ["compare", "a.nc", "--by", "topology", "--metric", "final_error"]
    assert main([*how, "--interaction", "--save", "c.csv"]) == 0
    out = capsys.readouterr().out
    found = sc.compare("a.nc", "final_error", interaction="topology")
    assert " ".join(found.sentences[0].split()) in " ".join(out.split())
    assert {path.name for path in here.iterdir()} == {"a.nc", "c.csv"}
    assert main(["compare", "a.nc", "--interaction"]) == 2
    assert "--by" in capsys.readouterr().err


def test_lines_of_the_figure_are_the_cells(ran):
    found = sc.compare(ran, ["final_error", "correct"], interaction="topology")
    figure = sc.plot.interaction(ran, by="topology", metric=["final_error", "correct"], width=3.5)
    assert figure.get_size_inches()[0] == pytest.approx(3.5)
    for axes, measure, times in zip(figure.axes, ("final_error", "correct"), (1, 100), strict=True):
        lines = [line for line in axes.lines if line.get_label().startswith("line ")]
        cells = [cell for cell in found.cells if cell["measure"] == measure]
        assert np.concatenate([line.get_ydata() for line in lines]) == pytest.approx(
            [times * cell["value"] for cell in cells]
        )
    apart = sum(row["told_apart"] for row in found.rows)
    said = " ".join(sc.plot.caption(figure).split())
    assert f"corrected after Holm: {apart} of {len(found.rows)} pairs of effects" in said
    assert said.count(" vs. ") == 2 * min(apart, 3)


@pytest.mark.parametrize("by", ["topology", "accuracy"])
def test_dots_stand_beside_each_other_and_on_the_axes(by):
    """Twenty lines at two levels: each dot is nearer to its own level, within the limits."""
    levels = {"topology": ["ring", "full"], "accuracy": ["0.6", "0.8"]}[by]
    parts = [
        study(["0.7"] * 2, trials=6, brain=f"brain {k}").assign_coords({by: ("setting", levels)}) for k in range(20)
    ]
    results = xr.concat(parts, "setting").assign_coords(setting=range(40))
    figure = sc.plot.interaction(results, by=by, metric="convergence_error", width=3.5)
    figure.draw_without_rendering()
    (axes,) = figure.axes
    lines = [line for line in axes.lines if line.get_label().startswith("line ")]
    places = np.array([line.get_transform().transform(line.get_xydata())[:, 0] for line in lines])
    left, right = axes.bbox.x0, axes.bbox.x1
    assert places.shape == (20, 2)
    assert len({*places[:, 0].round(3).tolist()}) == 20
    assert left < places.min()
    assert places.max() < right
    assert np.ptp(places[:, 0]) < 0.8 * np.diff(places[0])[0]


@pytest.fixture(scope="module")
def liars():
    members = [{"robots": [0, 1, 2], "brain": "creeper", "honest": False}]
    swarm = {"robots": 8, "brain": ["minimalistic", "legacy"], "accuracy": 0.7}
    world, schedule = {"topology": "full", "fill_ratio": 0.35}, {"rounds": 15}
    return sc.run(sc.Study(trials=8, seed=5, swarm=swarm, members=members, world=world, schedule=schedule))


@pytest.mark.interpreted
def test_worlds_are_counted_by_what_members_say_too(liars):
    counts = sc.compare(liars, "final_error").by("adversary")
    assert dict(zip(counts["adversary"], counts["worlds"], strict=True)) == {"": 1, "creeper": 2}


@pytest.mark.interpreted
@pytest.mark.parametrize("name", ["liars", "members"])
def test_what_is_a_factor_also_divides_worlds(liars, name):
    assert len(sc.compare(liars, "final_error", factor=name, where="liars != 2").contenders) == 2
    counts = sc.compare(liars, "final_error").by(name)
    assert counts["worlds"].sum() == 2 * 3
    assert len(counts) == 2 * len({*liars[name].values.tolist()})
    rows = sc.compare(liars, "final_error", where="liars != 2", interaction=name).rows
    assert len(rows) == 1
    assert {rows[0]["level"], rows[0]["other_level"]} <= {
        "liars=0", "liars=1", "plain", *liars["members"].values.tolist(),
    }  # fmt: skip


def test_what_follows_from_a_topology_is_no_world_of_its_own():
    """Arenas and floors are of robots that move; the number of observations is another one on purpose."""
    study = sc.Study(
        trials=6, seed=5, swarm={"robots": 5, "accuracy": 0.8, "brain": ["commons", "alone"]},
        world={"topology": ["ring", "moving"], "side": 2.0, "fill_ratio": 0.6},
        schedule={"rounds": 30, "ticks": 30, "observations_per_round": 1},
    )  # fmt: skip
    results = sc.run(study, progress=False)
    [row] = sc.compare(results, "final_error", interaction="topology").rows
    assert {row["level"], row["other_level"]} == {"ring", "moving"}
    errors = {(brain, where): error for brain, where, error in zip(
        results["brain"].values.tolist(), results["topology"].values.tolist(),
        measures.numbers(results, "final_error").mean(axis=1), strict=True,
    )}  # fmt: skip
    one, other, level, against = (row[name] for name in ("one", "other", "level", "other_level"))
    by_hand = errors[one, level] - errors[other, level] - (errors[one, against] - errors[other, against])
    assert row["difference"] == pytest.approx(by_hand)
    assert sc.compare(results, "final_error", factor="topology").contenders == ["ring", "moving"]
