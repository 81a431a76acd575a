"""`sc.explain`, `explain` and theory's curves in figures, also where theory does not hold."""

import re

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

import swarmcensus as sc
from swarmcensus import theory
from swarmcensus.analysis.explaining.expectations import ALONE, MIXED, NEAR, SWARM, expect
from swarmcensus.analysis.explaining.wrong_beliefs import EQ_4, costs
from swarmcensus.simulation import sampling
from swarmcensus.support.errors import InputError
from swarmcensus.theory import asymptote

BASE = {
    "trials": 10, "seed": 3,
    "swarm": {"robots": 12, "accuracy": 0.8}, "world": {"topology": "ring", "fill_ratio": 0.55},
    "schedule": {"rounds": 30, "observations_per_round": 10}, "measure": {"checkpoints": [5, 30]},
}  # fmt: skip


def run(**changes):
    tables = dict(BASE)
    for table, values in changes.items():
        tables[table] = tables.get(table, {}) | values if isinstance(values, dict) else values
    return sc.run(sc.Study(**tables))


@pytest.fixture(scope="module")
def results():
    swarm = {"brain": ["minimalistic", "commons"], "accuracy": [0.8, "U(0.6, 0.9)"]}
    return run(swarm=swarm, world={"topology": ["ring", "scale-free"]})


def walk(truth="nominal"):
    """Robots that move."""
    world = {"topology": "moving", "density": 4, "fill_ratio": 0.55}
    more = {"schedule": {"ticks": 200}, "measure": {"truth": truth}}
    return sc.run(sc.Study(trials=6, seed=3, swarm=BASE["swarm"], world=world, **more))


def only(results, **values):
    mask = np.logical_and.reduce([results[name].values == value for name, value in values.items()])
    return int(results["setting"].values[mask][0])


def test_measured_figures_are_those_of_the_results(results):
    number = only(results, brain="minimalistic", topology="ring", accuracy="0.8")
    found, one = sc.explain(results, number), results.sel(setting=number)
    off = one["final_estimate"].values - 0.55
    assert found.median_error[0] == np.median(np.abs(off))
    assert found.squared_error[0] == pytest.approx((off**2).mean())
    assert (found.sd, found.bias) == (pytest.approx(off.std()), pytest.approx(off.mean()))
    assert found.convergence_round[0] == np.median(one["convergence_round"])
    assert [share[0] for share in found.right] == pytest.approx(one["correct"].mean("trial").values.tolist())
    assert (found.checkpoints, found.rounds, found.trials, found.unit) == ([5, 30], 30, 10, "rounds")


def test_lines_are_theorys(results):
    lines = sc.explain(results, only(results, brain="minimalistic", topology="ring", accuracy="0.8")).theory
    assert {*lines} == {ALONE, NEAR, MIXED, SWARM}
    ring = theory.mixing_matrix("ring", 12)
    for k, rounds in enumerate((5, 30, 30)):
        law = theory.local_law(10 * rounds, 0.55, 0.8)
        assert lines[ALONE].variance[k] == pytest.approx(law.variance)
        assert lines[ALONE].median_error[k] == theory.error_law(law, 0.55).quantile(0.5)
        assert lines[ALONE].right[k] == pytest.approx(theory.right_share(law, 0.55))
        mixed = theory.mixed_sums(ring, rounds, 10, 0.55, 0.8).variance[0]
        assert lines[MIXED].variance[k] == pytest.approx(mixed)
        assert lines[MIXED].right[k] == pytest.approx(float(theory.normal_right_share(mixed, 0.55)))
        bound = float(theory.swarm_bound(10 * rounds, 0.55, 0.8, robots=12))
        assert lines[SWARM].variance[k] == pytest.approx(bound)
        assert lines[NEAR].variance[k] == pytest.approx(4 * bound)
        assert lines[SWARM].median_error[k] == pytest.approx(float(theory.median_error(bound)))
        assert (lines[SWARM].low[k] + lines[SWARM].high[k]) / 2 == pytest.approx(0.55)


def test_explanation_uses_the_trials_own_draws(results):
    number = only(results, brain="minimalistic", topology="scale-free", accuracy="U(0.6,0.9)")
    study = sc.Study.parse(results.attrs["study"])
    setting = study.settings()[number]
    b, w = sampling.accuracies(setting, study.seed, 0, 10)[:2]
    found = expect(results, number, [30])
    assert found.lines[SWARM].variance[0] == pytest.approx(theory.swarm_bound(300, 0.55, b, w).mean())
    expected = []
    for trial in range(10):
        links = sampling.links(setting, study.seed, trial, 1)
        matrix = theory.mixing_matrix(np.stack([links.senders, links.receivers], 1).tolist(), 12, directed=True)
        expected.append(theory.mixed_sums(matrix, 30, 10, 0.55, b[trial], w[trial]).variance)
    assert found.lines[MIXED].variance[0] == pytest.approx(np.mean(expected))


def test_what_limits_a_swarm(results):
    """The paper's brain does not pass news on; sums that are mixed leave nothing to it."""
    lazy = sc.explain(results, only(results, brain="minimalistic", topology="ring", accuracy="0.8"))
    busy = sc.explain(results, only(results, brain="commons", topology="ring", accuracy="0.8"))
    assert max(lazy.terms, key=lazy.terms.get) == "mixing"
    assert lazy.limit.startswith("mixing: ")
    assert "count equally" not in sc.explain(run(swarm={"brain": "alone"}), 0).limit
    assert busy.efficiency[0] > 2 * lazy.efficiency[0]
    assert sum(lazy.terms.values()) == pytest.approx(lazy.squared_error[0])
    assert max(busy.terms, key=busy.terms.get) in ("sensors", "time")
    low, high = lazy.squared_error[1:]
    bound = lazy.theory[SWARM].variance[-1]
    assert lazy.efficiency == pytest.approx((bound / lazy.squared_error[0], bound / high, bound / low))


def test_under_robots_that_move_the_floor_has_its_part():
    found = sc.explain(walk(), 0)
    assert {*found.theory} == {SWARM}
    assert (found.unit, [*found.terms]) == ("ticks", ["sensors", "floor", "mixing"])
    assert found.terms["floor"] > 0.0
    assert {*found.absent} == {ALONE, NEAR, MIXED}
    assert sc.explain(walk("floor"), 0).terms["floor"] == 0.0


NOWHERE = {ALONE, NEAR, MIXED, SWARM}


@pytest.mark.long(but=["changes1-absent1-sensors drift", "changes7-absent7-messages are lost"])
@pytest.mark.interpreted
@pytest.mark.parametrize(("changes", "absent", "why"), [
    ({"world": {"fill_ratio": {"from": 0.85, "to": 0.15, "at": 9}}}, NOWHERE, "the floor changes while robots obs"),
    ({"swarm": {"accuracy": {"start": 0.8, "drift": -0.001}}}, NOWHERE, "sensors drift"),
    ({"members": [{"robots": 2, "brain": "opposite", "honest": False}]}, NOWHERE, "some robots lie"),
    ({"faults": [{"at": 3, "robots": 2, "stop": "sensing"}]}, NOWHERE, "parts of robots fail"),
    ({"swarm": {"brain": {"file": "sure", "within": 0.4}}}, NOWHERE, "some robots are done before the end"),
    ({"swarm": {"accuracy": 0.5}}, NOWHERE, "b + w = 1: readings say nothing of the floor"),
    ({"swarm": {"assumed_accuracy": 0.7}}, {ALONE, MIXED}, "robots are wrong about their sensors"),
    ({"world": {"link_success": 0.5}}, {MIXED}, "messages are lost"),
])  # fmt: skip
@pytest.mark.filterwarnings("ignore:.*carries no information:UserWarning")
def test_where_theory_does_not_hold_it_says_why(changes, absent, why):
    data = run(trials=6, **changes)
    found = sc.explain(data, 0)
    assert {*found.absent} == absent
    assert all(said.startswith(why) for said in found.absent.values())
    assert {*found.theory} == NOWHERE - absent
    assert bool(found.terms) == (SWARM not in absent)
    for figure in (sc.plot.lines(data, x="checkpoint", theory=True), sc.plot.scatter(data, theory=True)):
        drawn = [line for line in figure.axes[0].lines if str(line.get_label()).startswith("theory")]
        assert len(drawn) == len({ALONE, SWARM} - absent)
        assert (f"no theory: {why}" in " ".join(sc.plot.caption(figure).split()).lower()) == (not drawn)


def test_it_is_printed(results, here, accepted):
    sc.save(results, "some.nc")
    number = only(results, brain="commons", topology="ring", accuracy="0.8")
    out, found = accepted("explain", "some.nc", "--setting", number).out, sc.explain(results, number)
    rows = {line[:20].strip(): line[20:].split() for line in out.splitlines()}
    for said, name in (("a robot alone", ALONE), ("its neighbourhood", NEAR), ("mixed sums", MIXED)):
        line = found.theory[name]
        assert rows[said][0] == f"{line.median_error[-1]:.4f}"
        assert rows[said][-1] == f"{100 * line.right[-2]:.1f}"
    assert re.search(rf"^efficiency: {found.efficiency[0]:.3g} \[", out, re.MULTILINE)
    assert "made of sensors" in out
    assert f"What limits it most is {found.limit}" in out


@pytest.fixture(scope="module")
def file(results, tmp_path_factory):
    path = tmp_path_factory.mktemp("explained") / "some.nc"
    sc.save(results, path)
    return path


@pytest.mark.parametrize(("arguments", "said"), [
    (["--setting", "99"], "--setting 99: these results hold setting 0 to 7"),
    (["--setting", "-1"], "should be a whole number from 0"),
    (["--setting", "1", "--where", "robots == 12"], "--where does not go with --setting, which shows one setting"),
    (["--where", "robots == 7"], "where"),
])  # fmt: skip
def test_a_setting_that_is_not_there_is_named(file, arguments, said, refused):
    assert said in refused("explain", file, *arguments)


def test_where_nobody_errs_nothing_limits(tmp_path, accepted):
    swarm = {"brain": "commons", "robots": 2, "accuracy": 1.0}
    sc.save(run(trials=6, swarm=swarm, world={"fill_ratio": 1}), tmp_path / "some.nc")
    out = accepted("explain", tmp_path / "some.nc", "--setting", "0").out
    assert "nothing limits it" in out
    assert "efficiency" not in out


# ---- figures
def theory_of(axes):
    return {str(line.get_label()): line for line in axes.lines if str(line.get_label()).startswith("theory")}


def test_decisions_carry_expected_shares(results):
    part = results.isel(setting=results["brain"].values == "minimalistic")
    figure = sc.plot.lines(part, x="checkpoint", theory=True)
    said = " ".join(sc.plot.caption(figure).split())
    assert "dashed lines are theory" in said
    assert "diamond" not in said
    number = only(results, brain="minimalistic", topology="ring", accuracy="0.8")
    drawn = theory_of(figure.axes[0])
    assert {*drawn} == {f"theory {name} {a}" for name in (ALONE, SWARM) for a in ("0.8", "U(0.6,0.9)")}
    for name, line in sc.explain(results, number).theory.items():
        if name in (ALONE, SWARM):
            np.testing.assert_allclose(drawn[f"theory {name} 0.8"].get_ydata(), 100 * line.right[:2])
    told = [text.get_text().replace("\n", " ") for text in figure.axes[0].get_legend().get_texts()]
    assert {"theory: a robot alone", "theory: all readings at once"} <= {*told}
    assert not theory_of(sc.plot.lines(part, x="checkpoint").axes[0])


def test_what_theory_says_of_several_brains_is_drawn_once(results):
    """It is of sensors, and not of brains."""
    part = results.isel(setting=(results["topology"].values == "ring") & (results["accuracy"].values == "0.8"))
    drawn = theory_of(sc.plot.scatter(part, color="brain", theory=True).axes[0])
    assert {*drawn} == {f"theory {name}" for name in (ALONE, SWARM)}
    expected = sc.explain(part, only(part, brain="minimalistic")).theory[SWARM].median_error[-1]
    assert drawn[f"theory {SWARM}"].get_ydata()[0] == expected


def test_curves_carry_middle_halves(results):
    number = only(results, brain="minimalistic", topology="ring", accuracy="0.8")
    figure = sc.plot.curves(results, setting=number, theory=True)
    lines = [line for line in figure.axes[0].lines if line.get_label() == "theory alone"]
    law = theory.local_law(300, 0.55, 0.8)
    assert [line.get_ydata()[-1] for line in lines] == [law.quantile(0.25), law.quantile(0.75)]
    with pytest.raises(InputError, match="theory needs a study's results, not a trace"):
        sc.plot.curves(sc.replay(results, number, 0), theory=True)


# ---- what wrong beliefs cost: the closed form against the likelihood and the simulation, and the figure of both
STUDY = """
seed = 5
trials = 12
swarm.robots = 20
swarm.accuracy = [0.675, {black = 0.9, white = 0.7}]
swarm.assumed_accuracy = [{error = -0.05}, {error = 0}, {error = 0.05}, {error = "N(0, 0.05)"}]
world = {topology = TOPOLOGY, fill_ratio = [0.55, 0.95]}
schedule = {LENGTH}
"""


@pytest.mark.parametrize("seed", range(5))
def test_asymptote_maximises_the_expected_likelihood(seed):
    rng = np.random.default_rng(seed)
    for _ in range(40):
        b, w, assumed_b, assumed_w, f = rng.uniform(0.02, 0.98, 5)
        if abs(assumed_b + assumed_w - 1) < 0.02:
            continue
        p = b * f + (1 - w) * (1 - f)

        def loss(x, p=p, b=assumed_b, w=assumed_w):
            black = b * x + (1 - w) * (1 - x)
            return -(p * np.log(black) + (1 - p) * np.log(1 - black))

        found = minimize_scalar(loss, bounds=(0, 1), method="bounded", options={"xatol": 1e-9}).x
        assert asymptote(b, w, assumed_b, assumed_w, f) == pytest.approx(found, abs=1e-4)


@pytest.mark.interpreted
def test_asymptote_of_expected_readings():
    """A hundred readings, of which the very share that is expected says black, in the brain itself."""
    cases = [(0.8, 0.6, 0.7, 0.75, 0.5), (0.7, 0.7, 0.6, 0.6, 0.9), (0.9, 0.9, 0.3, 0.3, 0.4)]
    for b, w, assumed_b, assumed_w, f in cases:
        readings = (np.arange(100) < round(100 * (b * f + (1 - w) * (1 - f)))).astype(float)[:, np.newaxis]
        for brain in sorted(EQ_4):
            assumed = {"black": assumed_b, "white": assumed_w}
            trace = sc.infer(readings, None, assumed, brain=brain, observations_per_round=100)
            predicted = float(asymptote(b, w, assumed_b, assumed_w, f))
            assert trace["estimate"].values[-1, 0] == pytest.approx(predicted, abs=1e-12)


@pytest.mark.long(but=["full"])
@pytest.mark.parametrize("topology", ['"full"', '"moving", density = 10'], ids=["full", "moving"])
def test_swarms_go_where_the_closed_form_says(topology):
    """The mean final estimate, within 4.5 standard errors over trials: 12 settings fail together once in 10^4.

    Only where nothing is cut is the estimate's mean its limit; 5e-4 are for a bias of the order of 1 / observations.
    """
    length = "rounds = 400" if topology == '"full"' else "ticks = 2000"
    text = STUDY.replace("TOPOLOGY", topology).replace("LENGTH", length).replace("trials = 12", "trials = 40")
    text = text.replace('{error = 0}, {error = 0.05}, {error = "N(0, 0.05)"}', "{error = 0}, {error = 0.05}")
    data = sc.run(sc.Study.parse(text.replace("0.95]", "0.4]")), jobs=2)
    sides = {"0.675": (0.675, 0.675), "black=0.9 white=0.7": (0.9, 0.7)}
    for k, cost in enumerate(costs(data)):
        b, w = sides[cost.accuracy]
        goes_to = asymptote(b, w, b + cost.error, w + cost.error, cost.fill_ratio)
        final = data["final_estimate"].values[k].mean(axis=1)
        assert abs(final.mean() - goes_to) < 4.5 * final.std(ddof=1) / np.sqrt(len(final)) + 5e-4
        assert cost.predicted == pytest.approx(abs(goes_to - cost.fill_ratio), abs=1e-12)


def test_assumed_accuracies_are_clipped_to_0_and_1():
    text = STUDY.replace("TOPOLOGY", '["ring", "full"]').replace("LENGTH", "rounds = 400").replace("= 12", "= 1")
    accuracy, assumed = (re.search(rf"swarm.{name} = .*", text)[0] for name in ("accuracy", "assumed_accuracy"))

    def told(accuracies, beliefs_):
        changed = text.replace(accuracy, f"swarm.accuracy = {accuracies}")
        return costs(sc.run(sc.Study.parse(changed.replace(assumed, f"swarm.assumed_accuracy = {beliefs_}"))))

    assert {c.error for c in told("0.7", "[0.6, 0.7, {black = 0.8, white = 0.8}]")} == {-0.1, 0.0, 0.1}
    for cost in told("{black = 0.9, white = 0.7}", "{error = 0.2}"):
        f = cost.fill_ratio
        assert cost.predicted == pytest.approx(abs(float(asymptote(0.9, 0.7, 1.0, 0.9, f)) - f))
        assert np.isnan(cost.low)  # of one trial
    mixed = told('"U(0.6, 0.8)"', '[{error = 0.05}, "U(0.6, 0.8)", 0.7]')
    assert [c.error for c in mixed] == [0.05, 0.05, None, None, None, None] * 2
    assert all(np.isnan(c.predicted) for c in mixed)
    with pytest.raises(InputError, match=r"0.8 is off from the accuracy black=0.9 white=0.7 by -0.1 for black and 0.1"):
        told("{black = 0.9, white = 0.7}", "0.8")
