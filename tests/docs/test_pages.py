"""Pages are whole: links lead somewhere, and tables and lists have all that the code has."""

import re
import runpy
import tomllib

import pytest

import swarmcensus as sc
from swarmcensus.cli.app import OF_ALL, OF_TABLES, arguments_of
from swarmcensus.results import schema
from swarmcensus.studies.study import Study
from swarmcensus.studies.tables import Measure, Schedule, Swarm, Tables, World
from swarmcensus.studies.wanted import Wanted
from swarmcensus.summaries.measures import MEASURES
from swarmcensus.support.significance import fewest_trials
from swarmcensus.support.toml_text import to_toml
from swarmcensus.worlds.bodies import Body
from tests.support.pages import BLOCK, PAGES, assert_shown, blocks, cells_of, page_named
from tests.support.places import ROOT

RUN = {"python", "toml", "console", "sh"}
SHOWN = {"text", "csv", "r", "matlab", "c"}
EXAMPLE = ROOT / "studies" / "example"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_block_has_a_language_that_says_whether_it_runs(page):
    text = page.read_text(encoding="utf-8")
    assert text.count("```") == 2 * len(BLOCK.findall(text))
    assert {language for language, _ in BLOCK.findall(text)} <= RUN | SHOWN


def test_text_on_wrong_beliefs_has_the_tables_numbers():
    """Medians to three digits."""
    rows = {(row["accuracy"], row["belief"], row["f"]): row for row in cells_of("wrong-beliefs")}
    columns = ("error", "moving robots", "formula")
    fixed, moving, alone = ({of: f"{float(row[name]):.3f}" for of, row in rows.items()} for name in columns)
    told = " ".join((ROOT / "docs" / "paper.md").read_text(encoding="utf-8").partition("## Wrong beliefs")[2].split())
    drawn, above = "N(0.0,0.05)", "0.05"
    for sentence in (
        f"cost {fixed['0.675', above, '0.55']} at *f* = 0.55 and {fixed['0.675', above, '0.95']} at *f* = 0.95",
        f"0.95 err by {fixed['0.875', drawn, '0.95']} on the scale-free network and {moving['0.875', drawn, '0.95']} "
        f"among moving robots, but {alone['0.875', drawn, '0.95']} alone. Sensors of 0.675 err by "
        f"{fixed['0.675', drawn, '0.95']} and {moving['0.675', drawn, '0.95']}, and "
        f"{alone['0.675', drawn, '0.95']} alone",
    ):
        assert sentence in told


@pytest.mark.long
def test_steering_page_shows_the_paired_comparison(tmp_path, monkeypatch, capsys):
    """The line of good sensors on independent tiles: all eight would cost many times as much."""
    study = tomllib.loads((ROOT / "studies" / "steering.toml").read_text(encoding="utf-8"))
    study["world"] |= {"floor": "tiles", "fill_ratio": 0.95}
    study["swarm"]["accuracy"] = 0.975
    sc.save(sc.run(Study.parse(to_toml(study))), tmp_path / "steering.nc")
    monkeypatch.setattr("sys.argv", ["paired.py", str(tmp_path / "steering.nc"), "minimalistic", "leaver"])
    runpy.run_path(str(EXAMPLE / "paired.py"), run_name="__main__")
    [shown] = (t for t in blocks(ROOT / "docs" / "moving-robots.md", "text") if t.startswith("floor "))
    head, *lines = shown.splitlines(keepends=True)
    [line] = (line for line in lines if line.startswith("tiles          0.95  0.975"))
    assert_shown(re.sub(" +\n", "\n", capsys.readouterr().out), head + line)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_to_files_and_headings(page):
    for target in re.findall(r"\]\(([^)\s]+)\)", BLOCK.sub("", page.read_text(encoding="utf-8"))):
        if target.startswith(("http", "../../actions/")):  # of a forge
            continue
        path, _, anchor = target.partition("#")
        file = (page.parent / path).resolve() if path else page
        assert file.is_relative_to(ROOT), target
        assert file.exists(), target
        if anchor and file.suffix == ".md":
            headings = re.findall(r"^#+ (.*)$", BLOCK.sub("", file.read_text(encoding="utf-8")), re.MULTILINE)
            slugs = {re.sub(r"[^\w\- ]", "", h.lower()).strip().replace(" ", "-") for h in headings}
            assert anchor in slugs, target


def test_pages_list_every_key():
    """A row for each, besides those of tables that docs_hooks/tables.py writes."""
    tables = {"swarm", "world", "schedule", "measure"}
    fields = {k for table in (Tables, Swarm, World, Schedule, Measure, Body) for k in table.model_fields}
    row = re.compile(r"^\| `(\w+)` \|", re.MULTILINE)
    assert fields - tables <= set(row.findall(page_named("study-file").read_text(encoding="utf-8")))
    planning = page_named("planning").read_text(encoding="utf-8").partition("key of `[wanted]`")[2]
    assert row.findall(planning) == [*Wanted.model_fields]
    assert all(f"`[{table}]`" in page_named("study-file").read_text(encoding="utf-8") for table in tables)


def test_the_data_page_lists_all_that_a_dataset_holds():
    text = (ROOT / "docs" / "data-format.md").read_text(encoding="utf-8")
    listed = set(re.findall(r"`(\w+)`", "".join(line for line in text.splitlines() if line.startswith("|"))))
    mentioned = set(re.findall(r"`(\w+)`", text))
    swarm = {"robots": 2, "accuracy": 0.7}
    fixed = {"world": {"topology": "ring", "fill_ratio": 0.5}, "measure": {"local": True}, "schedule": {"rounds": 2}}
    moving = {"world": {"topology": "moving", "fill_ratio": 0.5, "density": 1}, "schedule": {"ticks": 2}}
    faulty = moving | {"faults": [{"at": 1, "robots": 1, "stop": "sensing"}]}
    for tables in (fixed, moving, faulty):
        study = Study(trials=1, swarm=swarm, **tables)
        data = sc.run(study)
        trace = sc.replay(data, 0, 0, links=tables is not fixed)
        in_memory = set(study.swarm.brain[0].memory)
        for names in (data.dims, data.coords, data.data_vars, data.attrs, set(trace.data_vars) - in_memory):
            assert set(map(str, names)) <= listed
        assert set(trace.attrs) | set(map(str, trace.dims)) <= mentioned
    assert set(sc.infer([[1]], None, 0.7).attrs) <= mentioned
    assert schema.FORMAT in text


def test_pages_show_files_of_the_examples():
    for page, file in (("brain-contract", "my_brain.py"), ("metrics", "overshoot.py")):
        assert (EXAMPLE / file).read_text(encoding="utf-8") in blocks(page_named(page), "python")
    [study] = (t for t in blocks(page_named("brain-contract"), "toml") if "my_brain.py" in t)
    assert study in (EXAMPLE / "compare.toml").read_text(encoding="utf-8")


@pytest.mark.long
@pytest.mark.parametrize("measured", ["measured_changes", "measured_sensors"])
def test_tables_of_what_goes_beyond_the_paper_are_measured(measured, benchmark):
    for name, (heads, rows) in getattr(benchmark("beyond"), measured)().items():
        printed = "".join(f"{','.join(row)}\n" for row in [heads, *rows])
        assert_shown(printed, (ROOT / "benchmarks" / "tables" / f"{name}.csv").read_text(encoding="utf-8"))


def test_architecture_page_lists_packages_in_order():
    packages = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"][0]["layers"]
    page = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    assert re.findall(r"│ (\w+) ", page) == packages
    assert {path.parent.name for path in (ROOT / "src" / "swarmcensus").glob("*/__init__.py")} == set(packages)
    for package in packages:
        said = (ROOT / "src" / "swarmcensus" / package / "__init__.py").read_text().split('"""')[1].splitlines()
        assert [line.partition(":")[0] for line in said[2:5]] == ["In", "Out", "Must not know"], package
    for file in re.findall(r"`((?:\w+/)+\w+\.py)`", page):
        assert (ROOT / "src" / "swarmcensus" / file).is_file(), file


def test_environment_of_conda_asks_for_the_same_versions():
    needed = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["dependencies"]
    text = (ROOT / "environment.yml").read_text(encoding="utf-8")
    named = re.findall(r"^  - ([\w.]+) (>=[\d.]+)$", text, re.MULTILINE)
    assert [name + bound for name, bound in named if name != "python"] == needed


def test_comparing_page_lists_every_measure():
    text = page_named("comparing").read_text(encoding="utf-8")
    listed = {}
    for names, better in re.findall(r"^\| (`\w+`(?:, `\w+`)*) \| [^|]* \| (\w+) \|", text, re.MULTILINE):
        listed |= dict.fromkeys(re.findall(r"\w+", names), better)
    assert listed == {name: "low" if one.low else "high" for name, one in MEASURES.items()}
    assert f"among 36 tests it takes {fewest_trials(36, 0.05)} trials" in " ".join(text.split())


@pytest.mark.parametrize(("name", "command"), [("tuning", "tune"), ("a-swarm-on-your-desk", "swarm")])
def test_a_page_of_a_command_names_every_option(name, command):
    """All its long ones but those of every command."""
    text = page_named(name).read_text(encoding="utf-8")
    own = [one for one in arguments_of(command) if one.field_info.name not in OF_ALL | OF_TABLES]
    options = {option for one in own for option in one.names if option.startswith("--")}
    assert {option for option in options if f"`{option}" not in text} == set()
