"""Brains in worlds: who meets whom, by what measures, what is told of it, and what is said where it cannot be."""

import json
import math

import numpy as np
import pytest
from markupsafe import escape
from scipy import stats

import swarmcensus as sc
from swarmcensus.analysis.comparing.contenders import grid_of
from swarmcensus.brains import metrics
from swarmcensus.summaries import measures
from swarmcensus.support.errors import InputError
from swarmcensus.support.printed_tables import escaped
from swarmcensus.support.significance import holm
from tests.support.contending import by_every_sign, made_up, with_signs
from tests.support.drawing import forget

NAMES = ["minimalistic", "bayes-bots prior=1", "bayes-bots prior=10", "voter"]


# ---- who meets whom
def test_contender_is_a_brain_with_its_varying_parameters():
    data = made_up()
    assert grid_of(data, data)[0].contenders == NAMES
    few = data.isel(setting=(data["prior"] != 10).values)
    assert grid_of(few, few)[0].contenders == ["minimalistic", "bayes-bots", "voter"]
    found, cautions = grid_of(few, data)  # whoever picks some of the settings finds them under the same names
    assert found.contenders == ["minimalistic", "bayes-bots prior=1", "voter"]
    said = "where leaves out 1 contender: p-values are corrected for the others alone, which is valid only if they "
    assert cautions == [f"{said}were chosen before looking at results"]
    named = data.assign_coords(prior=("setting", ["", "(1, 2)", "(2, 1)", ""] * 2))  # a vector is text
    assert grid_of(named, named)[0].contenders[1:3] == ["bayes-bots prior=(1, 2)", "bayes-bots prior=(2, 1)"]


def test_a_world_is_all_else_that_settings_are():
    field, cautions = grid_of(made_up(), made_up())
    assert field.worlds == [{"topology": "ring"}, {"topology": "full"}]
    assert field.common["fill_ratio"] == 0.55
    assert "assumed_accuracy" not in field.common
    assert field.place.tolist() == [[0, 1, 2, 3], [4, 5, 6, 7]]
    assert cautions == []


def test_what_does_not_pair_is_named():
    data = made_up()
    lacking = sc.compare(data.isel(setting=[0, 1, 2, 3, 4, 5]))
    assert any("voter is not in 1 of 2 worlds" in one for one in lacking.cautions)
    assert lacking.contests[0].met.tolist() == [True, False]
    assert len(lacking.duels) == 0
    alone = sc.compare(data.isel(setting=[0, 1, 2, 3, 4]))
    assert any("1 world has only one contender, and is left out" in one for one in alone.cautions)
    assert len(alone.grid.worlds) == 1


@pytest.mark.parametrize(("settings", "said"), [
    ([0, 4], "there is nothing to compare: all settings are of minimalistic"),
    ([0, 5], "no two of minimalistic and bayes-bots have met the same world"),
    ([0, 0, 1], "settings 0 and 0 are both of minimalistic in the same world"),
])  # fmt: skip
def test_where_nothing_can_be_compared_it_is_said(settings, said):
    with pytest.raises(sc.InputError, match=said):
        sc.compare(made_up().isel(setting=settings))


# ---- the number of a trial
def quantile(values, share):
    """Linear between the two values around the place."""
    ordered, place = sorted(values), share * (len(values) - 1)
    below = ordered[int(place)]
    return below + (ordered[min(int(place) + 1, len(values) - 1)] - below) * (place % 1)


def test_each_measure_is_what_a_loop_over_robots_makes_of_it():
    data = made_up(robots=6).assign(honest=("setting", [6, 6, 4, 5, 6, 6, 1, 6]))
    data["decision"][0, 0, 0] = np.nan
    names = ("final_estimate", "convergence_round", "messages_sent", "decision")
    values = {name: data[name].transpose("setting", ..., "trial", "robot").values for name in names}
    for setting, honest in enumerate(data["honest"].values):
        for trial in range(data.sizes["trial"]):
            mine = {name: one[setting, trial, :honest].tolist() for name, one in values.items()}
            known = [one for one in mine["decision"] if one == one]
            finals, sent = mine["final_estimate"], sum(mine["messages_sent"]) / honest
            errors = [abs(x - 0.55) for x in finals]
            expected = {
                "final_error": np.median(errors),
                "error_90": min(one for one in errors if sum(each <= one for each in errors) >= 0.9 * honest),
                "worst_error": max(errors),
                "final_disagreement": (quantile(finals, 0.95) - quantile(finals, 0.05)) / 2,
                "convergence_round": np.median(mine["convergence_round"]),
                "messages_sent": sent, "bytes_sent": sent * float(data["message_bytes"][setting]),
                "decided": sum(one >= 0 for one in known) / len(known),
                "correct": float(data["correct"][setting, 0, trial]),
            }  # fmt: skip
            for name, number in expected.items():
                assert measures.numbers(data, name)[setting, trial] == pytest.approx(number, rel=1e-12), name


def test_errors_are_those_against_the_truth_of_the_study():
    data = made_up()
    data.attrs["truth"] = "floor"
    data["true_fill_ratio"][:] = 0.5
    off = np.median(data["final_estimate"].values - 0.5, axis=2)
    assert measures.numbers(data, "final_error") == pytest.approx(off)


def test_right_is_at_the_last_checkpoint():
    wide = made_up(brains=2).drop_vars("correct").drop_dims("checkpoint").assign_coords(checkpoint=[100, 500])
    right = np.random.default_rng(1).uniform(size=(4, 2, 20))
    wide["correct"] = (("setting", "checkpoint", "trial"), right)
    wide["rounds"] = ("setting", [500, 100, 99, 600])
    found = measures.numbers(wide, "correct")
    assert (found[[0, 1, 3]] == right[[0, 1, 3], [1, 0, 1]]).all()
    assert np.isnan(found[2]).all()


def test_an_estimate_of_one_half_is_on_no_side():
    data = made_up(brains=2)
    data["final_estimate"][:] = 0.5
    data["fill_ratio"] = ("setting", [0.3, 0.3, 0.5, 0.5])
    found = measures.numbers(data, "right_side")
    assert (found[:2] == 0.0).all()
    assert np.isnan(found[2:]).all()


METRIC = """UNIT = "1"
MEANING = "lowest"
def begin(my):
    my.least = 1.0
def watch(my, k, estimate, truth):
    my.least = min(my.least, estimate)
def result(my):
    return my.least
"""


def with_metric(data, name="lowest"):
    data = data.copy()
    data[name] = (("setting", "trial", "robot"), data["final_estimate"].values, {"units": "1", "long_name": "lowest"})
    file = name.replace("_", "-")
    source = metrics.load(file).source if file in metrics.PLUGINS else METRIC
    data.attrs["metrics"] = json.dumps({name: {"name": file, "sha256": "", "source": source}})
    return data


def test_metrics_without_direction_are_not_compared():
    plain = sc.compare(with_metric(made_up()))
    assert "lowest" not in [one.name for one in plain.measures]
    assert any("metric='lowest:low' or 'lowest:high'" in one for one in plain.cautions)
    for way, low in (("low", True), ("high", False)):
        found = sc.compare(with_metric(made_up(gap=0.5)), f"lowest:{way}")
        assert (found.measures[0].low, len(found.measures)) == (low, 1)
        assert found.ranks["contender"][found.ranks["average_rank"].argmin()] == NAMES[0 if low else 3]
    assert sc.compare(with_metric(made_up(), "mean_error")).measures[-1].name == "mean_error"


@pytest.mark.parametrize(("metric", "said"), [
    ("final_eror", "metric='final_eror': did you mean"), ("lowest", "is low or high better"),
    ("lowest:up", "comes low or high"), ("correct:low", "of correct, high is better"),
    (["correct", "correct"], "given twice"), ("done_round", "no variable done_round"),
])  # fmt: skip
def test_a_measure_that_is_not_there_is_named(metric, said):
    with pytest.raises(sc.InputError, match=said):
        sc.compare(with_metric(made_up()), metric)


# ---- what comes of it
def test_pairs_are_what_scipy_says_trial_by_trial():
    data = made_up(gap=0.15)
    found = sc.compare(data, ["final_error", "correct"])
    frame = found.pairs
    assert len(frame) == 2 * 2 * 6
    for row in frame.to_dict("records"):
        numbers = measures.numbers(data, row["measure"])[4 * row["world"] :]
        one, other = (numbers[NAMES.index(row[name])] for name in ("one", "other"))
        off = np.round(one - other, 12)
        low = row["measure"] == "final_error"
        assert row["difference"] == pytest.approx(np.median(off) if low else off.mean(), abs=1e-11)
        place = row["world"] * 4 + NAMES.index(row["one"])
        errors = np.abs(data["final_estimate"].values[place] - 0.55)
        assert row["one_value"] == pytest.approx(np.median(errors) if low else one.mean())
        better, equal = ((off < 0) if low else (off > 0)).mean(), (off == 0).mean()
        assert row["superiority"] == pytest.approx(better + equal / 2)
        if low:
            assert row["p"] == pytest.approx(with_signs(off, stats.wilcoxon(off, method="exact").pvalue))
        elif (off != 0).sum() <= 12:  # ties and zeros
            assert row["p"] == pytest.approx(with_signs(off, by_every_sign(off)))
        assert (row["effect"] > 0) == (row["superiority"] > 0.5) or abs(row["effect"]) < 0.3
    for family in (frame, found.duels):
        every, corrected = family["p"].to_numpy(), family["p_holm"].to_numpy()
        order = np.argsort(every)
        due = np.minimum(1, np.maximum.accumulate(every[order] * np.arange(len(every), 0, -1)))
        assert corrected[order] == pytest.approx(due)
    assert (frame["told_apart"] <= (frame["p_holm"] <= 0.05)).all()
    assert frame["told_apart"].any()


def test_a_share_of_all_has_a_lower_end_only():
    data = made_up(brains=2, trials=9, robots=4)
    data["correct"][:] = 1.0
    found = sc.compare(data, "correct")
    low = 100.0 * found.table["correct_low"][0]
    assert f"[>= {low:.1f}]" in repr(found)
    assert "[>= x]: the same in all trials" in repr(found)
    assert rf"[$\geq$ {low:.1f}]" in found.to_latex()


def test_average_ranks_are_those_of_each_trial_and_world():
    data = made_up(gap=0.1)
    found = sc.compare(data, ["final_error", "right_consensus_round"])
    for name in ("final_error", "right_consensus_round"):
        numbers = measures.numbers(data, name).reshape(2, 4, 20)
        by_hand = stats.rankdata(numbers, axis=1).mean(axis=(0, 2))
        assert found.ranks[found.ranks["measure"] == name]["average_rank"].to_numpy() == pytest.approx(by_hand)
        duel = found.duels[found.duels["measure"] == name].iloc[0]
        ahead = (numbers[:, 0] < numbers[:, 1]).mean() - (numbers[:, 0] > numbers[:, 1]).mean()
        assert duel["ahead"] == pytest.approx(ahead)


def test_friedmans_tests_are_corrected_for_one_another_alone():
    found = sc.compare(made_up(trials=6, gap=0.6), ["final_error", "right_consensus_round", "correct"])
    ranks = found.ranks.drop_duplicates("measure")
    once, corrected = ranks["friedman_p"].to_numpy(), ranks["friedman_p_corrected"].to_numpy()
    assert corrected == pytest.approx(holm(once))
    assert corrected[0] == pytest.approx(3 * once[0])


def test_best_and_level_contenders():
    found = sc.compare(made_up(gap=0.6), "final_error")
    assert found.table["final_error_standing"].tolist() == ["best", "behind", "behind", "behind"] * 2
    said = "final error: of 2 worlds, minimalistic is best in 2; bayes-bots prior=1 is behind"
    assert found.verdict[0].startswith(said)
    alike = sc.compare(made_up(), "final_error")
    assert set(alike.table["final_error_standing"]) == {"level"}
    assert alike.verdict[0] == "final error: no contender is told apart from the first in any world"
    assert "; not told apart: " in alike.verdict[1]


def test_difference_without_distinct_pairs_is_reported():
    """Six trials are too few for any pair among so many tests, and enough for Friedman's one."""
    data = made_up(gap=0.6, trials=6)
    found = sc.compare(data, "final_error")
    assert not found.duels["told_apart"].any()
    assert "; not told apart: minimalistic and bayes-bots prior=1 and " in found.verdict[1]
    assert found.verdict[1].endswith(" (Friedman's test: p < 0.001)")
    [panel] = sc.plot.ranks(data, metric="final_error").axes
    assert "Friedman's test: p < 0.001" in " ".join(panel.get_title("left").split())


def test_the_cost_is_shown_too():
    data = made_up(brains=2, worlds=("ring",))
    one, other = measures.numbers(data, "bytes_sent").mean(axis=1)
    *_, sent, memory = sc.compare(data, "final_error").tables(0)[0].columns
    assert (sent.cells, memory.cells) == ([f"{one:,.0f}", f"{other:,.0f}"], ["48", "60"])
    bare = sc.compare(made_up(brains=2).drop_vars(["messages_sent", "message_bytes", "memory_bytes"]))
    assert any("do not say what brains cost: they have no messages_sent, no message_bytes" in c for c in bare.cautions)
    assert "memory" not in {column.head for column in bare.tables(0)[0].columns}
    part = sc.compare(made_up(brains=2).drop_vars(["memory_bytes", "message_bytes"]))
    assert part.tables(0)[0].columns[-1].head == "messages"


def test_events_that_never_happen_rank_last():
    data = made_up(brains=2, worlds=("ring",), trials=10)
    data["consensus_round"][:] = np.inf
    even = sc.compare(data, "right_consensus_round").pairs.iloc[0]
    assert (even["difference"], even["p"], even["superiority"]) == (0, 1, 0.5)
    data["consensus_round"][0, :9] = 100.0
    data["consensus_right"][0, :9] = 1.0
    [row] = sc.compare(data, "right_consensus_round").pairs.to_dict("records")
    assert row["p"] == 2 / 2**9
    assert (row["difference"], row["effect"], row["superiority"]) == (-math.inf, 1, 0.95)


def test_who_agrees_on_a_lie_is_not_the_faster_one():
    data = made_up(brains=2, worlds=("ring",), trials=10)
    data["consensus_round"][:] = [[10.0] * 10, [100.0] * 10]
    data["consensus_right"][:] = [[0.0] * 10, [1.0] * 10]
    [row] = sc.compare(data, "right_consensus_round").pairs.to_dict("records")
    assert (row["one_value"], row["other_value"], row["effect"]) == (math.inf, 100.0, -1)


def test_contradicting_difference_and_test_decide_nothing():
    """Better in most trials, and much worse in a few: the mean says one thing and the ranks another."""
    data = made_up(brains=2, worlds=("ring",), trials=30)
    data["correct"][0, 0] = [1.0] * 28 + [0.0] * 2
    data["correct"][1, 0] = [0.97] * 30
    [row] = sc.compare(data, "correct").pairs.to_dict("records")
    assert row["p_holm"] < 0.05
    assert row["difference"] < 0 < row["effect"]
    assert not row["told_apart"]


def test_trials_that_only_one_has_are_not_compared():
    data = forget(made_up(brains=2, worlds=("ring",)), setting=0, trial=[3, 4])
    data = forget(data, setting=1, trial=[4, 5, 6])
    found = sc.compare(data, "final_error")
    [row] = found.pairs.to_dict("records")
    assert row["trials"] == 16
    kept = [t for t in range(20) if t not in (3, 4, 5, 6)]
    assert row["p"] == sc.compare(data.isel(trial=kept), "final_error").pairs["p"][0]
    assert "contenders have 17 to 18 trials: paired trials are those that both have" in found.cautions[0]


def test_estimates_that_never_moved_and_names_are_cautions():
    data = made_up()
    data["convergence_round"].values[[3, 7]] = 0  # voter
    said = "voter: in worlds 0, 1 at least half of the robots have K = 0: their estimates never moved by delta"
    assert any(one.startswith(said) for one in sc.compare(data, ["convergence_round"]).cautions)
    assert not any("K = 0" in one for one in sc.compare(data, ["final_error"]).cautions)
    data["anonymous"] = data["anonymous"].where(data["brain"] != "voter", 0)
    assert "not anonymous, as robots' names are used: voter" in sc.compare(data).cautions


def test_who_alone_has_numbers_is_neither_first_nor_behind():
    data = made_up(brains=2, worlds=("ring",), trials=10)
    data["consensus_round"][1], data["consensus_right"][1] = np.nan, np.nan
    found = sc.compare(data, ["final_error", "right_consensus_round"])
    assert found.table["right_consensus_round_standing"].tolist() == ["", ""]
    assert "right consensus: no two contenders have numbers of it in the same world" in found.verdict


def test_too_few_trials_are_said_to_be():
    found = sc.compare(made_up(trials=6), "final_error")
    in_worlds, overall = (one for one in found.cautions if "cannot tell anything apart" in one)
    assert in_worlds.startswith("6 trials cannot tell anything apart among 12 tests: run 9 or more")
    assert overall.startswith("6 trials cannot tell anything apart over all worlds among 6 tests: run 8 or more")
    assert not any("cannot tell" in one for one in sc.compare(made_up(trials=10), "final_error").cautions)
    assert np.isnan(sc.compare(made_up(trials=5), "final_error").table["final_error_low"]).all()


# ---- LaTeX
def test_a_comparison_is_shown_as_its_verdict_and_its_table():
    comparison = sc.compare(made_up(brains=2, gap=3.0, worlds=("ring", "full <b>")), metric=["final_error", "correct"])
    text, html = repr(comparison), comparison._repr_html_()
    lines = text.splitlines()
    assert lines[0] == comparison.title
    assert lines[1].startswith(comparison.verdict[0][:80])
    table = lines[lines.index("all with robots 5, fill_ratio 0.55, accuracy 0.7, rounds 500") + 1 :]
    assert table[1].split()[:4] == ["0", "ring", "minimalistic", "*"]
    assert table[2].split()[:2] == ["bayes-bots", f"{comparison.table['final_error'][1]:.3f}"]
    assert html.count("<tr") == 1 + 4
    assert "full &lt;b&gt;" in html
    assert all(f"<li>{escape(sentence)}</li>" in html for sentence in comparison.verdict)
    assert "1 of 2 worlds" in "".join(table.more for table in comparison.tables(3))
    comparison.usual_limit = 3
    assert "1 of 2 worlds" in comparison._repr_html_()
    assert "full" not in comparison._repr_html_().partition("1 of 2 worlds")[0]


def test_latex_escapes_names_and_marks_the_best():
    data = made_up(brains=2, gap=0.8)
    data["brain"] = ("setting", ["a_b & 50%.py", r"c\d{}^~#$.py"] * 2)
    text = sc.compare(data, "final_error").to_latex()
    for name in (r"a\_b \& 50\%.py & ", r"c\textbackslash{}d\{\}\textasciicircum{}\textasciitilde{}\#\$.py"):
        assert name in text
    assert text.count(r"\textbf{") == 2
    rows = [line for line in text.splitlines() if line.endswith(r"\\")]
    columns = text.partition(r"\begin{tabular}{")[2].partition("}")[0]
    assert {line.replace(r"\&", "").count("&") + 1 for line in rows} == {len(columns)}
    assert escaped("\n line ") == "line"


def test_equal_contenders_are_reported():
    data = made_up(brains=3, worlds=("ring", "full"), trials=10)
    data["final_estimate"][1::3] = data["final_estimate"][2::3].values
    said = "final error: bayes-bots prior=1 and bayes-bots prior=10 are the same in every trial that both have"
    assert [one for one in sc.compare(data, "final_error").cautions if "same" in one] == [said]


@pytest.mark.parametrize(("metric", "mark"), zip(("final_error", "correct"), NAMES[1:3], strict=True))
def test_comparison_against_one_contender(mark, metric):
    """Pair by pair the tests are the same; Holm's correction is for those with that contender alone."""
    data = made_up(trials=20, gap=0.5)
    data["correct"][:] = np.clip(data["correct"] - 0.1 * (data["setting"] % 4), 0, 1)
    every, held = sc.compare(data, metric).pairs, sc.compare(data, metric, against=mark)
    mine = every[(every["one"] == mark) | (every["other"] == mark)].reset_index(drop=True)
    assert held.pairs["p"].tolist() == mine["p"].tolist()
    for table in (held.pairs, held.duels):  # each is a family of its own
        assert table["p_holm"].tolist() == pytest.approx(holm(table["p"].to_numpy()).tolist())
    assert (held.pairs["p_holm"] <= mine["p_holm"]).all()
    low, seen = metric == "final_error", set()
    for row in held.pairs.to_dict("records"):
        other = row["other"] if row["one"] == mark else row["one"]
        larger = (row["difference"] > 0) == (row["one"] == mark)  # the one that others are held against
        expected = "level" if not row["told_apart"] else "better" if larger == low else "worse"
        there = held.table[(held.table["world"] == row["world"]) & (held.table["contender"] == other)]
        assert there[f"{metric}_standing"].tolist() == [expected]
        seen.add(expected)
    assert seen - {"level"}
    assert (held.table[held.table["contender"] == mark][f"{metric}_standing"] == "").all()
    counts = held.ranks.set_index("contender")[["better", "level", "worse"]].sum(axis=1)
    assert counts.tolist() == [0 if name == mark else 2 for name in NAMES]


def test_the_verdict_against_one_is_of_each_other():
    said = sc.compare(made_up(brains=2, trials=30, gap=3.0), "final_error", against="bayes-bots").verdict
    assert said[0].endswith(": minimalistic is better in 2")
    overall = "final error, over all worlds together: minimalistic is better (better in 100%, worse in 0% of"
    assert said[1].startswith(overall)
    said = sc.compare(made_up(brains=2, trials=6), "final_error", against="bayes-bots").verdict
    assert said[0].endswith(": minimalistic is not told apart in 2")


def test_one_contender_is_named_to_compare_against():
    with pytest.raises(InputError, match="against='minimal': did you mean 'minimalistic'"):
        sc.compare(made_up(), against="minimal")
    with pytest.raises(InputError, match="these are several, bayes-bots prior=1, bayes-bots prior=10"):
        sc.compare(made_up(), against="bayes-bots")
