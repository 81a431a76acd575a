"""Comparisons of the levels of any coordinate, and whether an effect differs between levels of another one."""

import json
import re

import numpy as np
import pytest
import xarray as xr
from scipy import stats

import swarmcensus as sc
from swarmcensus.analysis.comparing.contenders import grid_of
from swarmcensus.analysis.comparing.interactions import _difference
from swarmcensus.summaries import measures
from swarmcensus.support.errors import InputError
from swarmcensus.support.intervals import estimate
from swarmcensus.support.significance import holm
from tests.support.contending import by_every_deal, by_every_sign, made_up, with_signs
from tests.support.drawing import forget, study
from tests.support.small import study_of

NAMES = ["minimalistic", "bayes-bots prior=1", "bayes-bots prior=10", "voter"]
WORLDS = {"topology": ["ring", "line"], "fill_ratio": [0.35, 0.6], "link_success": [1.0, 0.7]}
FEW = {"rounds": 5, "trials": 6, "seed": 1, "fill_ratio": 0.3}


@pytest.fixture(scope="module")
def ran():
    """Two networks, two fill ratios, two numbers of robots and two deliveries, in one small study."""
    return sc.run(study_of(robots=[6, 9], rounds=20, looks=2, trials=12, seed=5, **WORLDS))


def numbers_of(data, name, **where):
    """The number of each trial of the one setting with these coordinates."""
    place = np.flatnonzero(np.logical_and.reduce([data[key].values == value for key, value in where.items()]))
    return measures.numbers(data, name)[place.item()]


def test_contenders_are_the_levels_and_worlds_all_else(ran):
    grid, cautions = grid_of(ran, ran, factor=["topology"])
    assert grid.contenders == ["ring", "line"]
    assert ([*grid.worlds[0]], len(grid.worlds)) == (["robots", "fill_ratio", "link_success"], 8)
    assert not cautions


@pytest.mark.parametrize(("factor", "paired", "reason"), [
    ("topology", True, "readings"),
    ("link_success", True, "readings"),
    ("fill_ratio", True, "lost messages"),  # of worlds in which messages are lost
    ("robots", False, "depend on robots"),
])  # fmt: skip
def test_trials_are_paired_where_they_share_random_numbers(ran, factor, paired, reason):
    found = sc.compare(ran, "final_error", factor=factor)
    assert found.contests[0].paired.any() == paired
    assert any(reason in sentence for sentence in found.pairing)


def test_only_worlds_with_shared_numbers_are_paired(ran):
    found = sc.compare(ran, "final_error", factor="fill_ratio")
    lost = [world["link_success"] < 1.0 for world in found.grid.worlds]
    assert found.contests[0].paired[:, 0].tolist() == lost
    assert (found.pairs["test"] == "signed-rank").tolist() == lost


def test_paired_levels_are_tested_trial_by_trial(ran):
    row = sc.compare(ran, "final_error", factor="topology").pairs.iloc[0]
    world = {"robots": 6, "fill_ratio": 0.35, "link_success": 1.0}
    ring, line = (numbers_of(ran, "final_error", topology=name, **world) for name in ("ring", "line"))
    off = np.where(np.isclose(ring, line), 0.0, ring - line)
    assert row.p == pytest.approx(with_signs(off, by_every_sign(off)))
    assert row.difference == pytest.approx(np.median(off))
    assert row.superiority == (off < 0).mean() + (off == 0).mean() / 2


def test_independent_levels_are_tested_by_ranks(ran):
    eight = ran.isel(trial=slice(8))
    row = sc.compare(eight, "final_error", factor="robots").pairs.iloc[0]
    world = {"topology": "ring", "fill_ratio": 0.35, "link_success": 1.0}
    few, many = (numbers_of(eight, "final_error", robots=count, **world) for count in (6, 9))
    assert (row.one, row.other, row.test, row.trials, row.other_trials) == ("robots=6", "robots=9", "rank-sum", 8, 8)
    assert row.p >= by_every_deal(few, many) - 1e-12
    off = few[:, None] - many
    assert row.difference == pytest.approx(np.median(few) - np.median(many))
    assert row.superiority == (off < -1e-12).mean() + (np.abs(off) <= 1e-12).mean() / 2
    assert row.difference_low < row.difference < row.difference_high
    assert row.superiority_low < row.superiority < row.superiority_high


def test_levels_of_two_factors_are_their_combinations(ran):
    found = sc.compare(ran, "final_error", factor=["topology", "robots"])
    assert found.contenders == ["ring, robots=6", "ring, robots=9", "line, robots=6", "line, robots=9"]
    # ring-ring, ring-line of 6, ring 6 - line 9, ...
    assert found.contests[0].paired[0].tolist() == [False, True, False, False, True, False]


@pytest.mark.interpreted
def test_liars_and_adversaries_are_factors():
    members = [{"robots": [1, 2], "brain": [{"file": "always-black"}, {"file": "random"}], "honest": False}]
    results = sc.run(study_of(robots=6, accuracy=0.8, members=members, **FEW))
    assert sc.compare(results, "final_error", factor="liars").contenders == ["liars=1", "liars=2"]
    found = sc.compare(results, "final_error", factor="adversary")
    assert found.contenders == ["always-black", "random"]
    assert found.grid.worlds == [{"liars": 1}, {"liars": 2}]
    assert found.costs["error_90"].shape == (2, 2)  # among liars a tail is always shown


@pytest.mark.interpreted
def test_liars_are_compared_with_none():
    members = [{"robots": [0, 2], "brain": "always-black", "honest": False}]
    study = study_of(robots=6, accuracy=0.8, members=members, topology=["ring", "full"], **FEW)
    found = sc.compare(sc.run(study), "final_error", factor="liars")
    assert found.contenders == ["liars=0", "liars=2"]
    assert [world["topology"] for world in found.grid.worlds] == ["ring", "full"]
    assert found.contests[0].paired.all()


def test_a_parameter_of_a_brain_is_a_factor():
    found = sc.compare(made_up(), "final_error", where='brain == "bayes-bots"', factor="prior")
    assert found.contenders == ["prior=1", "prior=10"]
    assert found.pairing == ["not paired: these results do not say which random numbers their trials share"]


@pytest.mark.parametrize(("factor", "key", "said"), [
    ("topologie", "factor", "did you mean 'topology'"),
    ("accuracy_black", "factor", "accuracy: name that"),
    ("accuracy", "factor", "they differ in topology, robots, fill_ratio, link_success"),
    ((), None, "They differ in topology, robots, fill_ratio, link_success: choose what to compare"),
])  # fmt: skip
def test_a_factor_that_cannot_be_compared_is_refused(ran, factor, key, said):
    with pytest.raises(InputError, match=said) as refusal:
        sc.compare(ran, factor=factor)
    assert refusal.value.key == key


def test_one_level_is_named_by_its_value(ran):
    found = sc.compare(ran, "final_error", factor="robots", against="9")
    assert found.contenders[found.against] == "robots=9"


def test_pairs_within_the_margin_are_equal_in_practice(ran):
    wide = sc.compare(ran, "final_error", factor="topology", margin=0.9)
    assert wide.pairs["equal_in_practice"].all()
    assert wide.verdict[1].endswith("equal for practical purposes, within 0.9: ring and line in 8 of 8 worlds")
    pairs = sc.compare(ran, "final_error", factor="topology", margin={"final_error": 0.02}).pairs
    inside = (pairs["difference_low"] >= -0.02) & (pairs["difference_high"] <= 0.02)
    assert pairs["equal_in_practice"].tolist() == inside.tolist()
    assert not sc.compare(ran, "final_error", factor="topology").pairs["equal_in_practice"].any()


@pytest.mark.parametrize(("metric", "margin"), [("final_error", 0.004), ("correct", 0.12)])
def test_equality_in_practice_is_corrected_for_the_number_of_pairs(metric, margin):
    data = made_up(worlds=("ring",), trials=24)
    pairs, expected = sc.compare(data, metric, margin=margin).pairs, []
    for row in pairs.to_dict("records"):
        size, low, high = (row[f"difference{end}"] for end in ("", "_low", "_high"))
        reach = min((margin + size) / (size - low), (margin - size) / (high - size)) * stats.t.ppf(0.975, 23)
        expected.append(2 * stats.t.sf(reach, 23) if reach > 0 else 1.0)
        assert (expected[-1] <= 0.05) == (-margin <= low and high <= margin)
        if metric == "final_error":
            one, other = (numbers_of(data, metric, setting=NAMES.index(row[name])) for name in ("one", "other"))
            beyond = max((one - other >= margin).sum(), (other - one >= margin).sum())
            expected[-1] = max(expected[-1], stats.binom.cdf(beyond, 24, 0.5))
    assert pairs["p_equal"].to_numpy() == pytest.approx(holm(np.array(expected)), rel=0.03)
    assert pairs["equal_in_practice"].tolist() == (pairs["p_equal"] <= 0.05).tolist()
    assert 0 < pairs["equal_in_practice"].sum() < (np.array(expected) <= 0.05).sum() <= 6


@pytest.mark.parametrize(("factor", "trials"), [("topology", (8, 8)), ("fill_ratio", (8, 12)), ("robots", (8, 12))])
def test_it_is_said_which_trials_are_used(ran, factor, trials):
    found = sc.compare(forget(ran, setting=0, trial=slice(8, None)), "final_error", factor=factor)
    assert any(one.startswith("contenders have 8 to 12 trials: paired trials are those") for one in found.cautions)
    assert found.cautions == json.loads(found.to_json())["cautions"]
    row = json.loads(found.to_json())["pairs"][0]
    assert (row["trials"], row["other_trials"]) == trials
    assert f" ({trials[0]} and {trials[1]} trials); " in found.pair_sentences[0]


def test_only_compared_pairs_with_finite_numbers_are_equal_in_practice():
    data = made_up()
    data["consensus_right"][:] = 1.0
    found = sc.compare(data, "right_consensus_round", margin=1e6)
    assert not found.pairs["equal_in_practice"].any()  # of each contender, some trials never agree
    data["consensus_round"][:] = 100.0
    found = sc.compare(data, "right_consensus_round", margin=1.0, against="voter")
    assert not any("voter and" in one for one in found.verdict)
    assert len(found.pairs) == 6


def test_robots_that_never_moved_neither_settle_nor_agree():
    data = made_up()
    data["convergence_round"][0] = 0
    data["agreement_round"] = (("setting", "trial"), np.where(np.arange(8)[:, None] == 0, 0.0, 50.0) + np.zeros(20))
    found = sc.compare(data, ["convergence_round", "agreement_round"])
    for contest in found.contests:
        assert np.isinf(contest.values[0, 0])
        assert found.standing(contest)[0, 0] == "behind"
    assert any("never settled and never agreed" in caution for caution in found.cautions)


def test_agreement_in_the_last_rounds_is_a_caution():
    data = made_up()
    data["agreement_round"] = (("setting", "trial"), np.full((8, 20), 100.0))
    assert not any("run longer" in one for one in sc.compare(data, "agreement_round").cautions)
    together = data.assign(agreement_round=data["agreement_round"] * (data["brain"] != "voter"))
    said = "voter: agreement round 0 in worlds 0, 1: robots begin with"
    assert any(one.startswith(said) for one in sc.compare(together, "agreement_round").cautions)
    data["agreement_round"][1] = 480.0
    said = "agreement round: in world 0 robots agree in the last tenth of the run, or never: run longer"
    assert said in sc.compare(data, "agreement_round").cautions


def test_a_difference_that_is_the_same_in_every_trial_is_equal_in_practice():
    data = made_up(brains=2)
    data["correct"][:] = 1.0
    found = sc.compare(data, "correct", margin=0.01)
    assert found.pairs["equal_in_practice"].all()
    assert "equal for practical purposes, within 1 %: " in found.verdict[1]
    assert not sc.compare(data.isel(trial=slice(5)), "correct", margin=0.01).pairs["equal_in_practice"].any()


def test_a_fixed_belief_is_one_world_for_all_accuracies():
    study = study_of(robots=4, accuracy=[0.6, 0.7, 0.8], assumed_accuracy=0.7, **FEW)
    grid = sc.compare(sc.run(study), "final_error", factor="accuracy").grid
    assert (grid.contenders, len(grid.worlds)) == (["accuracy=0.6", "accuracy=0.7", "accuracy=0.8"], 1)


@pytest.mark.interpreted
def test_honest_members_are_a_part_of_the_world():
    members = [{"robots": [1, 2], "brain": "opposite", "honest": False}, {"robots": 2, "accuracy": [0.6, 0.9]}]
    study = study_of(robots=8, accuracy=0.8, members=members, **FEW)
    found = sc.compare(sc.run(study), "final_error", factor="liars")
    assert [world["members"] for world in found.grid.worlds] == ["2 accuracy 0.6", "2 accuracy 0.9"]


@pytest.mark.parametrize("margin", [-0.1, 0.0, {"K": 1.0}, {"final_error": "much"}], ids=str)
@pytest.mark.parametrize("metric", ["final_error", ["final_error", "correct"]], ids=["one", "two"])
def test_wrong_margins_are_refused(ran, metric, margin):
    with pytest.raises(InputError) as refusal:
        sc.compare(ran, metric, factor="topology", margin=margin)
    assert refusal.value.key == "margin"


def test_a_sentence_has_the_numbers_of_the_table(ran):
    found = sc.compare(ran, "final_error", factor="robots", where='link_success == 1 and topology == "ring"')
    sentence, row = found.pair_sentences[0], found.pairs.iloc[0]
    assert sentence.startswith("final error (fill_ratio 0.35): robots=6 ")
    assert f"probability that robots=6 is better {row.superiority:.2f} [{row.superiority_low:.2f}, " in sentence
    assert "the two-sided rank-sum test, or Brunner and Munzel's if its p is larger, p = " in sentence
    assert "after Holm's correction for 2 tests" in sentence


def test_profiles_keep_trials_in_which_nothing_happened():
    data = made_up()
    table = sc.compare(data, "right_consensus_round").profiles
    when = measures.numbers(data, "right_consensus_round")
    one = table[(table["world"] == 0) & (table["contender"] == "minimalistic")]
    assert one["share"].tolist() == [float((when[0] <= at).mean()) for at in one["round"]]
    assert one["round"].iloc[-1] == 500
    assert one["share"].iloc[-1] == np.isfinite(when[0]).mean() < 1.0


def test_profiles_are_drawn_and_other_measures_are_refused(ran):
    lines = sc.plot.lines(made_up(), form="steps", y="right_consensus_round").axes[0].get_lines()
    assert len(lines) == 4
    assert max(lines[0].get_ydata()) < 100.0
    with pytest.raises(InputError) as refusal:
        sc.plot.lines(ran, form="steps", y="final_error", color="topology")
    assert refusal.value.key == "y"


def test_the_command_compares_a_factor(ran, refused, accepted):
    sc.save(ran, "ran.nc")
    words = ["compare", "ran.nc", "--factor", "topology", "--metric", "final_error"]
    document = json.loads(accepted(*words, "--margin", "0.5", "--sentences", "--json").out)
    assert document["pairing"] == ["paired by trial: trials of one number share readings"]
    assert {pair["one"] for pair in document["pairs"]} == {"ring"}
    assert len(document["rows"]) == 16
    found = sc.compare(ran, "final_error", factor="topology", margin=0.5)
    assert document["sentences"] == found.verdict + found.pair_sentences
    assert len(found.pair_sentences) == 8
    assert re.search("They differ in topology.*--factor topology", refused("compare", "ran.nc"))


# ---- interactions: whether an effect differs between levels of another factor, by hand, by brute force and by chance
HOW = {(True, True): "signed-rank", (False, True): "rank-sum", (True, False): "rank-sum", (False, False): "rank-sum"}
WORLD = {"topology": ["ring", "line"], "fill_ratio": [0.35, 0.6]}


@pytest.fixture(scope="module")
def two_brains():
    """Two brains on two networks with two fill ratios and two accuracies."""
    brains = ["minimalistic", "legacy"]
    return sc.run(study_of(brains, 6, [0.6, 0.8], rounds=20, looks=2, trials=12, seed=5, **WORLD))


def four(data, topology=("ring", "line"), of="final_error", **where):
    """Numbers of both brains on both networks, averaged over worlds, by the definition."""
    found = np.zeros((2, 2, data.sizes["trial"]))
    for a, brain in enumerate(("minimalistic", "legacy")):
        for b, name in enumerate(topology):
            wanted = {"brain": brain, "topology": name} | where
            rows = np.logical_and.reduce([data[key].values == value for key, value in wanted.items()])
            found[a, b] = measures.numbers(data, of)[rows].mean(axis=0)
    return found


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


def test_rows_are_those_of_the_definition(two_brains):
    found = sc.compare(two_brains, "final_error", interaction="topology")
    [row] = found.rows
    numbers = four(two_brains)
    each = (numbers[0, 0] - numbers[1, 0]) - (numbers[0, 1] - numbers[1, 1])
    assert (row["one"], row["other"], row["level"], row["other_level"]) == ("minimalistic", "legacy", "ring", "line")
    assert (row["worlds"], row["trials"], row["test"]) == (4, 12, "signed-rank")
    assert row["difference"] == pytest.approx(each.mean())
    assert row["difference"] == pytest.approx(row["effect"] - row["other_effect"])
    assert row["p"] == pytest.approx(by_every_sign(each))
    assert (row["difference_low"], row["difference_high"]) == estimate(each[:, np.newaxis], "mean")[1:]
    values = {(cell["level"], cell["by"]): cell["value"] for cell in found.cells}
    assert values["legacy", "line"] == pytest.approx(numbers[1, 1].mean())


def test_levels_that_share_nothing_are_two_samples(two_brains):
    # readings depend on accuracy and the fill ratio, and networks of these two kinds on nothing
    two_brains = two_brains.isel(trial=slice(9))  # for which all deals are soon tried
    found = sc.compare(two_brains, "final_error", "fill_ratio == 0.6", interaction="accuracy")
    [row] = found.rows
    parts = [four(two_brains, accuracy=accuracy, fill_ratio=0.6).mean(axis=1) for accuracy in ("0.6", "0.8")]
    first, second = (part[0] - part[1] for part in parts)
    assert row["test"] == "rank-sum"
    assert row["difference"] == pytest.approx(first.mean() - second.mean())
    assert row["p"] >= by_every_deal(first, second) - 1e-9  # the larger one of two tests
    assert "two samples, p " in found.sentences[0]
    turned = sc.compare(two_brains, "final_error", "fill_ratio == 0.6", factor="accuracy", interaction="brain")
    [back] = turned.rows  # the same question the other way round
    assert back["difference"] == pytest.approx(row["difference"])
    assert (back["test"], back["p"]) == ("rank-sum", row["p"])


def test_all_tests_are_corrected_together(two_brains):
    found = sc.compare(two_brains, ["final_error", "correct"], factor=["topology", "fill_ratio"], interaction="brain")
    assert len(found.rows) == 2 * 6 * 1
    p, corrected = (np.array([row[name] for row in found.rows]) for name in ("p", "p_holm"))
    assert corrected == pytest.approx(holm(p))
    assert len(sc.compare(two_brains, "correct", factor="brain", against="legacy", interaction=["topology"]).rows) == 1
    assert all("after Holm's correction for 12 tests" in sentence for sentence in found.sentences)


def test_effects_that_are_the_same_in_every_trial_have_no_interval(two_brains):
    found = sc.compare(two_brains, "messages_sent", interaction="topology")
    assert np.isnan(found.rows[0]["difference_low"])
    said = "is 0 with ring and 0 with line; difference 0 always, not told apart (paired by trial, p = 1.000)"
    assert found.sentences[0].endswith(said)


def test_whoever_names_an_interaction_gets_a_sentence_that_adds_up():
    data = made_up(2, trials=20)
    high = (data["brain"] == "bayes-bots") & (data["topology"] == "full")
    data["final_estimate"] = data["final_estimate"] + 0.5 * high
    found = sc.compare(data, "final_error", interaction="topology")
    [row], [sentence] = found.rows, found.sentences
    assert row["told_apart"]
    assert row["difference"] == pytest.approx(0.5, abs=0.02)
    effects = f"{row['effect']:.3g} with ring and {row['other_effect']:.3g} with full"
    said = f"the effect of minimalistic vs. bayes-bots on final error is {effects}; difference 0.50"
    assert sentence.startswith(said)
    assert "two samples, p < 0.001)" in sentence  # it is not known what these trials share
    said = json.loads(found.to_json())
    assert said["sentences"] == [sentence]
    assert said["rows"][0]["difference"] == row["difference"]
    assert len(said["cells"]) == 4


@pytest.mark.parametrize("skewed", [False, True], ids=["normal", "skewed"])
@pytest.mark.parametrize("sharing", [*HOW], ids=["paired", "across", "within", "none"])
@pytest.mark.long(but=["paired-skewed"])
def test_intervals_hold_and_tests_err_as_often_as_they_say(sharing, skewed):
    """300 studies of 20 trials, without interaction: a 95 % interval fails in 5 %, and so does the test.

    By chance alone, more than 30 of 300 fail with probability 0.0002 where 5 % do; 16 comparisons.
    """
    random, missed, rejected = np.random.default_rng(3), 0, 0
    for _ in range(300):
        noise = random.normal(size=(2, 2, 20)) * np.array([[[1.0], [1.5]]])
        if skewed:
            noise = noise / 10
            noise[0, 0] = random.exponential(size=20) - 1
        noise += random.normal(size=20) if all(sharing) else 0.0
        row, test = _difference(noise, *sharing)
        assert row["difference_low"] > 0.0 or row["difference_high"] < 0.0 or test.p > 0.05
        missed += not row["difference_low"] <= 0.0 <= row["difference_high"]
        rejected += float(test.p) <= 0.05
    assert missed <= 30
    assert rejected <= 30
    assert missed >= 3  # an interval of any width would hold: 5 % of 300 are fewer with probability 0.0001


def test_what_cannot_be_answered_is_refused_with_the_reason(two_brains):
    for given, why in (
        ({"interaction": "brain"}, "interaction='brain': it is the factor"),
        ({"interaction": "robots"}, "all settings have the same, 6"),
        ({"interaction": "topologie"}, "did you mean 'topology'"),
        ({"interaction": "topology", "margin": 0.1}, "does not go with an interaction"),
        ({"interaction": "topology", "against": "alone"}, "there are minimalistic, legacy"),
    ):
        with pytest.raises(InputError, match=why):
            sc.compare(two_brains, **given)
    some = two_brains.isel(setting=~((two_brains["brain"] == "legacy") & (two_brains["topology"] == "line")).values)
    with pytest.raises(InputError, match="no trial has two levels of brain at each of two levels of topology"):
        sc.compare(some, interaction="topology")
    with pytest.raises(InputError, match=r"right_consensus_round.*: never comes in \d+ trials, and a difference"):
        sc.compare(made_up(2), "right_consensus_round", interaction="topology")
    usual = sc.compare(made_up(2), interaction="topology")
    assert "right_consensus_round" not in {measure.name for measure in usual.measures}
    assert any("never comes in" in caution for caution in usual.cautions)


# ---- the command, and coordinates by which worlds differ
def test_the_command_says_it(two_brains, here, accepted, refused):
    sc.save(two_brains, "a.nc")
    how = ["compare", "a.nc", "--by", "topology", "--metric", "final_error"]
    out = accepted(*how, "--interaction", "--save", "c.csv").out
    found = sc.compare("a.nc", "final_error", interaction="topology")
    assert " ".join(found.sentences[0].split()) in " ".join(out.split())
    assert {path.name for path in here.iterdir()} == {"a.nc", "c.csv"}
    assert "--by" in refused("compare", "a.nc", "--interaction")


def test_lines_of_the_figure_are_the_cells(two_brains):
    found = sc.compare(two_brains, ["final_error", "correct"], interaction="topology")
    figure = sc.plot.interaction(two_brains, by="topology", metric=["final_error", "correct"], width=3.5)
    assert figure.get_size_inches()[0] == pytest.approx(3.5)
    for axes, measure, times in zip(figure.axes, ("final_error", "correct"), (1, 100), strict=True):
        lines = [line for line in axes.lines if line.get_label().startswith("line ")]
        cells = [cell for cell in found.cells if cell["measure"] == measure]
        values = [times * cell["value"] for cell in cells]
        assert np.concatenate([line.get_ydata() for line in lines]) == pytest.approx(values)
    said = " ".join(sc.plot.caption(figure).split())
    assert all(f"{sentence}." in said for sentence in found.sentences)


@pytest.mark.parametrize("by", ["topology", "accuracy"])
def test_dots_stand_beside_each_other_and_on_the_axes(by):
    """Twenty lines at two levels: each dot is nearer to its own level, within the limits."""
    levels = {"topology": ["ring", "full"], "accuracy": ["0.6", "0.8"]}[by]
    parts = [study(["0.7"] * 2, trials=6, brain=f"brain {k}") for k in range(20)]
    parts = [part.assign_coords({by: ("setting", levels)}) for part in parts]
    results = xr.concat(parts, "setting").assign_coords(setting=range(40))
    figure = sc.plot.interaction(results, by=by, metric="convergence_error", width=3.5)
    figure.draw_without_rendering()
    (axes,) = figure.axes
    lines = [line for line in axes.lines if line.get_label().startswith("line ")]
    places = np.array([line.get_transform().transform(line.get_xydata())[:, 0] for line in lines])
    left, right = axes.bbox.x0, axes.bbox.x1
    assert (places.shape, len({*places[:, 0].round(3).tolist()})) == ((20, 2), 20)
    assert left < places.min()
    assert places.max() < right
    assert np.ptp(places[:, 0]) < 0.8 * np.diff(places[0])[0]


@pytest.fixture(scope="module")
def liars():
    members = [{"robots": [0, 1, 2], "brain": "creeper", "honest": False}]
    world = {"topology": "full", "fill_ratio": 0.35}
    return sc.run(study_of(["minimalistic", "legacy"], 8, rounds=15, trials=8, seed=5, members=members, **world))


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
    levels = {"liars=0", "liars=1", "plain", *liars["members"].values.tolist()}
    assert {rows[0]["level"], rows[0]["other_level"]} <= levels


@pytest.mark.interpreted
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
