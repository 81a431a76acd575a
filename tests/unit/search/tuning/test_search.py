"""What tuning finds is what is known to be best, its log is whole, and its evaluation is what the search never saw."""

import csv
import json
import math
import re
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus.brains import parse
from swarmcensus.cli.commands import main
from swarmcensus.search import candidates_in
from swarmcensus.search.tuning import training
from swarmcensus.search.tuning.optimiser import Search
from swarmcensus.search.tuning.plans import COMPANIONS
from swarmcensus.search.tuning.ranges import ranges_of, start_of, with_values
from swarmcensus.search.tuning.training import loss
from swarmcensus.simulation import trials as simulated
from swarmcensus.summaries.measures import Measure
from swarmcensus.support.errors import InputError
from swarmcensus.support.quantities import BEST, SEARCHED
from swarmcensus.support.seeds import seed_for
from swarmcensus.support.toml_text import to_toml
from tests.support import small
from tests.support.tunable import SOURCE, study_of


@pytest.fixture
def brain(tmp_path):
    return parse(SOURCE, "tunable.py", tmp_path / "tunable.py")


def test_ranges_are_read_and_every_place_has_a_value(brain):
    texts = ["a=0:2", "weight=0.01:100:log", "many=1:4:whole", "pair[1]=-1:1"]
    found = ranges_of(texts, brain)
    linear, log, whole = found[:3]
    assert list(map(str, found)) == texts
    assert [linear.value(s) for s in (0, 0.25, 1)] == [0, 0.5, 2]
    assert [log.value(s) for s in (0, 0.5, 1)] == pytest.approx([0.01, 1, 100])
    assert [whole.value(s) for s in (0, 0.24, 0.26, 0.99, 1)] == [1, 1, 2, 4, 4]
    for one in found:
        for share in np.linspace(0, 1, 23):
            value = one.value(share)
            assert one.low <= value <= one.high
            assert one.value(one.share(value)) == pytest.approx(value, rel=1e-4, abs=1e-4)
    assert start_of(found, brain) == (0.6, 0.0, 3.0, 0.5)
    other = with_values(brain, found, (1.0, 2.0, 4.0, -0.5))
    assert other.parameters == brain.parameters | {"a": 1.0, "weight": 2.0, "many": 4.0, "pair": (0.25, -0.5)}
    assert linear.share(7) == 1  # what lies outside begins at the nearest end


def test_a_trial_counts_by_its_ratio_to_what_is_usual():
    low = Measure("error", "error", "1", "")
    numbers = np.array([[0.01, 0.03, 0.02, np.inf], [100.0, 300.0, 0.0, np.nan]])
    scales = np.array([[0.02, 0.0], [200.0, 0.0]])
    bad = [1 / 3, 0.6, 0.5, 1.0, 1 / 3, 0.6, 0.0, 1.0]
    assert loss(numbers, low, scales) == pytest.approx(np.mean(bad))
    high = replace(low, low=False)
    assert loss(numbers[:1, :3], high, scales[:1]) == pytest.approx(1 - np.mean(bad[:3]))
    assert loss(numbers[:1] * 1000, low, scales[:1] * 1000) == pytest.approx(loss(numbers[:1], low, scales[:1]))
    share = Measure("right", "right", "1", "", low=False, statistic="mean", share=True)
    assert loss(np.array([[1.0, 0.25, np.nan]]), share, scales[:1]) == pytest.approx((0 + 0.75 + 1) / 3)
    signed = loss(np.array([[-1.0, 1.0, -1e9, np.inf]]), low, np.array([[0.0, 2.0]]))
    assert signed == pytest.approx((1 / (1 + math.exp(0.5)) + 1 / (1 + math.exp(-0.5)) + 0 + 1) / 4)


def test_search_is_repeatable_and_leaves_global_random_state(brain):
    ranges = ranges_of(["a=0:1", "many=0:9:whole"], brain)
    np.random.seed(4)  # noqa: NPY002
    before = np.random.get_state()[1].copy()  # noqa: NPY002
    asked = []
    for _ in range(2):
        search = Search(ranges, (0.5, 3.0), 11)
        mine = []
        for _ in range(5):
            mine.append(search.ask())
            search.tell([(abs(a - 0.2) + many,) for a, many in mine[-1]])
        asked.append((mine, search.favourite))
    assert asked[0] == asked[1]
    assert (np.random.get_state()[1] == before).all()  # noqa: NPY002
    assert Search(ranges, (0.5, 3.0), 12).ask() != asked[0][0][0]


def searched(brain, loss, generations, start=(0.9, 0.9), seed=3):
    """A search over two ranges from 0 to 1 after so many generations, and all that it has asked for."""
    search = Search(ranges_of(["a=0:1", "weight=0:1"], brain), start, seed)
    asked = []
    for _ in range(generations):
        asked.append(search.ask())
        search.tell([loss(*one) for one in asked[-1]])
        if search.ended:
            break
    return search, asked


def test_search_of_a_flat_metric(brain):
    """All is as bad but a square of 4 % of the ranges, far from the start."""
    found = 0
    for seed in range(20):
        search, asked = searched(brain, lambda a, w: (float(max(a, w) > 0.2),), 16, seed=seed)
        assert not search.ended
        found += max(search.favourite) <= 0.2
        assert (np.sort(np.floor(np.array(asked[1]) * 12), axis=0) == np.arange(12)[:, np.newaxis]).all()
    assert found >= 18


def test_search_ends_at_a_single_candidate(brain):
    search, asked = searched(brain, lambda a, w: (abs(a - 0.25) + abs(w - 0.75),), 60)
    assert search.ended
    assert set(asked[-1]) == {(0.25, 0.75)}


def test_a_companion_breaks_ties_and_nothing_else(brain):
    """The metric is a step towards low values of a; its companion prefers high ones, and low ones of the weight."""
    search, _ = searched(brain, lambda a, w: (float(a > 0.3), 1 - a + w), 40, start=(0.5, 0.5))
    assert search.favourite[0] <= 0.3
    assert search.favourite[1] < 0.05
    flat, _ = searched(brain, lambda a, w: (1.0, abs(a - 0.5) + abs(w - 0.5)), 40)
    assert flat.favourite == pytest.approx((0.5, 0.5), abs=0.05)
    assert not flat.differed


def test_the_search_runs_on_other_seeds_than_the_evaluation(tmp_path, monkeypatch):
    """Every trial that is simulated tells its seed: those of the search are the log's, the others the study's."""
    used = {"search": set(), "evaluation": set()}
    run_batch, through = simulated.run_batch, training.Training.run
    now = ["evaluation"]

    def spy(setting, seed, *others):
        used[now[-1]].add(seed)
        return run_batch(setting, seed, *others)

    def searching(self, *others):
        now.append("search")
        try:
            return through(self, *others)
        finally:
            now.pop()

    study = study_of(tmp_path, "a = 0.1, noise = 0.1", seed=5)
    sc.tune(study, ["a=0:1"], budget=13, trials=2, jobs=1)  # compiled, with a seed of its own
    monkeypatch.setattr("swarmcensus.runs.tasks.run_batch", spy)
    monkeypatch.setattr("swarmcensus.runs.pools.compile_for", lambda *_: None)
    monkeypatch.setattr(training.Training, "run", searching)
    sc.tune(study, ["a=0:1"], budget=37, trials=2, jobs=1)
    used["evaluation"].discard(0)  # of what is only compiled
    assert used["search"] == {seed_for(5, "training", generation) for generation in range(4)}
    assert used["evaluation"] == {5}


@pytest.mark.long
def test_a_quadratic_penalty_is_found(tmp_path):
    """The error is (a - 0.6)^2 and the like, and nothing else: found to 0.01, and a whole number exactly."""
    study = study_of(tmp_path, "a = 0.1, pair = [0.9, 0.1], many = 7")
    asked = ["a=0:1", "pair[0]=0:1", "pair[1]=0:1", "many=0:10:whole"]
    found = sc.tune(study, asked, budget=800, trials=1)
    assert found.values == pytest.approx({"a": 0.6, "pair[0]": 0.25, "pair[1]": 0.5, "many": 3}, abs=0.01)
    assert (found.values["many"], found.verdict) == (3, "better")
    assert found.brain.parameters["pair"] == (found.values["pair[0]"], found.values["pair[1]"])


def test_a_parameter_that_does_nothing_is_left_as_it_is(tmp_path):
    found = sc.tune(study_of(tmp_path, "noise = 0.1"), ["idle=0:10"], budget=60, trials=3, out=tmp_path / "t.toml")
    assert found.values == {"idle": 1.0}
    assert len(found.evaluations) == 1 + 4 * 12  # whole generations, as many as the budget allows
    assert found.sentences[0].startswith("no candidate differed from another in final_error: ")
    assert found.course == "49 evaluations in 4 generations, as many as the budget allows"
    assert found.verdict == found.fields["verdict"] == "not compared"
    assert not (tmp_path / "t.nc").exists()
    assert tomllib.loads(found.text)["swarm"]["brain"][0]["idle"] == 1.0


NOWHERE = "a = 9.0"  # the estimate is in the right bin where a is between 0.284 and 0.916 only


@pytest.mark.long(but=["True"])
@pytest.mark.parametrize("companion", [True, False])
def test_search_finds_a_distant_optimum(companion, tmp_path, monkeypatch):
    if not companion:
        monkeypatch.delitem(COMPANIONS, "correct")
    found = sc.tune(study_of(tmp_path, NOWHERE), ["a=0:10"], metric="correct", budget=97, trials=1)
    assert len(found.evaluations) == 97
    assert {one.loss for one in found.evaluations[:13]} == {1.0}  # as it was, and all of the first generation
    assert abs(found.values["a"] - 0.6) < 0.316
    assert (found.verdict, len(found.evaluations[0].losses)) == ("better", 1 + companion)


def test_swarm_is_tuned_to_agree(tmp_path):
    """Robots differ by `noise`. With much of it they never agree, and how far apart they are leads the search."""
    found = sc.tune(study_of(tmp_path, "noise = 0.9"), ["noise=0:1"], metric="agreement_round", budget=49, trials=2)
    assert found.values["noise"] < 0.03


def test_swarm_that_never_learns_is_not_the_soonest(tmp_path):
    """With a weight near 0 estimates hardly move, so that K = 0; this counts as never."""
    study = study_of(tmp_path, "weight = 1.0", fill=0.9, rounds=30)
    found = sc.tune(study, ["weight=0:1"], metric="convergence_round", budget=37, trials=2)
    assert found.values["weight"] > 0.01


def test_failed_trials_are_borne_and_avoided(tmp_path):
    """Above 90 `many` divides by zero: such candidates lose, and the search goes on."""
    found = sc.tune(study_of(tmp_path, "many = 60.0"), ["many=40:200"], budget=25, trials=2)
    failed = [one for one in found.evaluations if one.failed]
    assert failed
    assert all(one.values[0] > 90 and one.loss == 1.0 and one.failed == 2 for one in failed)
    assert found.values["many"] < 60
    with pytest.raises(InputError, match="ZeroDivisionError: division by zero"):
        sc.tune(study_of(tmp_path, "many = 99.0"), ["many=40:200"], budget=25, trials=2)


def test_others_of_the_study_are_evaluated_and_not_searched(tmp_path):
    study = study_of(tmp_path, "a = [0.1, 0.3], noise = 0.01", others=', "minimalistic"', accuracy=0.8, looks=3)
    found = sc.tune(study, ["a=0:1"], budget=37, trials=3, out=tmp_path / "t.toml")
    assert len(found.evidence.comparison.contenders) == 2
    data = sc.load(tmp_path / "t.nc")
    assert (data.sizes["setting"], data.attrs["seed"]) == (4, 1)
    assert sorted(set(data["brain"].values)) == ["minimalistic", "tunable.py"]
    assert "with the study's other brains" in " ".join(found.sentences)
    kept = [0.1, 0.3, found.values["a"]]
    assert sorted(data["a"].values[data["brain"].values == "tunable.py"]) == sorted(kept)
    text = re.sub(r"brain += .*", re.search(r"^brain = .*", found.text, re.M)[0], study.text)
    assert sc.Study.parse(text, context=study.context).swarm.brain == [found.brain]


def test_several_worlds_have_equal_weight_and_are_listed(tmp_path):
    study = study_of(tmp_path, "a = 0.1, noise = 0.02", accuracy="[0.8, 0.9]", seed=3)
    found = sc.tune(study, ["a=0:1"], budget=37, trials=3)
    assert "over all 2 worlds: better in 100%, worse in 0% of trials, p < 0.001" in found.sentences[0]
    assert ([row["accuracy"] for row in found.rows], found.verdict) == (["0.8", "0.9"], "better")
    back = sc.tune(study_of(tmp_path, "a = 0.6, noise = 0.02", accuracy="[0.8, 0.9]"), ["a=0:0.3"], budget=37, trials=3)
    assert back.verdict == "worse"
    assert "There is no evidence that its values are worth anything" in back.text


@pytest.fixture
def args(tmp_path):
    return study_of(tmp_path, "a = 0.1, noise = 0.1"), ["a=0:1", "idle=1:9:log"]


def test_a_log_that_is_none_or_damaged_is_refused(args, tmp_path):
    log = tmp_path / "a.csv"
    sc.tune(*args, budget=13, trials=2, out=tmp_path / "a.toml")
    lines = log.read_text().splitlines(keepends=True)
    changed = lines[7].replace(lines[7].split(",")[2], "0.123")
    damaged = r"a\.csv: has no evaluation, or is damaged"
    for those, said in (
        ([*lines[:7], "nonsense\n", *lines[8:]], damaged), ([lines[0], "a,b\n", *lines[2:]], damaged),
        (lines[:2], damaged), (["x,y\n1,2\n"], r"a\.csv: is no log of a search"),
        ([*lines[:7], changed, *lines[8:]], r"evaluation 5 has the values \(0.123, .* there and "),
    ):  # fmt: skip
        log.write_text("".join(those))
        with pytest.raises(InputError, match=said):
            sc.tune(*args, budget=25, trials=2, out=tmp_path / "a.toml")
        assert log.read_text() == "".join(those)


def test_results_of_another_kind_are_never_replaced(args, tmp_path):
    sc.save(sc.run(args[0]), tmp_path / "a.nc")
    before = (tmp_path / "a.nc").read_bytes()
    with pytest.raises(InputError, match=r"a.nc holds results that no evaluation of a search made"):
        sc.tune(*args, budget=37, trials=2, out=tmp_path / "a.toml", fresh=True)
    assert (tmp_path / "a.nc").read_bytes() == before


def test_robots_that_move_share_their_walks(tmp_path):
    """All candidates of a generation ride on the same walk, and come to what each would alone."""
    (tmp_path / "tunable.py").write_text(SOURCE)
    brain = [{"file": "tunable.py", "a": 0.1}]
    world = {"topology": "moving", "density": 1, "fill_ratio": 0.5}
    swarm = {"brain": brain, "robots": 4, "accuracy": 1.0}
    text = to_toml({"trials": 3, "swarm": swarm, "world": world, "schedule": {"ticks": 20}})
    found = sc.tune(sc.Study.parse(text, context={"base": tmp_path}), ["a=0:1"], budget=13, trials=2, jobs=2)
    errors = [(one.values[0] - 0.6) ** 2 for one in found.evaluations]
    assert [one.loss for one in found.evaluations] == pytest.approx([e / (e + errors[0]) for e in errors])


def test_values_that_change_nothing_are_no_finding(tmp_path):
    found = sc.tune(study_of(tmp_path, "a = 0.1"), ["a=0:1", "idle=0:10", "shift=0:1"], budget=121, trials=2)
    assert found.values["a"] == pytest.approx(0.6, abs=0.05)
    assert (found.values["idle"], found.values["shift"]) == (1.0, 0.0)
    assert found.notes[0] == "idle changes nothing in final_error, and stays at 1"
    assert all(one in found.text and one in str(found) for one in found.notes)


@pytest.mark.long
@pytest.mark.parametrize("flat", [False, True])
def test_search_goes_on_from_any_part_of_its_log(flat, args, tmp_path):
    """Also from a part of a generation, a smaller budget, and where nothing differed, so that others are drawn."""
    given = [study_of(tmp_path, NOWHERE), ["a=5:10"], None, "correct"] if flat else args
    whole = sc.tune(*given, budget=61, trials=2, out=tmp_path / "whole.toml")
    lines = (tmp_path / "whole.csv").read_bytes().splitlines(keepends=True)
    for cut in (3, 15, 40, -1):
        (tmp_path / "cut.csv").write_bytes(b"".join(lines[:cut]))
        again = sc.tune(*given, budget=61, trials=2, out=tmp_path / "cut.toml")
        assert again.values == whole.values
        assert (tmp_path / "cut.csv").read_text() == (tmp_path / "whole.csv").read_text()
    for budget in (37, 61):
        again = sc.tune(*given, budget=budget, trials=2, out=tmp_path / "more.toml")
    assert again.values == whole.values
    assert (tmp_path / "more.csv").read_text() == (tmp_path / "whole.csv").read_text()


def test_threads_change_nothing_and_python_keeps_no_files(args, tmp_path):
    one, three = (sc.tune(*args, budget=37, trials=4, jobs=jobs) for jobs in (1, 3))
    assert one.values == three.values
    assert [e.losses for e in one.evaluations] == [e.losses for e in three.evaluations]
    assert [path.name for path in tmp_path.iterdir()] == ["tunable.py"]


# ---- the log of a search is a results file of its own: what `show` and `plot` make of it, also while the search runs
@pytest.fixture(scope="module")
def log_of(tmp_path_factory):
    """A search with three generations, and the folder of its log, which is t.csv."""
    folder = tmp_path_factory.mktemp("searched")
    (folder / "tunable.py").write_text(SOURCE)
    study = study_of(folder, "a = 0.1, noise = 0.1")
    return sc.tune(study, ["a=0:1", "idle=1:9:log"], budget=37, trials=2, out=folder / "t.toml"), folder


@pytest.fixture
def log(log_of, here):
    Path("t.csv").write_bytes((log_of[1] / "t.csv").read_bytes())
    return Path("t.csv")


def test_the_dataset_has_every_candidate(log_of, log):
    found, data = log_of[0], candidates_in(log)
    assert (data.attrs[SEARCHED], data.sizes) == ("final_error", {"setting": 37, "trial": 1})
    for k, name in enumerate(("a", "idle")):
        assert data[name].values.tolist() == [one.values[k] for one in found.evaluations]
    assert data["loss"].values[:, 0].tolist() == [one.loss for one in found.evaluations]
    assert data["final_error"].values[:, 0].tolist() == [one.numbers[0] for one in found.evaluations]
    # all robots of this brain err by (a - 0.6)^2, but for noise of up to 0.05
    expected = (data["a"].values - 0.6) ** 2
    assert data["final_error"].values[:, 0] == pytest.approx(expected, abs=0.05)


def test_the_best_so_far_is_that_of_whole_generations(log):
    data = candidates_in(log)
    values, generation = data["final_error"].values[:, 0], data["generation"].values
    best = [values[generation <= g].min() for g in generation]
    assert data[f"{BEST}final_error"].values[:, 0].tolist() == best
    assert (np.diff(best) <= 0).all()


def test_high_numbers_are_best_of_what_is_to_be_high(log_of, tmp_path):
    study = study_of(log_of[1], "a = 0.1, noise = 0.1")
    sc.tune(study, ["a=0:1"], None, "correct", budget=25, trials=2, out=tmp_path / "c.toml")
    data = candidates_in(tmp_path / "c.csv")
    assert data[f"{BEST}correct"].values[-1, 0] == data["correct"].values.max()
    assert "final_error" in data  # which breaks ties


def test_show_prints_candidates(log, accepted):
    assert "the least loss so far, 0." in accepted("show", "t.csv", "--sort", "loss", "--save", "sorted.csv").out
    rows = [*csv.DictReader(Path("sorted.csv").read_text(encoding="utf-8").splitlines())]
    assert len(rows) == 37
    losses = [float(row["loss"]) for row in rows]
    assert losses == sorted(losses)
    assert [*rows[0]][:5] == ["evaluation", "generation", "a", "idle", "loss"]
    said = json.loads(accepted("show", "t.csv", "--json", "--where", "generation == 3").out)
    assert {row["generation"] for row in said["rows"]} == {3}
    assert "37 evaluations in 3 generations" not in said["title"]  # of these
    assert said["sentences"][0].startswith("the least loss so far, 0.")


def test_lines_and_dots_are_those_of_the_log(log):
    data = candidates_in(log)
    lines, dots = sc.plot.lines(data, width=3.5).axes[0], sc.plot.scatter(data, x="a", width=3.5).axes[0]
    (line,) = [one for one in lines.lines if str(one.get_label()).startswith("line ")]
    best = data[f"{BEST}final_error"].values[:, 0]
    assert line.get_xdata().tolist() == [0, 1, 2, 3]
    assert line.get_ydata().tolist() == best[[0, 12, 24, 36]].tolist()
    assert lines.get_ylabel() == "best final error"
    assert dots.get_xscale() == "linear"  # as it was log_of
    assert sc.plot.scatter(data, x="idle").axes[0].get_xscale() == "log"
    points = zip(data["a"].values.tolist(), data["final_error"].values[:, 0].tolist(), strict=True)
    assert sorted(map(tuple, dots_in(dots).tolist())) == sorted(points)


def dots_in(axes):
    return np.concatenate([d.get_xydata() for d in axes.lines if str(d.get_label()).startswith("dots ")])


def test_a_scatter_plot_of_trials_against_any_number():
    results = sc.run(small.study_of(robots=[5, 9], accuracy=0.8, rounds=10, fill_ratio=0.3))
    (axes,) = sc.plot.scatter(results, x="robots", y="final_error").axes
    table = sc.frame(results).groupby(["robots", "trial"])["final_estimate"]
    expected = table.apply(lambda x: (x - 0.3).abs().median()).reset_index()
    assert dots_in(axes) == pytest.approx(expected[["robots", "final_estimate"]].to_numpy())
    with pytest.raises(InputError, match="no numbers"):
        sc.plot.scatter(results, x="topology")
    with pytest.raises(InputError, match="goes with x"):
        sc.plot.scatter(results, y="final_error")


def test_the_command_draws_it_also_while_the_search_is_at_work(log, accepted):
    log.write_bytes(b"".join(log.read_bytes().splitlines(keepends=True)[:19]))
    assert main(["plot", "t.csv", "--kind", "lines"]) == 0
    assert main(["plot", "t.csv", "--kind", "scatter", "--x", "idle", "--out", "dots.png"]) == 0
    assert {"t-lines.png", "dots.png"} <= {path.name for path in Path().iterdir()}
    assert len(json.loads(accepted("show", "t.csv", "--json").out)["rows"]) == 17


@pytest.mark.parametrize(("command", "said"), [
    ("plot t.csv --kind curves", "lines and scatter draw candidates"),
    ("compare t.csv", "t.csv is the log of a search"),
    ("show t.csv --sort lost", "did you mean 'loss'"),
    ("plot t.csv --x b", "--x b: the coordinates that vary here are a, "),
    ("show head.csv", "head.csv: has no evaluation"),
])  # fmt: skip
def test_what_a_log_has_not_is_refused(command, said, log, refused):
    Path("head.csv").write_bytes(b"".join(log.read_bytes().splitlines(keepends=True)[:1]))
    assert said in refused(*command.split())
