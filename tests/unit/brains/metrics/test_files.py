"""Metrics of files: what they find, against NumPy on the same curves and against CPython; what is refused."""

import contextlib
import json
import math
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import swarmcensus as sc
from swarmcensus.brains import metrics
from swarmcensus.runs.clusters import payload_of, read_payload
from swarmcensus.simulation import file_metrics
from swarmcensus.support.bins import right_bin
from tests.support.small import study_of

LIBRARY = metrics.PLUGINS.shipped
STUDY = """
seed = 3
trials = 6
swarm = {{robots = [1, 20], accuracy = [0.6, 0.9]}}
world = {{topology = ["ring", "full"], fill_ratio = [0.55, 0.95]}}
schedule = {{rounds = 83}}
measure = {{metrics = {metrics}}}
"""
MINE = '''"""The last estimate."""

UNIT = "1"
MEANING = "the last estimate"


def begin(my):
    my.last = 0.0


def watch(my, k, estimate, truth):
    my.last = estimate


def result(my):
    return my.last
'''


def study(text=STUDY, names=LIBRARY):
    return sc.Study.parse(text.format(metrics=json.dumps(list(names))))


def by_hand(curves, truth, bins=10):
    low, high = right_bin(truth, bins)
    right, near = (curves >= low) & (curves < high), np.abs(curves - truth) < 0.05
    rounds = len(curves)
    good = [next((k + 1 for k in range(rounds) if column[k:].all()), math.inf) for column in right.T]
    nearly = np.flatnonzero(right.sum(axis=1) >= 0.95 * curves.shape[1])
    return {
        "first_right": np.array(good),
        "time_right": right.mean(axis=0),
        "mean_error": np.abs(curves - truth).mean(axis=0),
        "rms_error": np.sqrt(((curves - truth) ** 2).mean(axis=0)),
        "largest_jump": np.abs(np.diff(curves, axis=0)).max(axis=0, initial=0.0),
        "swarm_right": nearly[0] + 1.0 if nearly.size else math.inf,
        "recovery_time": np.array([next((k for k in range(rounds) if c[k:].all()), math.inf) for c in near.T]),
    }


@pytest.fixture(scope="module")
def fixed():
    return sc.run(study())


def test_shipped_metrics_against_numpy(fixed):
    seen = set()
    for k, robots in enumerate(fixed["robots"].values.tolist()):
        trace = sc.replay(fixed, k, 1)
        floor = trace.attrs.get("true_fill_ratio", trace.attrs["fill_ratio"])
        for variable, expected in by_hand(trace["estimate"].values[1:], floor).items():
            measured = fixed[variable].values[k, 1]
            if measured.ndim:
                assert np.isnan(measured[robots:]).all()
                measured = measured[:robots]
            np.testing.assert_allclose(measured, expected, rtol=1e-12, err_msg=variable)
            seen |= {(variable, bool(np.isinf(expected).any()))}
    assert {(name, never) for name in ("first_right", "swarm_right") for never in (True, False)} <= seen
    assert {variable for variable, _ in seen} == {metrics.load(name).variable for name in LIBRARY}


def test_metrics_alter_no_bit_of_what_else_is_measured(fixed):
    plain = sc.run(study(names=[]))
    assert "metrics" not in plain.attrs
    for name in plain.data_vars:
        xr.testing.assert_identical(plain[name], fixed[name])


def test_summaries_and_tables_have_metrics(fixed):
    table = sc.summary(fixed)
    for k, robots in enumerate(fixed["robots"].values):
        assert table["first_right"][k] == np.median(fixed["first_right"].values[k, :, :robots])
        assert table["swarm_right"][k] == np.median(fixed["swarm_right"].values[k])
        assert 1.0 <= table["swarm_right_low"][k] <= table["swarm_right"][k] <= table["swarm_right_high"][k]
        assert 0.0 <= table["time_right_low"][k] <= table["time_right"][k] <= table["time_right_high"][k] <= 1.0
    assert np.isinf(table["swarm_right"]).any()  # of what mostly never comes
    frame = sc.frame(fixed)
    one = frame[(frame["setting"] == 2) & (frame["trial"] == 4) & (frame["robot"] == 0)].iloc[0]
    assert one["time_right"] == fixed["time_right"].values[2, 4, 0]
    assert one["swarm_right"] == fixed["swarm_right"].values[2, 4]


def test_what_was_changed_in_a_file_is_found(fixed):
    false = fixed.copy(deep=True)
    false["swarm_right"].values[0, 0] += 1.0
    assert "swarm_right" in str(sc.verify(false, 1.0).differences[0])
    for change in (
        lambda d: d["swarm_right"].values.__setitem__((0, 0), np.nan),
        lambda d: d.attrs.__setitem__("metrics", d.attrs["metrics"].replace("SHARE = 0.95", "SHARE = 0.5")),
        lambda d: d.attrs.__setitem__("metrics", "[1]"),
        lambda d: d.attrs.__setitem__("metrics", json.dumps({"x": json.loads(d.attrs["metrics"])["swarm_right"]})),
    ):
        false = fixed.copy(deep=True)
        change(false)
        with contextlib.suppress(sc.InputError):
            assert sc.verify(false, 1.0).code == 1


@pytest.mark.long
def test_a_metric_file_that_results_name_is_not_run_unasked(here):
    Path("mine.py").write_text(MINE)
    sc.save(sc.run(small(["mine.py"])), "a.nc")
    assert sc.verify("a.nc", 1.0).differences == []
    Path("mine.py").write_text(MINE.replace("= estimate", "= 1.0"))
    with pytest.raises(sc.InputError, match=r"metric 'mine\.py' has changed since the results were made"):
        sc.verify("a.nc", 1.0)
    Path("mine.py").unlink()
    assert sc.summary("a.nc")["mine"].notna().all()  # to look at them needs no file
    assert sc.replay("a.nc", 0, 0)["estimate"].values[-1, 0] == sc.load("a.nc")["mine"].values[0, 0, 0]


def small(names, rounds=20):
    return study_of(robots=3, accuracy=0.8, rounds=rounds, trials=2, measure={"metrics": names})


def test_a_cluster_gets_metrics_as_text(tmp_path):
    (tmp_path / "mine.py").write_text(MINE)
    sent = sc.Study.parse(STUDY.format(metrics='["mine.py", "swarm-right"]'), context={"base": tmp_path})
    assert sent.measure.metrics[0].functions.UNIT == "1"  # it has been run here
    there, _ = read_payload(payload_of(sent))
    assert there.measure.metrics == sent.measure.metrics


BAD = [
    ("def result", "def results", "the function result is missing"),
    ("watch(my, k, ", "watch(my, ", "watch: the number of its arguments should be 4, not 3"),
    ('UNIT = "1"', "UNIT = 1", 'UNIT is missing: a text such as "rounds"'),
    ("MEANING", "SAYS", "MEANING is missing"),
    ("return my.last", "return my.lost", "line 16: result uses lost, which begin does not set"),
    ("my.last = 0.0", "my.rounds = 0.0", "line 8: begin sets rounds, which is read-only"),
    ("return my.last", "return", "line 15: result returns no number"),
    ("= estimate", "= estimat", "watch uses estimat, which is not defined: did you mean 'est"),
    ("my.last = estimate", "slope = 1.0\n\n\ndef more(my):\n    return slope", "more uses slope, which is not defined"),
    ("def begin", "BETTER = 'less'\n\n\ndef begin", "BETTER = 'less': should be \"low\" or"),
    ("def begin", f"LABEL = '{'x' * 25}'\n\n\ndef begin", "LABEL should be a text of up to 24"),
    ("def begin", "BOUNDS = (1, 0)\n\n\ndef begin", "BOUNDS should be two numbers"),
    ("UNIT =", "import os\nUNIT =", "line 3: imports os: a metric may import only math"),
    ("= estimate", "= open('x')", "line 12: watch calls open: a metric may call its own"),
    ("= estimate", "= eval", "line 12: watch uses eval: a metric may call its own"),
    ("my.last = 0.0", "begin(my)", "line 8: begin calls itself: functions of a metric"),
    ("def begin(my):", "def begin(my)", "line 7: not Python"),
    ("= estimate", "= [estimate]", "line 12: List in watch: a metric may not allocate"),
]


@pytest.mark.parametrize(("old", "new", "said"), BAD)
def test_faults_of_a_file_are_named(old, new, said, tmp_path):
    (tmp_path / "mine.py").write_text(MINE.replace(old, new))
    with pytest.raises(sc.InputError, match=r"^metric file .*mine\.py") as caught:
        metrics.load("mine.py", tmp_path)
    assert said in str(caught.value)


@pytest.mark.parametrize(("names", "said"), [
    (["frist-right"], 'measure.metrics[0] = "frist-right"'),
    ([1], "a metric is a shipped metric's name or the path of a metric file"),
    (["first-right", "first_right.py"], "two of them would be called 'first_right' in the results"),
    (["correct.py"], "the name 'correct' is used in the results"),
    (["mine_low.py"], "the name 'mine_low' is used in the results"),
    (["mine"], "\"mine\": did you mean 'mine.py'?"),
    (["my.metric.py"], "'my.metric' cannot name a variable"),
])  # fmt: skip
def test_bad_names_are_refused(names, said, here):
    for name in ("first_right.py", "correct.py", "my.metric.py", "mine_low.py", "mine.py"):
        Path(name).write_text(MINE)
    with pytest.raises(sc.InputError) as caught:
        study(names=names)
    assert said in str(caught.value)


def failing(source, rounds=20):
    """What a run says of a metric of this source, which may use math."""
    Path("mine.py").write_text(source.replace('UNIT = "1"', 'UNIT = "1"\nimport math'))
    with pytest.raises(sc.InputError) as error:
        sc.run(small(["mine.py"], rounds))
    return str(error.value).replace("float division", "division")


AFTER = "def after(our, k):\n    our.last = 1.0 / (k - our.rounds)\n\n\ndef result"


@pytest.mark.parametrize(("old", "new", "said"), [
    ("= estimate", "= 1.0 / (k - my.rounds)", "division by zero, at mine.py, line 13: my.last = 1.0 / (k - my."),
    ("def result", AFTER, "division by zero, at mine.py, line 17: our.last = 1.0 / (k - our.rounds)"),
    ("return my.last", "return 1.0 / (my.robots - 3)", "ZeroDivisionError: division by zero, at mine.py, line"),
    ("return my.last", "return math.nan", "its result is no number (of what never comes, infinity is right)"),
    ("= estimate", "= 'much'", "it cannot be compiled: Cannot cast Literal[str](much) to float64"),
], ids=["division", "after", "result", "nan", "uncompilable"])  # fmt: skip
@pytest.mark.parametrize("checked", [1, 2000])  # estimates that CPython looks at beforehand
def test_a_metric_that_fails_is_named(old, new, said, checked, here, monkeypatch):
    monkeypatch.setattr(file_metrics, "MOST_CHECKED", checked)
    found = failing(MINE.replace(old, new))
    assert "metric 'mine.py' fails in trial 0 of ring, N = 3, accuracy 0.8, f = 0.55, C = 20, R = 10: " in found
    assert said in found


@pytest.mark.parametrize(("body", "said"), [
    ("my.last = math.exp(1000.0)", "OverflowError: math range error, at mine.py, line 13"),
    ("my.last = math.sqrt(-k)", "ValueError: math domain error, at mine.py, line 13"),
    ("my.last = float(9223372036854775807 + k)", "last is -9.223372036854"),
    ("n = 1\n    for i in range(k):\n        n *= 3\n    my.last = float(n)", "in machine code and"),
    ("if k > 2:\n        my.last = math.sqrt(estimate - 2.0)", "math domain error, at mine.py, line 14"),
])  # fmt: skip
def test_what_python_refuses_or_finds_otherwise_is_refused(body, said, here):
    assert said in failing(MINE.replace("my.last = estimate", body), rounds=60)


@pytest.mark.interpreted
def test_result_is_asked_for_at_the_end_only(here, monkeypatch):
    monkeypatch.setattr(file_metrics, "MOST_CHECKED", 9)
    late = MINE.replace("my.last = estimate", "my.last = 2.0 if k == my.rounds else 0.0")
    Path("late.py").write_text(late.replace("return my.last", "return 1.0 / my.last"))
    assert (sc.run(small(["late.py"]))["late"] == 0.5).all()


@pytest.mark.interpreted
def test_a_result_beyond_its_bounds_is_refused(here):
    Path("mine.py").write_text(MINE.replace("def begin", "BOUNDS = (0.0, 0.1)\n\n\ndef begin"))
    with pytest.raises(sc.InputError, match=r"its result 0\.\d+ is outside its BOUNDS, 0 to 0\.1"):
        sc.run(small(["mine.py"]))


def test_a_file_says_which_way_is_better_and_what_it_is_called(here):
    Path("mine.py").write_text(MINE.replace("def begin", 'BETTER = "high"\nLABEL = "last word"\n\n\ndef begin'))
    data = sc.run(study_of(["minimalistic", "alone"], rounds=20, trials=8, measure={"metrics": ["mine.py"]}))
    found = sc.compare(data)
    [measure] = [one for one in found.measures if one.name == "mine"]
    assert (measure.low, measure.label, measure.unit) == (False, "last word", "1")
    assert not any("mine" in one for one in found.cautions)
    assert sc.compare(data, "mine:low").measures[0].low
    assert "last word" in sc.plot.lines(data, y="mine").axes[0].get_ylabel()
