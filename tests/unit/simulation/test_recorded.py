"""What a run records of a trial is what one works out from its replay, to the bit, in any study."""

import json
import math
from types import SimpleNamespace

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus import brains
from swarmcensus.brains.metrics import PLUGINS
from swarmcensus.engine.constants import SENSING
from swarmcensus.engine.failures import works
from swarmcensus.runs.tasks import metrics_of
from swarmcensus.simulation import blame, living, metrics, trials
from swarmcensus.simulation.inputs import inputs_of
from swarmcensus.simulation.living import Stepped
from swarmcensus.simulation.trials import record_readings
from swarmcensus.summaries.replaying import honest_in
from swarmcensus.support.quantities import half_width
from tests.support.drawn import LIARS, TRIALS, drawn
from tests.support.second import ADDS, ALL, STEER, TALKS, WALD
from tests.support.small import FAILS, SLOW, study_of
from tests.support.trials import record_ride, record_trial

pytestmark = [pytest.mark.usefixtures("untraced"), pytest.mark.filterwarnings("ignore::UserWarning")]

OWN = {"all.py": ALL, "adds.py": ADDS, "talks.py": TALKS, "steers.py": ALL + STEER, "wald.py": WALD}


def worked_out(study, setting, trace):
    """The variables of a trial's replay, by their definitions, with the honest robots first as results have them."""
    honest = honest_in(trace)
    curves = trace["estimate"].values[:, honest]
    rounds = np.arange(len(curves))
    truths = setting.fill_ratios(rounds)
    out = {}
    if setting.body is not None:
        name = "true_fill_ratio"
        on_floor = trace[name].values if name in trace else np.full(len(rounds), trace.attrs[name])
        out[name] = on_floor[-1]
        truths = on_floor if study.measure.truth == "floor" else truths
    index = metrics.convergence(curves, study.measure.delta)
    out["convergence_round"] = index
    out["convergence_error"] = metrics.error_at(curves, index, truths[-1])
    out["final_estimate"] = curves[-1]
    out["agreement_round"] = metrics.agreement(curves, study.measure.delta)
    points = [c for c in study.checkpoints if c < len(curves)]
    out["disagreement"] = half_width(curves[points])
    out["correct"] = [metrics.correct(curves[c], truths[c], study.measure.bins) for c in points]
    if study.measure.estimates:
        out["estimates"] = curves[points]
    if any(brain.decides for brain in setting.brains):
        out |= _decided(setting, trace["decided"].values[:, honest], truths[-1])
    if any(brain.ends for brain in setting.brains):
        done = trace["is_done"].values[:, honest] == 1.0
        first = np.where(done.any(axis=0), done.argmax(axis=0), -1)
        out["done_round"] = np.where(first >= 0, first, np.inf)
        out["done_estimate"] = np.where(first >= 0, curves[first, range(len(first))], np.nan)
    if any(brain.has_interval for brain in setting.brains):
        out |= _sure(trace["interval_low"].values[:, honest], trace["interval_high"].values[:, honest], truths, points)
    for metric in study.measure.metrics:
        out[metric.variable] = _watched(metric, study, setting, curves[1:], truths[1:])
    return out


def _decided(setting, decided, truth):
    """`decided` (round, robot) of the honest."""
    changed = np.diff(decided, axis=0) != 0.0
    ever = changed.any(axis=0)
    rounds = len(changed)
    agreed = (decided[1:] == decided[1:, :1]).all(axis=1) & (decided[1:, 0] >= 0.0)
    options = next(brain.options for brain in setting.brains if brain.decides)
    right = min(math.floor(truth * options + 1e-12), options - 1)
    neither = options == 2 and truth == 0.5
    option = decided[1 + agreed.argmax(), 0] if agreed.any() else -1.0
    return {
        "decision": decided[-1],
        "decision_round": np.where(ever, 1 + changed.argmax(axis=0), np.inf),
        "decision_change": np.where(ever, rounds - changed[::-1].argmax(axis=0), np.inf),
        "consensus": option,
        "consensus_round": 1 + agreed.argmax() if agreed.any() else np.inf,
        "right_option": np.nan if neither else right,
        "consensus_right": np.nan if neither else float(option == right),
    }


def _sure(low, high, truths, points):
    held, wide = np.full(len(points), np.nan), np.full(len(points), np.nan)
    for k, c in enumerate(points):
        has = ~np.isnan(low[c])
        if has.any():
            held[k] = np.mean((low[c] <= truths[c]) & (truths[c] <= high[c]), where=has)
            wide[k] = sum((high[c] - low[c])[has].tolist()) / has.sum()
    return {"coverage": held, "interval_width": wide}


def _watched(metric, study, setting, curves, truths):
    """What CPython makes of the same estimates."""
    functions, ends = metric.functions, []
    for truth in truths:
        inside = math.floor(truth * study.measure.bins + 1e-12)
        low, last = min(inside, study.measure.bins - 1), study.measure.bins - 1
        ends.append((low / study.measure.bins, np.inf if low == last else (low + 1) / study.measure.bins))
    given = {"delta": study.measure.delta, "rounds": float(setting.rounds), "robots": float(curves.shape[1])}
    low, high = ends[0]
    states = [metric.record(low=low, high=high, **given) for _ in range(1 if metric.of_swarm else curves.shape[1])]
    for my in states:
        functions.begin(my)
    for k, (row, truth) in enumerate(zip(curves.tolist(), truths.tolist(), strict=True), start=1):
        for my in states:
            my.low, my.high = ends[k - 1]
        for i, x in enumerate(row):
            functions.watch(states[0 if metric.of_swarm else i], k, x, truth)
        if metric.of_swarm:
            functions.after(states[0], k)
    found = [functions.result(my) for my in states]
    return found[0] if metric.of_swarm else np.array(found)


def alone(study, setting, trial, honest):
    """The convergence of local estimates: of the trial's single readings, as `infer` follows robots that never talk."""
    readings, given = record_readings(setting, study.seed, trial), inputs_of(setting, study.seed, trial)
    for step, row in enumerate(readings):
        for i in range(setting.robots):
            if not works(given.stops[0], SENSING, i, 1 + step // setting.observations_per_round):
                row[i] = np.nan
    b, w = (np.broadcast_to(one[0], setting.robots) for one in given.beliefs)
    group = given.group[0] if given.group.size else np.zeros(setting.robots, int)
    curves = np.empty((len(readings) + 1, setting.robots))
    for k, brain in enumerate(setting.brains):
        lived = sc.infer(readings, None, {"black": b, "white": w}, 1, brain)["estimate"].values
        curves[:, group == k] = lived[:, group == k]
    curves = curves[:, honest]
    index = metrics.convergence(curves, study.measure.delta)
    error = metrics.error_at(curves, index, setting.fill_ratio)
    return {"local_convergence_step": index, "local_convergence_error": error}


def differences(study):
    """In what its run and its replays differ, as sentences, and how many trials were compared."""
    settings = study.settings()
    failed, compared, out = {}, 0, []
    try:
        results = sc.run(study, jobs=1, progress=False)
        told = json.loads(results.attrs.get("failed", "[]"))
        failed = {(one["setting"], one["trial"]): one["why"] for one in told}
    except sc.InputError as error:
        results = None
        failed = {(0, 0): str(error)}
    for k, setting in enumerate(settings):
        for trial in range(TRIALS):
            where = f"{setting.brain.label}, {setting}, seed {study.seed}, trial {trial}: "
            if (k, trial) in failed:
                out += [where + one for one in _failing(study, setting, trial, failed[k, trial])]
            elif results is not None:
                out += [where + one for one in _compared(study, results, k, trial)]
                compared += 1
    return out, compared


def _failing(study, setting, trial, why):
    """A replay shows answers that a run refuses: no interval, no option, no finite number; what raises, it tells."""
    again = record_trial if setting.body is None else record_ride
    try:
        again(setting, study.seed, trial)
        if study.measure.local:  # a replay shows no local estimate
            trials.run_batch(setting, study.seed, trial, 1, metrics_of(study), np.zeros(1, np.uint8), local=True)
    except sc.InputError as error:
        return [] if why.startswith(str(error)) else [f"the run says {why!r}, the replay {str(error)!r}"]
    shown = any(answer in why for answer in ("interval gives (", "decide gives ", blame.NO_ESTIMATE))
    return [] if shown else [f"the run fails, with {why!r}, and the replay does not"]


def _compared(study, results, k, trial):
    setting = study.settings()[k]
    trace = sc.replay(results, k, trial)
    found = worked_out(study, setting, trace)
    honest = honest_in(trace)
    drawing = any(brain.uses.luck for brain in setting.brains)
    if study.measure.local and not drawing:
        found |= alone(study, setting, trial, honest)
    recorded = results.isel(setting=k, trial=trial)
    for name, value in found.items():
        due = recorded[name].values
        if "checkpoint" in recorded[name].dims:
            due = due[: len(value)]
        if "robot" in recorded[name].dims:
            due = due[..., : honest.sum()]
        if not np.array_equal(due, value, equal_nan=True):
            yield f"{name} is recorded as {due}, replayed as {value}"
    if honest.all():
        stretch, row = Stepped(setting, study.seed, trial).find(setting.rounds)
        for name, value in zip(("messages_sent", "messages_heard"), stretch.messages[row], strict=True):
            if recorded[name].values.sum() != value:
                yield f"{name} is recorded as {recorded[name].values.sum()}, watched as {value}"


@pytest.fixture
def here(here):
    for name, source in (OWN | {"fails.py": FAILS}).items():
        (here / name).write_text(source)


def all_differences(seed, names, monkeypatch, liars=LIARS, **drawing):
    """Those of a random study for each of these names, and how many trials were compared and how many studies short."""
    rng = np.random.default_rng(seed)
    found, compared, short = [], 0, 0
    for name in names:
        study = drawn(rng, name, liars, **drawing)
        some = int(rng.integers(1, 20))  # estimates are kept for so many rounds at a time, or for all of them
        monkeypatch.setattr(trials, "ROWS_BYTES", int(rng.choice([1, 8_000_000])))
        monkeypatch.setattr(trials, "ROWS_OF_A_CROWD", some)
        monkeypatch.setattr(living, "MOST_ROUNDS", 20 + some)  # stretches are as long
        more, here = differences(study)
        found, compared = found + more, compared + here
        short += study.settings()[0].rounds == 1
    return found, compared, short


def hold(seed, names, monkeypatch, **drawing):
    found, compared, short = all_differences(seed, names, monkeypatch, **drawing)
    assert not found, "\n".join(found)
    assert compared >= 1.8 * len(names)
    assert short >= len(names) / 5


def test_a_run_records_what_its_replays_show(here, monkeypatch):
    """On networks and of robots that move, with intervals, ends and lies; of brains that compile quickly."""
    one = SimpleNamespace(shipped=["swarm-right"] * len(PLUGINS.shipped))  # compiled once; the next test has all
    monkeypatch.setattr("tests.support.drawn.METRICS", one)
    names = [*["minimalistic"] * 7, *["wald.py"] * 3, *["leaver"] * 2]
    found, compared, short = all_differences(1, names, monkeypatch, ("noisy-mirror",))
    assert not found, "\n".join(found)
    assert compared >= 2 * len(names)
    assert short >= 3


@pytest.mark.parametrize(("world", "truth"), [
    ({"rounds": 100}, "nominal"), ({"ticks": 100}, "nominal"), ({"ticks": 100, "body": {"tile": 0.2}}, "floor"),
], ids=["ring", "moving", "floor"])  # fmt: skip
def test_all_is_measured_of_the_honest_against_the_truth_of_the_round(world, truth, here):
    """Errors, shares of right robots, intervals and metrics of files, while the floor changes."""
    measure = {"checkpoints": [10, 30, 31, 50, 71, 100], "truth": truth, "metrics": [*PLUGINS.shipped]}
    liars = [{"robots": 3, "accuracy": 0.6, "honest": False}]
    study = study_of("wald.py", 8, 0.9, trials=TRIALS, fill_ratio=SLOW, measure=measure, members=liars, **world)
    found, compared = differences(study)
    assert not found, "\n".join(found)
    assert compared == TRIALS


def test_replays_of_trials_that_fail_say_what_the_run_says(here):
    fills = [0.55, 0.65, 0.7]
    study = study_of("fails.py", robots=3, accuracy=0.6, rounds=6, looks=100, trials=TRIALS, fill_ratio=fills)
    found, compared = differences(study)
    assert not found, "\n".join(found)
    assert 0 < compared < 3 * TRIALS


@pytest.mark.long
@pytest.mark.interpreted
@pytest.mark.parametrize("seed", [2, 3, 4, 5])
def test_a_run_of_any_brain_records_what_its_replays_show(seed, here, monkeypatch):
    """In CPython, where no brain is compiled for each kind of swarm; so no trial is longer than 120 rounds."""
    hold(seed, [*brains.shipped(), *OWN], monkeypatch, longest=120)


@pytest.mark.long
def test_a_compiled_run_records_what_its_replays_show(here, monkeypatch):
    """Of brains that have all that a brain can have, and of long trials."""
    hold(5, ["minimalistic", "commons", "voter", "oracle", *OWN] * 3, monkeypatch)
