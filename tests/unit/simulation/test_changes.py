"""Floors that change and sensors that drift while robots look: what a study says, and what a run makes of it."""

import itertools
import json
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

import swarmcensus as sc
from swarmcensus.analysis import compare
from swarmcensus.analysis.explaining import wrong_beliefs
from swarmcensus.engine.changes import accuracy_in, fill_ratio_in
from swarmcensus.figures.kinds.arena import Arena
from swarmcensus.figures.kinds.curves import curves
from swarmcensus.figures.kinds.film import film
from swarmcensus.figures.one_trial import FLOOR, TURNS, scene_of
from swarmcensus.simulation import Stepped, sampling, walking
from swarmcensus.simulation.rides import run_ride
from swarmcensus.simulation.trials import Metrics, record_estimates, run_batch
from swarmcensus.studies import addresses
from swarmcensus.summaries import measures, replay
from swarmcensus.summaries.selecting import where
from swarmcensus.worlds import patterns
from swarmcensus.worlds.changes import Change, along, read_change
from swarmcensus.worlds.ground import Ground
from tests.reference import rounds as reference
from tests.support.places import EXAMPLE
from tests.support.small import GO, SEED, SLOW, SWITCH, called, changing, moving_of, settings_of, study_of
from tests.support.trials import record_ride


# ---- what it is
def test_a_course_is_what_the_docs_say():
    """From `at` on it moves by equal steps, and in round `until` it has arrived; a switch is one step."""
    slow = along(Change(0.8, 0.2, 4, 6).course, np.arange(1, 9))
    assert slow == pytest.approx([0.8, 0.8, 0.8, 0.6, 0.4, 0.2, 0.2, 0.2], abs=1e-15)
    assert along(Change(0.8, 0.2, 4).course, np.arange(1, 7)).tolist() == [0.8] * 3 + [0.2] * 3
    assert along(Change(0.8, 0.2, 4, 4).course, np.arange(1, 7)).tolist() == [0.8] * 3 + [0.2] * 3


@pytest.mark.parametrize("change", [Change(0.1, 0.7, 5), Change(0.9, 0.3, 3, 17), Change(1 / 3, 0.7, 2, 1000)])
def test_engine_dataset_and_reference_agree_on_it_to_the_bit(change):
    (setting,) = settings_of(rounds=30)
    setting = replace(setting, change=change)
    rounds = np.arange(1, 31)
    found = along(change.course, rounds).tolist()
    assert found == [called(fill_ratio_in)(change.course, k) for k in rounds]
    assert found == [reference.fill_ratio_in(setting, int(k)) for k in rounds]
    assert read_change(str(change)) == change


@pytest.mark.parametrize(("drift", "bound"), [(-0.03, {"least": 0.6}), (0.02, {"most": 0.85}), (-0.03, {}), (0.05, {})])
def test_accuracies_drift_to_their_bound_and_stay(drift, bound):
    (setting,) = settings_of(accuracy={"start": "U(0.7, 0.8)", "drift": drift, **bound})
    b, w, assumed_b, assumed_w = sampling.accuracies(setting, SEED, 0, 2)
    assert (b == w).all()
    assert (b == assumed_b).all()  # who knows its sensor knows how it began
    assert (w == assumed_w).all()
    (plain,) = settings_of(accuracy="U(0.7, 0.8)")
    assert (b == sampling.accuracies(plain, SEED, 0, 2)[0]).all()
    moves = sampling.drifts(setting, SEED, 0, 2, b)
    in_round = called(accuracy_in)
    end = bound.get("least", 0.5) if drift < 0 else bound.get("most", 1.0)
    for k in range(1, 30):
        for i in range(5):
            due = max(b[1, i] + drift * (k - 1), end) if drift < 0 else min(b[1, i] + drift * (k - 1), end)
            assert in_round(b[1], moves[1], i, k) == due == reference.accuracy_in(setting, 0, b[1, i], k)


def test_who_starts_beyond_the_bound_stays_there():
    """Of a normal spread only the mean is held against the bound."""
    (setting,) = settings_of(robots=60, accuracy={"start": "N(0.7, 0.2)", "drift": -0.01, "least": 0.65})
    b = sampling.accuracies(setting, SEED, 0, 1)[0][0]
    moves = sampling.drifts(setting, SEED, 0, 1, b[np.newaxis])[0]
    assert 5 < np.flatnonzero(b < 0.65).size < 55
    ends = np.array([called(accuracy_in)(b, moves, i, 1000) for i in range(60)])
    assert (ends == np.where(b < 0.65, b, 0.65)).all()


# ---- what it shares
@pytest.mark.parametrize("world", [{}, {"topology": "moving", "density": 8}], ids=["fixed", "moving"])
def test_until_it_changes_a_world_is_the_one_that_stays(world):
    """The same tiles, readings and messages; and after it none of the old floor's."""
    early, late = sc.run(changing(SWITCH, world=world)), sc.run(changing(0.85, world=world))
    one, other = (sc.replay(data, 0, 1)["estimate"].values for data in (early, late))
    assert (one[:31] == other[:31]).all()
    assert (one[-1] != other[-1]).all()
    drifts = sc.run(changing(0.85, {"start": 0.9, "drift": -0.001}, world))
    read = [sc.replay(data, 0, 1)[{True: "reading", False: "blacks"}[bool(world)]].values for data in (drifts, late)]
    assert np.array_equal(read[0][:2], read[1][:2], equal_nan=True)


def test_they_are_settings_of_their_own():
    made = changing([0.25, SWITCH, SLOW, SWITCH | {"from": 0.8}], [0.9, {"start": 0.9, "drift": -0.001}])
    settings = made.settings()
    assert len({addresses.fingerprint(s, 7) for s in settings}) == len(settings) == 8
    results = sc.run(made)
    assert (results["fill_ratio"] == 0.25).all()
    assert results["fill_ratio_change"].values[:4].tolist() == [
        "", "0.85 to 0.25 at 31", "0.85 to 0.25 at 31 until 71", "0.8 to 0.25 at 31"
    ]  # fmt: skip
    assert set(results["accuracy"].values) == {"0.9", "0.9 drift=-0.001 least=0.5"}
    assert (results["assumed_accuracy"] == "0.9").all()
    assert "fill_ratio_change" not in sc.run(changing(0.25))
    assert sc.Study.parse(made.text).settings() == settings
    for text, count in (("fill_ratio == 0.25", 8), ('fill_ratio_change == "0.85 to 0.25 at 31"', 2)):
        assert where(results, text).sizes["setting"] == count


def test_the_fill_ratio_of_a_setting_is_that_of_its_last_round():
    made = changing(SLOW, schedule={"rounds": [20, 40, 100]})
    assert [s.fill_ratio for s in made.settings()] == pytest.approx([0.85, 0.85 - 0.6 * 10 / 41, 0.25], abs=1e-15)


# ---- the same life, however it is lived
@pytest.mark.parametrize("change", [SWITCH, SLOW], ids=["switch", "drift"])
def test_walks_in_chunks_change_in_the_same_tick(change, monkeypatch):
    setting = moving_of(ticks=100, fill_ratio=change, accuracy={"start": 0.9, "drift": -0.004})
    whole = record_ride(setting, SEED, 1)
    monkeypatch.setattr(walking, "CHUNK_BYTES", 6 * 41 * 7)
    parts = record_ride(setting, SEED, 1)
    assert (whole.estimates == parts.estimates).all()
    assert np.array_equal(whole.readings, parts.readings, equal_nan=True)


# ---- what is asked and told later
def test_an_accuracy_is_read_from_the_text_of_a_dataset():
    """And no cost of a belief is predicted where the truth drifts."""
    told = {"start": "U(0.8, 0.9)", "drift": -0.001, "least": 0.6}
    made = changing(0.3, [0.9, told, {"start": 0.9, "drift": 0.002}])
    results = sc.run(made)
    for text, setting in zip(results["accuracy"].values, made.settings(), strict=True):
        assert wrong_beliefs.accuracy_of(text) == setting.accuracy
    assert [np.isnan(cost.predicted) for cost in wrong_beliefs.costs_of(results)] == [False, True, True]


# ---- floors whose fill ratio changes: which tiles turn, and what is drawn of them
IMAGE = str(EXAMPLE / "leaves.png")


@pytest.mark.parametrize(
    "kind", ["tiles", "half", {"clusters": 0.2}, {"stripes": 0.5}, {"image": IMAGE}, {"image": IMAGE, "mode": "dither"}]
)
def test_as_few_tiles_turn_as_can(kind):
    """Black tiles of less are among those of more; each floor is that of its fill ratio, and so is its true share."""
    world = {"density": 8.0, "floor": kind}
    setting = moving_of(ticks=50, fill_ratio={"from": 0.7, "to": 0.2, "at": 11, "until": 40}, **world)
    ground = sampling.ground(setting, SEED, 1)
    tiles, turns = ground.all_tiles().astype(bool), ground.turns()
    floors = [tiles ^ (tick >= turns) for tick in range(1, 51)]
    assert all((later <= earlier).all() for earlier, later in itertools.pairwise(floors))
    for tick in (1, 10, 11, 25, 40, 50):
        key, fill = addresses.floor_key(setting, SEED), along(setting.change.course, [tick])
        same = Ground(setting.floor, setting.body, setting.arena_side, fill, key, 1)
        assert (same.all_tiles().astype(bool) == floors[tick - 1]).all()
        assert same.true_fill_ratio == ground.truth(tick)
        place = np.stack(np.meshgrid(np.arange(-5, 5), np.arange(-5, 5)), axis=-1).reshape(1, -1, 2).astype(np.int32)
        assert (same.colours(place) == ground.colours(place, tick)).all()
    change = {"from": 0.0, "to": 1.0, "at": 11, "until": 40}
    rising = sampling.ground(moving_of(ticks=50, fill_ratio=change, **world), SEED, 1)
    assert not rising.all_tiles().any()
    assert (rising.turns() >= 11).all()
    assert (rising.turns() <= 40).all()
    assert rising.truth([1, 10, 40, 99]).tolist() == [0.0, 0.0, 1.0, 1.0]


def test_figures_show_the_truth_and_the_floor_of_the_moment(tmp_path):
    world = {"topology": "moving", "density": 8}
    results = sc.run(changing([SLOW, 0.25], {"start": 0.9, "drift": -0.002}, world))
    (truth,) = [line for line in curves(results, setting=0).axes[0].lines if line.get_label() == "truth"]
    assert truth.get_ydata() == pytest.approx(along(Change(0.85, 0.25, 31, 71).course, np.arange(101)))
    trace = scene_of(results, 0)
    ground = sampling.ground(changing(SLOW, {"start": 0.9, "drift": -0.002}, world).settings()[0], 7, 0)
    arena = Arena(trace)
    for tick in (5, 50, 100):
        arena.show(tick)
        drawn = np.asarray(arena.image.get_array())
        assert (drawn < 0.9).mean() == pytest.approx(float(ground.truth(tick)), abs=0.05)
        truth = f"true f = {float(along(Change(0.85, 0.25, 31, 71).course, tick)):.4g}"
        assert truth in [text.get_text() for text in arena.bar.get_yticklabels()]
    assert len(arena.axes.child_axes) == 1
    assert arena.paint(100) is False
    empty = Arena(trace.drop_vars([FLOOR, TURNS]))
    before = empty.axes.get_facecolor()
    empty.show(100)
    assert empty.axes.get_facecolor() != before
    assert film(trace, out=tmp_path / "f.gif", first=29, last=33) == 3


def test_a_floor_that_cannot_tell_which_tiles_turn_is_refused(tmp_path, monkeypatch):
    monkeypatch.delattr(patterns.PLUGINS.module("tiles"), "level")
    with pytest.raises(sc.InputError, match=r'world.floor = "?tiles'):
        changing(SWITCH, world={"topology": "moving", "density": 8, "floor": "tiles"})


# ---- fill ratios that each trial draws: how, for whom, and that all else refers to what was drawn
DRAWN = "U(0.3, 0.7)"
MEASURE = Metrics(0.02, 10, (2, 8), estimates=True)


def drawn_of(setting, trials):
    return np.array([addresses.in_trial(setting, SEED, trial).fill_ratio for trial in range(trials)])


@pytest.mark.parametrize(("spread", "law"), [(DRAWN, stats.uniform(0.3, 0.4)), ("N(0.5, 0.05)", stats.norm(0.5, 0.05))])
def test_trials_draw_from_the_spread(spread, law):
    (setting,) = settings_of(fill_ratio=spread)
    assert (setting.fill_ratio, settings_of(fill_ratio="U(0.2, 0.4)")[0].fill_ratio) == (0.5, 0.3)
    drawn = drawn_of(setting, 1000)
    assert stats.kstest(drawn, law.cdf).pvalue > 1e-3  # fails for one seed in a thousand
    assert abs(stats.pearsonr(drawn[:-1], drawn[1:])[0]) < 3.3 / 1000**0.5  # the same


def test_settings_that_differ_in_other_things_draw_the_same():
    first, *others = settings_of(brain=["commons", "minimalistic"], topology=["ring", "full"], fill_ratio=DRAWN)
    others += [*settings_of(robots=7, accuracy=0.9, rounds=3, fill_ratio=DRAWN), moving_of(fill_ratio=DRAWN)]
    assert all((drawn_of(first, 5) == drawn_of(other, 5)).all() for other in others)
    (apart,) = settings_of(fill_ratio="U(0.3, 0.71)")
    (fixed,) = settings_of(fill_ratio=0.5)
    shared = [addresses.streams(one, SEED)["readings"] for one in (first, others[0], apart, fixed)]
    assert shared[0] == shared[1]
    assert shared[2] not in shared[:2]
    assert shared[3] not in shared[:3]
    assert not np.isclose((drawn_of(first, 5) - 0.3) / 0.4, (drawn_of(apart, 5) - 0.3) / 0.41).any()


def same_batches(one, two):
    for name in ("convergence", "error", "final", "correct", "agreement", "fill_ratio", "kept"):
        np.testing.assert_array_equal(getattr(one, name), getattr(two, name), err_msg=name)


@pytest.mark.parametrize("more", [{}, {"members": [{"robots": 2, "accuracy": 0.5}]}, {"brain": "commons"}])
def test_a_trial_is_that_of_a_setting_with_the_number_that_it_drew(more):
    (setting,) = settings_of(fill_ratio=DRAWN, **more)
    batch = run_batch(setting, SEED, 2, 3, MEASURE, GO)
    for k, trial in enumerate((2, 3, 4)):
        own = addresses.in_trial(setting, SEED, trial)
        (plain,) = settings_of(fill_ratio=own.fill_ratio, **more)
        assert own == plain
        alone = run_batch(plain, SEED, trial, 1, MEASURE, GO)
        assert batch.final[k].tolist() == alone.final[0].tolist()
        assert batch.error[k].tolist() == alone.error[0].tolist()
        assert batch.correct[:, k].tolist() == alone.correct[:, 0].tolist()
        assert record_estimates(setting, SEED, trial)[-1].tolist() == alone.final[0].tolist()
        live = Stepped(setting, SEED, trial)
        assert live.setting == plain
        assert live.at(0).estimates[-1].tolist() == alone.final[0].tolist()


def test_robots_that_move_see_a_floor_of_what_was_drawn():
    setting = moving_of(robots=4, ticks=12, fill_ratio=DRAWN)
    plain = moving_of(robots=4, ticks=12, fill_ratio=addresses.in_trial(setting, SEED, 1).fill_ratio)
    (one,), (other,) = (run_ride([chosen], SEED, 1, MEASURE, GO) for chosen in (setting, plain))
    same_batches(one, other)
    assert one.true_fill_ratio == other.true_fill_ratio
    assert abs(float(one.true_fill_ratio[0]) - plain.fill_ratio) < 0.1


@pytest.fixture(scope="module")
def results():
    keys = {"rounds": 8, "trials": 12, "accuracy": 0.9, "measure": {"estimates": True, "bins": 4}}
    return sc.run(study_of(brain=["commons", "minimalistic"], fill_ratio=[DRAWN, 0.6], **keys), jobs=1)


def test_results_have_the_mean_as_a_coordinate_and_what_was_drawn(results):
    assert results["fill_ratio"].values.tolist() == [0.5, 0.6] * 2
    assert results["fill_ratio_spread"].values.tolist() == ["U(0.3,0.7)", ""] * 2
    drawn = results["drawn_fill_ratio"]
    assert drawn.dims == ("setting", "trial")
    assert (drawn[0] == drawn[2]).all()
    assert np.unique(drawn[0]).size == 12
    assert (drawn[1] == 0.6).all()
    assert sc.verify(results).labels == sc.verify(results).differences == []


def test_errors_and_decisions_refer_to_what_was_drawn(results):
    drawn, final = results["drawn_fill_ratio"].values[..., np.newaxis], results["final_estimate"].values
    np.testing.assert_array_equal(measures.sample(results, "final_error", np.arange(4)), np.abs(final - drawn))
    right = (np.floor(4 * final) == np.floor(4 * drawn)).mean(axis=2)
    np.testing.assert_array_equal(results["correct"].values[:, -1], right)
    assert sc.summary(results)["final_error"][0] == np.median(np.abs(final - drawn)[0])


def test_replays_and_comparisons_know_what_was_drawn(results):
    trace = replay(results, 0, 3)
    assert trace.attrs["fill_ratio"] == results["drawn_fill_ratio"].values[0, 3]
    assert trace["estimate"].values[-1].tolist() == results["final_estimate"].values[0, 3].tolist()
    assert [*compare(results).grid.worlds[0]] == ["fill_ratio", "fill_ratio_spread"]
    assert compare(results, factor="fill_ratio_spread").contenders == ["fill_ratio_spread=U(0.3,0.7)", "f fixed"]


def test_results_of_studies_with_and_without_merge(results):
    plain = sc.run(study_of(fill_ratio=0.5, rounds=8, trials=4, measure={"estimates": True, "bins": 4}), jobs=1)
    merged = sc.merge([results, plain])
    assert measures.truth(merged)[-1].tolist()[:4] == [0.5] * 4
    assert measures.truth(merged)[0].tolist() == results["drawn_fill_ratio"].values[0].tolist()
    assert sc.verify(merged, 1).labels == []
    assert json.loads(merged.attrs["merged"])


@pytest.mark.parametrize(("value", "said"), [
    ("U(0.3", "a fill ratio is a number in [0, 1], or a shipped spread"),
    ("0.5", "a fill ratio is a number in [0, 1], or a shipped spread"),
    ("mine.py(1)", "a fill ratio is a number in [0, 1], or a shipped spread"),
    ("U(0.5, 1.5)", "a fill ratio is a number in [0, 1], or a shipped spread"),
    ({"spread": "U", "lo": [], "hi": 0.5}, "lo = []: should be a list of at least one"),
])  # fmt: skip
def test_wrong_spreads_are_refused(value, said):
    with pytest.raises(sc.InputError) as refused:
        study_of(fill_ratio=value)
    assert said in str(refused.value)
    assert "world.fill_ratio" in str(refused.value)
