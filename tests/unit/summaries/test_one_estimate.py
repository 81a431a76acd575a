"""One estimate of a cell: every table, figure and document of results has the same value and the same interval."""

import json

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus.cli.commands import main
from swarmcensus.summaries import measures, summaries
from swarmcensus.summaries.selecting import where
from swarmcensus.summaries.table_of_summary import Summary
from tests.support.drawing import drawn
from tests.support.small import study_of

pytestmark = pytest.mark.interpreted
NAMES = ("final_error", "convergence_round", "convergence_error", "error_90", "right_consensus_round", "decision_round",
         "swarm_right", "correct")  # fmt: skip
LIARS = [{"robots": 1, "brain": "opposite", "honest": False}]


@pytest.fixture(scope="module")
def decided():
    """Two settings of robots that decide, some of them never, among liars; in the second one all are right."""
    measure = {"metrics": ["swarm-right"], "checkpoints": [20, 60]}
    study = study_of("bayes-bots", 6, [0.7, 1.0], 60, trials=7, members=LIARS, measure=measure, fill_ratio=0.65)
    data = sc.run(study)
    data["correct"][1] = 1.0
    return data


@pytest.fixture(params=[7, 4], ids=["with intervals", "too few trials"])
def results(request, decided):
    return decided.isel(trial=slice(request.param))


@pytest.fixture
def summary(results):
    """Value and ends of the interval of each quantity, (setting, 3)."""
    table = sc.summary(results)
    return {name: table[[name, f"{name}_low", f"{name}_high"]].to_numpy() for name in NAMES}


def test_json_has_the_summary(results, summary, here, accepted):
    sc.save(results, "x.nc")
    for k, setting in enumerate(json.loads(accepted("show", "x.nc", "--json").out)["rows"]):
        for name, ends in summary.items():
            found = [setting[f"{name}{end}"] for end in ("", "_low", "_high")]
            wanted = [None if np.isnan(end) else "infinity" if np.isinf(end) else end for end in ends[k]]
            assert found == wanted, name


def test_a_comparison_has_the_summary(results, summary):
    table = sc.compare(results, NAMES, factor="accuracy").table
    for name, ends in summary.items():
        np.testing.assert_array_equal(table[[name, f"{name}_low", f"{name}_high"]], ends)


@pytest.mark.parametrize("name", NAMES)
def test_lines_have_the_summary(name, results, summary):
    (ax,) = sc.plot.lines(results, y=name, x="accuracy", color="topology").axes
    value, low, high = summary[name].T
    np.testing.assert_array_equal(drawn(ax, "ring")[:, 1], np.where(np.isinf(value), np.nan, value))
    bars = ("interval ring", "one-sided ring")
    segments = [line.get_segments() for line in ax.collections if line.get_label() in bars]
    ends = {segment[0, 0]: segment[:, 1].tolist() for lines in segments for segment in lines if len(segment)}
    top = ax.get_ylim()[1]
    assert ends == {x: [low[k], min(high[k], top)] for k, x in enumerate((0.7, 1.0)) if np.isfinite(low[k])}


def test_other_figures_have_the_summary(results, summary):
    (ax,) = sc.plot.scatter(results).axes
    (shares,) = sc.plot.lines(results, x="checkpoint").axes
    error, rounds, *_ = sc.plot.heatmap(results, x="fill_ratio", y="accuracy").axes
    (tails,) = sc.plot.heatmap(results, x="fill_ratio", y="accuracy", z="error 90").axes
    (front,) = sc.plot.pareto(results, factor="accuracy", metric="final error").axes
    for k, accuracy in enumerate(("0.7", "1.0")):
        when, off = summary["convergence_round"][k], summary["convergence_error"][k]
        assert drawn(ax, f"median {accuracy}").tolist() == [[when[0], off[0]]]
        cross = drawn(ax, f"cross {accuracy}").tolist()
        wanted = [[when[0], off[1]], [when[0], off[2]], [when[1], off[0]], [when[2], off[0]]]
        assert cross == (sorted(wanted) if np.isfinite(when).all() else [])
        assert drawn(shares, f"right {accuracy}")[-1, 1] == 100 * summary["correct"][k, 0]
        for place, name in ((error, "convergence_error"), (tails, "error_90")):
            assert place.images[0].get_array()[k, 0] == summary[name][k, 0]
        assert not rounds.texts  # as robots settle far off
        assert summary["final_error"][k, 0] in np.concatenate([line.get_ydata() for line in front.lines])


def test_every_head_of_a_table_names_its_quantity(decided):
    """What `show` and `compare` print above a column is taken by every option, and so are the quantity's names."""
    decided = decided.assign(half_width=("setting", [0.1, 0.2]))
    known = measures.known(decided)
    shown = Summary(decided, decided).tables(0)[0]
    compared = sc.compare(decided, [*known], factor="accuracy").tables(0)[0]
    heads = {column.head for table in (shown, compared) for column in table.columns}
    heads -= {"world", "setting", "trials", "memory"}  # which brains have, not trials
    coordinates = heads & {str(name) for name in decided.coords}
    assert coordinates == {"accuracy"}
    for name in coordinates:
        assert where(decided, f"{name} == {name}").sizes == decided.sizes
        sc.plot.lines(decided, x=name)
    names = {head: measures.name_of(decided, head, [*known, "half_width"]) for head in heads - coordinates}
    assert set(names.values()) == {*known, "half_width"}
    for k, (head, name) in enumerate(names.items()):
        for text in (head, name, head.replace(" ", "_"), head.removesuffix(" %")):
            assert summaries.sort_settings(decided, text)[0].identical(summaries.sort_settings(decided, name)[0]), text
            if name in known:
                assert measures.choose_measures(decided, [text])[0] == [known[name]]
        if name in known and k % 3 == 0:
            by_head, by_name = (sc.plot.lines(decided, y=text).axes[0].get_ylabel() for text in (head, name))
            assert by_head == by_name
    assert {"K", "error at K", "agreement round", "final error", "error 90", "right %"} <= heads
    assert {"exit %", "right consensus"} <= heads


def test_an_unknown_quantity_is_answered_by_those_that_there_are(decided, here, refused):
    sc.save(decided, "x.nc")
    for command in ("show x.nc --sort", "compare x.nc --factor accuracy --metric", "plot x.nc --kind lines --y"):
        said = refused(*command.split(), "finl error")
        assert "did you mean 'final" in said, command
        assert "error_90" in said or "error 90" in said, command
    said = refused("compare", "x.nc", "--factor", "accuracy", "--metric", "consensus_round")
    assert "did you mean 'right_consensus_round'?" in said
    said = refused("show", "x.nc", "--where", "K < 5")
    assert "K is measured, and settings are selected by what a study sets: accuracy" in said


def test_captions_say_that_medians_hide_a_tail(results, here, caplog):
    caplog.set_level("INFO")
    sc.save(results, "r.nc")
    for kind, options, in_python, in_a_shell in (
        ("lines", {"x": "accuracy"}, "y='error_90'", "--y error_90"),
        ("heatmap", {"x": "fill_ratio", "y": "accuracy"}, "z='error_90'", "--option z=error_90"),
    ):
        figure = getattr(sc.plot, kind)(results, **options)
        assert "the worst tenth of the robots may err much more\n" in sc.plot.caption(figure)
        sc.plot.save(figure, "python.png")
        assert f"may err much more; drawn by {in_python}" in caplog.text
        words = [word for name, value in options.items() for word in (f"--{name}", value)]
        assert main(["plot", "r.nc", "--kind", kind, *words, "--out", "shell.png"]) == 0
        assert f"may err much more; drawn by {in_a_shell}" in caplog.text
    for y in ("correct", "error 90"):
        assert "may err much more" not in sc.plot.caption(sc.plot.lines(results, x="accuracy", y=y))


def test_show_has_a_column_of_the_tail_where_it_is_shown(results, monkeypatch):
    def heads(data):
        return [column.head for column in Summary(data, data).tables(0)[0].columns]

    assert "error 90" in heads(results)
    monkeypatch.setattr("swarmcensus.summaries.table_of_summary.shows_tail", lambda data: False)
    assert "error 90" not in heads(results)
