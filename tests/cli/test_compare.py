"""The command `compare`: what it prints, writes and draws, and what it says where it cannot."""

import csv
import re

import matplotlib as mpl
import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus.brains.library import TITLES
from swarmcensus.cli.commands import main
from swarmcensus.figures.kinds.pareto import front
from swarmcensus.summaries.labels import renamed_contender
from tests.support.contending import made_up

STUDY = """
name = "two"
seed = 3
trials = 10
swarm = {brain = ["minimalistic", "legacy"], robots = 10, accuracy = [0.6, 0.8]}
world = {topology = ["ring", "full"], fill_ratio = 0.55}
schedule = {rounds = 60}
"""


@pytest.fixture(scope="module")
def two(tmp_path_factory):
    path = tmp_path_factory.mktemp("compare") / "two.nc"
    sc.save(sc.run(sc.Study.parse(STUDY)), path)
    return path


def test_it_prints_a_title_worlds_and_what_comes_next(two, accepted, monkeypatch):
    out, error = accepted("compare", two)
    assert out.startswith(f"{two}: two (seed 3, swarmcensus ")
    assert "12 tests, corrected by Holm's method" in out
    assert re.search(r" minimalistic .* 60 +480 +48$", out, re.MULTILINE)
    assert error == f"next: swarmcensus compare {two} --pairs\n"
    monkeypatch.setenv("FORCE_COLOR", "1")  # as in a kernel of Jupyter
    text = repr(sc.compare(two))
    assert "\x1b" not in text
    assert all(len(line) <= 120 for line in text.splitlines())


def test_pairs_are_printed_saved_and_the_same(two, tmp_path, accepted):
    out = accepted("compare", two, "--pairs", "--save", tmp_path / "a.csv", "--metric", "correct").out
    frame = sc.compare(two, "correct").pairs
    with open(tmp_path / "a.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [list(row) for row in rows] == [list(frame.columns)] * 4
    for row, kept in zip(rows, frame.to_dict("records"), strict=True):
        assert float(row["p"]) == kept["p"]
        assert row["told_apart"] == str(kept["told_apart"]).lower()
    assert out.endswith(f"{tmp_path / 'a.csv'}\n")
    assert "3 of 4; show all: " in accepted("compare", two, "--pairs", "--metric", "correct", "--limit", "3").out


def test_only_some_worlds_are_shown(two, accepted):
    where = "robots == 10"
    out = accepted("compare", two, "--limit", "5", "--where", where, "--metric", "correct").out
    assert f"2 of 4 worlds; show all: swarmcensus compare {two} --where '{where}' --metric correct --limit 0" in out
    assert sum(line.strip().startswith("legacy") for line in out.splitlines()) == 2


@pytest.mark.parametrize("against", [None, "minimalistic"])
def test_worlds_are_counted_by_what_they_differ_in(against):
    found = sc.compare(made_up(worlds=("a", "b", "c", "d"), gap=0.4), ["final_error", "correct"], against=against)
    for w, world in enumerate(found.grid.worlds):
        world["half"] = w // 2
    found.grid.coordinates["half"] = [world["half"] for world in found.grid.worlds]
    table = found.table
    table["half"] = [found.grid.worlds[w]["half"] for w in table["world"]]
    rows = found.by("half")
    assert len(rows) == 2 * (4 if against is None else 3)
    for row in rows.to_dict("records"):
        mine = table[(table["half"] == row["half"]) & (table["contender"] == row["contender"])]
        assert row["worlds"] == len(mine) == 2
        ways = ("best", "level", "behind") if against is None else ("better", "level", "worse")
        assert [row[f"final_error_{way}"] for way in ways] == [(mine["final_error_standing"] == w).sum() for w in ways]
    assert rows["final_error_best" if against is None else "final_error_worse"].sum() > 0
    assert len(found.by("half", "topology")) == 4 * (4 if against is None else 3)


@pytest.mark.parametrize(("words", "said"), [
    ("--metric corect", "--metric corect"),
    ("--margin much", "--margin much: should be a number"),
    ("--margin 0.1 --margin 0.2", "--margin is given twice for one measure"),
    ("--where brain=='legacy'", "there is nothing to compare: all settings are of legacy"),
    ("--by topolgy", "--by topolgy"),
    ("--by robots", "--by robots"),
    ("--by topology --pairs", "--pairs does not go with --by"),
])  # fmt: skip
def test_refusals_write_nothing(two, words, said, refused, capsys):
    assert said in refused("compare", two, *words.split())
    assert capsys.readouterr().out == ""


def test_latex_is_written(two, tmp_path):
    tex = tmp_path / "c.tex"
    assert main(["compare", str(two), "--save", str(tex)]) == 0
    verdict = sc.compare(two).verdict
    assert [f"% {line}" for line in verdict] == tex.read_text().splitlines()[1 : 1 + len(verdict)]


# ---- what is drawn
def texts_of(figure):
    figure.draw_without_rendering()
    return [text.get_text() for text in figure.findobj(mpl.text.Text)]


def test_ranks_figure():
    found = sc.compare(made_up(gap=0.15), "final_error")
    figure = sc.plot.ranks(made_up(gap=0.15), metric="final_error")
    [axes] = figure.axes
    ranks = found.contests[0].average_ranks
    texts = texts_of(figure)
    for name, rank in zip(found.contenders, ranks, strict=True):
        assert renamed_contender(name, TITLES) in [" ".join(text.split()) for text in texts]
        assert f"{rank:.2f}" in texts
    feet = {round(line.get_xdata()[0], 9) for line in axes.lines if len(line.get_xdata()) == 3}
    assert feet == {round(rank, 9) for rank in ranks.tolist()}
    apart = found.apart_overall(found.contests[0])
    bars = [line.get_xdata() for line in axes.lines if line.get_linewidth() == 3]
    for one in range(4):
        for other in range(one):
            joined = any(min(x) <= min(ranks[[one, other]]) and max(ranks[[one, other]]) <= max(x) for x in bars)
            assert joined != apart[one, other]
    assert 0 < apart.sum() < 12
    with pytest.raises(sc.InputError, match="no world in which all contenders"):
        sc.plot.ranks(made_up().isel(setting=[0, 1, 4, 6]))


def test_the_front_is_of_those_whom_none_beats_in_both():
    random = np.random.default_rng(1)
    for low in (True, False):
        for _ in range(50):
            cost, value = random.integers(0, 4, (2, 6)).astype(float)
            value[random.integers(6)] = np.nan
            found = front(cost, value, low)
            for k in range(6):
                as_good = (cost <= cost[k]) & (value <= value[k] if low else value >= value[k])
                beaten = (as_good & ((cost != cost[k]) | (value != value[k]))).any()
                assert found[k] == (not beaten and not np.isnan(value[k]))
    near, far = np.array([2408.1, 2408.3]), np.array([2400.0, 2410.0])  # costs that chance alone tells apart, or not
    assert [front(cost, np.array([0.2, 0.1]), True).tolist() for cost in (near, far)] == [[False, True], [True, True]]


def test_pareto_draws_each_world_with_its_front_and_intervals():
    data = made_up(gap=0.3)
    figure = sc.plot.pareto(data)
    found = sc.compare(data, "final_error")
    assert len(figure.axes) == 2
    for world, axes in enumerate(figure.axes):
        dots = [line for line in axes.lines if line.get_marker() not in ("", "None")]
        at = {(line.get_xdata()[0], line.get_ydata()[0]) for line in dots}
        costs = [float(f"{cost:.3g}") for cost in found.costs["bytes_sent"][world]]
        assert at == {*zip(costs, found.contests[0].values[world], strict=True)}
        full = [line for line in dots if line.get_markerfacecolor() != "white"]
        first = front(found.costs["bytes_sent"][world], found.contests[0].values[world], True)
        assert len(full) == first.sum() > 1
    for cost in ("messages_sent", "memory_bytes", "message_bytes"):
        assert len(sc.plot.pareto(data, metric="correct", cost=cost).axes) == 2
    with pytest.raises(sc.InputError, match="no such cost; there are messages_sent, bytes_sent, memory_bytes"):
        sc.plot.pareto(data, cost="money")
