"""The paper from one call: files, page, JSON, the terminal's table, and what happens when it cannot be done."""

import dataclasses
import itertools
import json
import re

import pytest
import xarray as xr

import swarmcensus as sc
from swarmcensus.evaluation.paper import evidence, page, report, reproducing as paper
from swarmcensus.evaluation.paper.evaluations import PAPER
from swarmcensus.evaluation.paper.evidence import FAILS, HOLDS, NEITHER, NO, PARTLY, UNDECIDED, YES, Outcome
from swarmcensus.figures.columns import columns_grid
from swarmcensus.figures.kinds.scatter import scatter_grid
from swarmcensus.results import store as results
from swarmcensus.support.errors import InputError, Interrupted
from swarmcensus.support.files import shipped_study
from swarmcensus.support.terminal import as_text

CLAIM = PAPER.claims[0]
STUDIES = ("local", "moving", "other-networks", "same-observations", "same-rounds", "topologies")


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """All claims, and a figure of each kind."""
    only = ["fig2", "fig4", "claims"]
    return paper.reproduce(tmp_path_factory.mktemp("paper") / "out", trials=2, jobs=2, only=only, say=lambda _: None)


def outcome(verdict, *details, **changes):
    return Outcome(dataclasses.replace(CLAIM, **changes), verdict, details, (), details[0] if details else None)


def a_page(tmp_path, *outcomes):
    (tmp_path / "claims.json").touch()
    return page.html(report.Reproduction(tmp_path, "swarmcensus reproduce", {}, [], outcomes, {}))


def test_all_files_are_there(done):
    holds_all(done, (2, 4))


def holds_all(done, figures):
    drawn = [f"fig{k}{axes}.{kind}" for k in figures for axes in ("", "-as-paper") for kind in ("png", "svg")]
    expected = [*(f"data/{n}.nc" for n in STUDIES), *(f"figures/{name}" for name in drawn), "claims.json", "index.html"]
    found = [p.relative_to(done.out).as_posix() for p in done.out.rglob("*") if p.is_file()]
    assert sorted(found) == sorted(expected)
    assert sorted([*done.others, *done.files]) == sorted(done.out / name for name in expected)
    assert list(done.seconds) == ["compile", "simulate", "figures", "claims", "page"]


def test_the_studies_hold_all_runs_of_the_paper():
    """4 networks of 10 and 100 robots, and 2 densities, by 11 accuracies, 2 fill ratios and 30 trials: 6,600."""
    studies = [sc.Study.load(shipped_study("paper") / f"{name}.toml") for name in ("topologies", "moving")]
    assert sum(len(study.settings()) * study.trials for study in studies) == 6600


@pytest.mark.long
def test_the_page_of_all_parts_needs_nothing_from_outside(tmp_path):
    done = paper.reproduce(tmp_path, trials=2, jobs=2, say=lambda _: None)
    holds_all(done, (2, 3, 4, 5))
    assert "--trials 2" in needs_nothing_from_outside(done)


def needs_nothing_from_outside(done):
    """The text of a page that holds its figures and leads to files beside it alone."""
    text = done.page.read_text(encoding="utf-8")
    tags, links, sources, ids = (re.findall(rf"<{what}", text) for what in (
        r"(\w+)", r'[^>]*href="([^"]*)', r'img[^>]*src="([^"]*)', r'[^>]*\bid="([^"]*)'))  # fmt: skip
    assert "http" not in re.sub(r"base64,[A-Za-z0-9+/=]+", "", text).replace("http-equiv", "")  # a picture may spell it
    assert "url(" not in text
    assert not {"script", "link", "iframe", "object"} & set(tags)
    assert len(sources) == 2 * len(done.figures)  # ours, and with the paper's axes
    assert all(source.startswith("data:image/png;base64,") for source in sources)
    for link in links:
        assert link[1:] in ids if link.startswith("#") else (done.out / link).is_file()
    assert len(set(ids)) == len(ids)
    return text


def test_each_picture_has_its_own_text_and_files(done):
    enough = {name: xr.concat([data] * 3, "trial", data_vars="minimal") for name, data in done.datasets.items()}
    text = page.html(dataclasses.replace(done, datasets=enough))
    figure = text.partition('<figure id="fig4">')[2].partition("</figure>")[0]
    ours, theirs = (re.findall(rf"<p class={kind}>(.*?)</p>", figure, re.DOTALL)[0] for kind in ("ours", "theirs"))
    assert ("95 % interval" in ours, "interval" in theirs) == (True, False)
    assert re.findall(r'href="([^"]*)', ours) == ["figures/fig4.png", "figures/fig4.svg"]
    assert re.findall(r'href="([^"]*)', theirs) == ["figures/fig4-as-paper.png", "figures/fig4-as-paper.svg"]
    cells = re.findall(r"<td>([^<\s]+)", text.partition('<figure id="fig2">')[2].partition("</figure>")[0])
    assert len(cells) == 11 * 4 * 2  # accuracies, panels, and the median K and its error
    assert all(re.fullmatch(r"[\d,]+(\.5)?|0\.\d{4}", cell) for cell in cells)


def test_a_closed_claim_counts_its_settings(tmp_path):
    details = [evidence.Detail("ring", 0.04, (0.03, 0.06), said) for said in (NEITHER, YES, YES)]
    text = a_page(tmp_path, outcome(PARTLY, *details))
    closed, opened = text.partition("<details class=claim>")[2].split("</summary>", 1)
    assert ("2 yes, 1 neither" in closed, "0.04" in closed, "0.04" in opened) == (True, False, True)


def test_claims_are_all_there_and_valid_json(done):
    text = (done.out / "claims.json").read_text(encoding="utf-8")
    read = json.loads(text, parse_constant=pytest.fail)
    assert [claim["id"] for claim in read["claims"]] == [claim.id for claim in PAPER.claims]
    for claim in read["claims"]:
        assert claim["verdict"] in evidence.VERDICTS
        assert all(claim[key] for key in ("title", "sentence", "section", "statistic", "threshold", "settings"))
        assert {each["verdict"] for each in claim["settings"]} <= {YES, NO, NEITHER}
    assert read["studies"]["topologies"] == {"seed": 2023, "trials": 2}
    assert report.as_json(evidence.check(done.datasets, PAPER.claims), done.datasets, PAPER.source) == text


def test_every_figure_names_claims_and_studies_that_exist():
    names = {claim.id for claim in PAPER.claims}
    assert len(names) == len(PAPER.claims)
    spoken_of = {name for figure in PAPER.figures for name in figure.claims}
    assert (spoken_of - names, names - spoken_of) == (set(), {"minimal"})
    used = {view.study for figure in PAPER.figures for view in figure.views}
    used |= {study for claim in PAPER.claims for study in claim.studies}
    assert used <= {path.stem for path in shipped_study("paper").glob("*.toml")}


@pytest.mark.long
def test_a_part_runs_only_what_it_needs(tmp_path):
    said, bars = [], []
    done = paper.reproduce(tmp_path, trials=1, seed=5, only="fig5", pdf=True, progress=bars.append, say=said.append)
    assert list(done.datasets) == ["moving"]
    drawn = {f"fig5{axes}.{kind}" for axes in ("", "-as-paper") for kind in ("png", "svg", "pdf")}
    assert {p.name for p in done.others} == {"moving.nc"} | drawn
    assert not (tmp_path / "claims.json").exists()
    assert "--trials 1 --seed 5 --only fig5" in needs_nothing_from_outside(done)
    assert [line.partition(":")[0] for line in said] == ["compile", "simulate", "figures", "page"]
    assert said[1] == f"simulate: {done.datasets['moving'].attrs['wall_seconds']:.1f} s of wall-clock time"
    assert bars[-1].done == bars[-1].total == 44
    assert bars[-1].work_done == pytest.approx(bars[-1].work_total)


def test_somebody_elses_page_is_left_alone(tmp_path, monkeypatch):
    monkeypatch.setattr(paper, "run", lambda *_, **__: pytest.fail("was run"))
    (tmp_path / "index.html").write_text("<title>My home page</title>")
    with pytest.raises(InputError, match=r"index\.html"):
        paper.reproduce(tmp_path, trials=2)
    assert (tmp_path / "index.html").read_text() == "<title>My home page</title>"


@pytest.mark.parametrize("blocked", ["out", "out/data", "out/index.html/inside"])
def test_unwritable_folder_is_found_first(tmp_path, monkeypatch, blocked):
    path = tmp_path / blocked
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("in the way")
    monkeypatch.setattr(paper, "run", lambda *_, **__: pytest.fail("was run"))
    with pytest.raises(InputError, match="cannot write"):
        paper.reproduce(tmp_path / "out", trials=1)


def test_an_unknown_part_is_refused_with_the_known_ones(tmp_path):
    with pytest.raises(InputError, match=r"'fig9'.*fig2, fig3, fig4, fig5, claims"):
        paper.reproduce(tmp_path / "out", only=["fig2", "fig9"])
    assert not (tmp_path / "out").exists()


def test_lines_of_claims_are_at_their_thresholds():
    claims = {claim.id: claim for claim in PAPER.claims}
    for figure in PAPER.figures:
        needed = [claims[name].needed.right[1] for name in figure.claims]
        marked = {view.claim for view in figure.views} - {None}
        assert marked <= {*needed} if figure.kind == "scatter" else marked == {1000, 10_000}
        assert marked


def test_figures_on_the_paper_s_axes_are_linear(done):
    figure = PAPER.figures[1]
    free, own = (view.panel(done.datasets, as_paper=True) for view in figure.views)
    (left, right) = scatter_grid([free, own], scale="linear", claimed=figure.claimed).axes
    assert {left.get_xscale(), left.get_yscale()} == {"linear"}
    assert right.get_ylim()[1] > left.get_ylim()[1]
    labels = [view.panel(done.datasets, as_paper=True) for view in PAPER.figures[2].views]
    (ax, *_) = columns_grid(labels, claimed="claim", as_paper=True).axes
    assert not [c for c in ax.collections if "interval" in str(c.get_label())]


@pytest.mark.long
def test_ctrl_c_keeps_finished_work_of_reproduce(tmp_path, monkeypatch):
    whole, finished = paper.run, []

    def run(study, **options):
        data = whole(study, **options)
        if not finished:
            finished.append(study.name)
            return data
        raise Interrupted(data, 3, 22)

    monkeypatch.setattr(paper, "run", run)
    with pytest.raises(Interrupted, match="3 of 22"):
        paper.reproduce(tmp_path, trials=1, only="fig3", say=lambda _: None)
    files = sorted(p.relative_to(tmp_path).as_posix() for p in tmp_path.rglob("*") if p.is_file())
    assert files == ["data/same-rounds.nc", "data/topologies.nc"]
    assert results.load(tmp_path / "data" / "topologies.nc").sizes["trial"] == 1
    monkeypatch.undo()
    data = results.load(tmp_path / "data" / "topologies.nc")
    results.save(data.assign_attrs(wall_seconds=100.0), tmp_path / "data" / "topologies.nc")
    said = []
    done = paper.reproduce(tmp_path, trials=1, only="fig4", say=said.append)
    spent = sum(each.attrs["wall_seconds"] for each in done.datasets.values())
    assert spent > 100  # not only what this call computed
    assert done.seconds["simulate"] == pytest.approx(spent, abs=0.001)
    assert f"simulate: {spent:.1f} s of wall-clock time, with earlier calls" in said


def test_all_text_on_the_page_is_escaped(tmp_path):
    nasty = "<script>alert('&')</script>"
    detail = evidence.Detail(nasty, 1.0, (0.5, 2.0), NO, nasty)
    texts = dict.fromkeys(("title", "sentence", "section", "statistic", "explanation"), nasty)
    texts["needed"] = evidence.Needed(nasty, (0.0, 1.0), (0.0, 1.0))
    text = a_page(tmp_path, outcome(FAILS, *[detail] * 5, **texts))
    assert "<script>" not in text
    assert text.count("&lt;script&gt;alert(&#39;&amp;&#39;)") > 12


def test_the_table_fits_narrow_terminals():
    said, checked = itertools.cycle(((HOLDS, YES), (PARTLY, NO), (FAILS, NO), (UNDECIDED, NEITHER))), []
    for claim, (verdict, found) in zip(PAPER.claims, said, strict=False):
        one = evidence.Detail("scale-free, f = 0.55, U(0.525,0.975)", 12.34, (11.5, 123.5), found, "1234 and 100")
        checked.append(Outcome(claim, verdict, (one,) * 44, ("ring",), one))
    text = as_text(report.Reproduction(None, "", {}, [], checked, {}).print_on, 80)
    assert max(map(len, text.splitlines())) <= 80
    assert "Ring and line are alike" in text
    assert text.count("hold") + text.count("not decided") >= len(PAPER.claims)
    assert text.splitlines()[1] == "38 claims; holds: 10, not decided: 9, holds in part: 10, does not hold: 9"


def test_a_claim_is_a_row_of_plain_numbers(done):
    first = done.rows[0]
    assert list(first)[:3] == ["id", "title", "verdict"]
    assert first["yes"] + first["no"] + first["neither"] + first["left_out"] == 22
    assert [row["value"] for row in done.rows] == [claim["value"] for claim in done.fields["claims"]]
    assert done.cautions == ["intervals need 6 trials or more: 2 trials cannot decide most claims"]
    assert done.to_tsv().count("\n") == 1 + len(PAPER.claims)
