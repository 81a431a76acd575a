"""What README and docs/ show is so: examples run, commands parse, links lead somewhere, tables are complete."""

import re
import runpy
import shlex
import shutil
import tomllib
from pathlib import Path

import pytest

import swarmcensus as sc
from swarmcensus import metrics
from swarmcensus.cli.commands import main, parser
from swarmcensus.cli.commands.plan import KEYS
from swarmcensus.conformance import suite as conformance
from swarmcensus.conformance.contract_checks import PROMISES
from swarmcensus.planning.mission import Area, Free, Known, Mission, Wanted, mission_of
from swarmcensus.results import structure
from swarmcensus.runs.queues import Queue
from swarmcensus.studies.study import Study
from swarmcensus.studies.tables import Measure, Schedule, Swarm, Tables, World
from swarmcensus.studies.toml_text import to_toml
from swarmcensus.worlds.bodies import Body
from tests.conftest import OUR_C_LIBRARY

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md", *sorted((ROOT / "docs").glob("*.md"))]
BLOCK = re.compile(r"^```([^\n]*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
RUN = {"python", "toml", "console", "sh"}
SHOWN = {"text", "csv", "r", "matlab", "c"}
OTHER_PROGRAMS = {
    "cut",
    "less",
    "npm",
    "export",
    "make",
    "sh",
    "tools/lowest.sh",
    "pip",
    "python",
    "pytest",
    "ruff",
    "lint-imports",
    "mypy",
    "pre-commit",
    "mkdocs",
    "mpremote",
    "source",
    ".ci/run",
}
EXAMPLE = ROOT / "studies" / "example"


def blocks(page, *languages):
    return [text for language, text in BLOCK.findall(page.read_text(encoding="utf-8")) if language in languages]


def with_blocks(*languages):
    pages = [page for page in PAGES if blocks(page, *languages)]
    return pytest.mark.parametrize("page", pages, ids=lambda page: page.name)


def examples(*languages):
    return pytest.mark.parametrize(
        "text",
        [pytest.param(t, id=f"{page.name}-{k}") for page in PAGES for k, t in enumerate(blocks(page, *languages))],
    )


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_block_has_a_language_that_says_whether_it_runs(page):
    text = page.read_text(encoding="utf-8")
    assert text.count("```") == 2 * len(BLOCK.findall(text))
    assert {language for language, _ in BLOCK.findall(text)} <= RUN | SHOWN


@pytest.mark.long(
    only=[
        "beyond.md",
        "beyond-changing.md",
        "beyond-unknown-sensors.md",
        "brain-contract.md",
        "comparing.md",
        "data-format.md",
        "moving-robots.md",
        "rivals-bayesian.md",
        "rivals-consensus.md",
        "rivals-opinions.md",
        "rivals-others.md",
        "strobel-2020.md",
        "tuning.md",
        "wrong-beliefs.md",
    ]
)
@with_blocks("python")
def test_python_runs(page, tmp_path, monkeypatch, capsys):
    """The blocks of a page one after the other, in a folder with the example's files.

    A text right below a block is what the block prints, word for word. With another C library walks are other walks:
    there it is so in numbers to 0.01.
    """
    shutil.copytree(ROOT / "studies", tmp_path / "studies")
    for file in filter(Path.is_file, EXAMPLE.iterdir()):
        shutil.copy(file, tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    names = {"__name__": "example"}
    for text in blocks(page, "python"):
        capsys.readouterr()
        exec(compile(text, page.name, "exec"), names)
        below = page.read_text(encoding="utf-8").partition(text + "```\n\n```text\n")[2]
        if below:
            assert_shown(capsys.readouterr().out, below.partition("```")[0])


def assert_shown(printed, shown):
    """What is printed is what a page shows."""
    if OUR_C_LIBRARY:
        assert printed == shown
    number = r"-?\d+\.\d+"
    assert re.sub(number, "", printed) == re.sub(number, "", shown)
    found, told = ([float(n) for n in re.findall(number, t)] for t in (printed, shown))
    assert found == pytest.approx(told, abs=0.01)


def test_a_page_that_shows_another_last_digit_is_found_out():
    assert_shown("error 0.0204\n", "error 0.0204\n")
    for wrong in ["errors 0.0204\n", *["error 0.0205\n"] * OUR_C_LIBRARY]:
        with pytest.raises(AssertionError):
            assert_shown("error 0.0204\n", wrong)


def test_what_follows_from_wrong_beliefs_is_what_its_tables_say():
    """Medians to three digits; those tables are held against what their code prints, above."""
    page = ROOT / "docs" / "wrong-beliefs.md"
    fixed, moving, alone = {}, {}, {}
    simulated, endless = blocks(page, "text")
    for line in simulated.splitlines()[2:]:
        if line == "wrong-beliefs-moving":
            fixed, moving = moving, fixed
            continue
        accuracy, belief, fill, median, *_ = line.split()
        fixed[accuracy, belief.partition("=")[2], fill] = f"{float(median):.3f}"
    fixed, moving = moving, fixed
    for accuracy, fill, error in map(str.split, endless.splitlines()):
        alone[accuracy, fill] = f"{float(error):.3f}"
    told = " ".join(page.read_text(encoding="utf-8").partition("## What follows")[2].split())
    drawn, above, below = "N(0.0,0.05)", "0.05", "-0.05"
    for sentence in (
        f"cost {fixed['0.675', above, '0.55']} at *f* = 0.55 and {fixed['0.675', above, '0.95']} at *f* = 0.95",
        f"-0.05 costs {fixed['0.675', below, '0.55']} and +0.05 costs {fixed['0.675', above, '0.55']}, for",
        f"+0.05 costs {fixed['0.675', above, '0.95']} with sensors of 0.675 and {fixed['0.875', above, '0.95']} with",
        f"0.95 have {fixed['0.875', drawn, '0.95']} on the scale-free network and {moving['0.875', drawn, '0.95']} "
        f"among moving robots, where it would be {alone['0.875', '0.95']} alone. But sensors of 0.675 keep "
        f"{fixed['0.675', drawn, '0.95']} and {moving['0.675', drawn, '0.95']} of {alone['0.675', '0.95']}",
    ):
        assert sentence in told


@pytest.mark.long
def test_the_steering_page_shows_what_the_paired_comparison_prints(tmp_path, monkeypatch, capsys):
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


@examples("toml")
def test_toml_is_a_study_or_a_change_to_one(text):
    """Or a cluster; a block that is no whole study must turn a plain one into another that is right."""
    tables = {
        "trials": 1,
        "swarm": {"robots": 20, "accuracy": 0.7},
        "world": {"topology": "ring", "fill_ratio": 0.55},
    }
    found = tomllib.loads(text)
    if "wanted" in found:
        mission_of(found, base=EXAMPLE)
        return
    if "jobs" in found:
        Queue.model_validate(found)
        return
    if not {"trials", "swarm", "world"} <= set(found):
        for key, value in found.items():
            tables[key] = tables[key] | value if isinstance(tables.get(key), dict) else value
        found = tables
    assert Study.parse(to_toml(found), context={"base": EXAMPLE}).settings()


def commands(text):
    """The commands of a block, each a list of words; in a console they follow a $."""
    lines = text.replace("\\\n", " ").splitlines()
    if any(line.startswith("$ ") for line in lines):
        lines = [line[2:] for line in lines if line.startswith("$ ")]
    for line in lines:
        words = shlex.split(line, comments=True)
        while words:
            end = next((k for k, word in enumerate(words) if word in ("&&", "|")), len(words))
            command = words[:end]
            yield command[: command.index(">")] if ">" in command else command
            words = words[end + 1 :]


PROGRAM = parser()


@examples("console", "sh")
def test_commands_parse(text):
    assert list(commands(text))
    for program, *arguments in commands(text):
        if program == "swarmcensus":
            PROGRAM.parse_args(arguments)
        else:
            assert program in OTHER_PROGRAMS


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_to_files_and_headings(page):
    for target in re.findall(r"\]\(([^)\s]+)\)", BLOCK.sub("", page.read_text(encoding="utf-8"))):
        if target.startswith("http"):
            continue
        path, _, anchor = target.partition("#")
        file = (page.parent / path).resolve() if path else page
        assert file.is_relative_to(ROOT), target
        assert file.exists(), target
        if anchor:
            headings = re.findall(r"^#+ (.*)$", BLOCK.sub("", file.read_text(encoding="utf-8")), re.MULTILINE)
            slugs = {re.sub(r"[^\w\- ]", "", h.lower()).strip().replace(" ", "-") for h in headings}
            assert anchor in slugs, target


def test_the_study_page_lists_every_key():
    text = (ROOT / "docs" / "study-file.md").read_text(encoding="utf-8")
    fields = {k for table in (Tables, Swarm, World, Schedule, Measure, Body) for k in table.model_fields}
    tables = {"swarm", "world", "schedule", "measure"}
    assert fields - tables <= set(re.findall(r"^\| `(\w+)` \|", text, re.MULTILINE))
    assert all(f"`[{table}]`" in text for table in tables)


def test_the_planning_page_lists_every_key():
    text = (ROOT / "docs" / "planning.md").read_text(encoding="utf-8")
    listed = re.findall(r"^\| `(?:\w+\.)?(\w+)` \|", text, re.MULTILINE)
    fields = {k for table in (Mission, Area, Known, Wanted, Free) for k in table.model_fields}
    assert fields - {"known", "wanted", "free"} <= set(listed)
    assert all(f"`--{key.replace('_', '-')}`" in text for key in (*KEYS, "brain", "body"))


@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        ("[schedule]", "[schedule]\nround = 3"),
        ("accuracy = 0.7", ""),
        ("fill_ratio = 0.5", "fill_ratio = 1.5"),
        ("[schedule]", "[schedule]\n[measure]\ncheckpoints = [5, 2000]"),
        ("[swarm]", "[swarm"),
    ],
)
def test_the_study_page_shows_errors_as_they_are(right, wrong, tmp_path, monkeypatch, capsys):
    page = (ROOT / "docs" / "study-file.md").read_text(encoding="utf-8")
    plain = "trials = 1\n[swarm]\nrobots = 5\naccuracy = 0.7\n[world]\ntopology = 'ring'\nfill_ratio = 0.5"
    plain += "\n[schedule]\n"
    monkeypatch.chdir(tmp_path)
    Path("s.toml").write_text(plain.replace(right, wrong), encoding="utf-8")
    assert main(["run", "s.toml"]) == 2
    assert capsys.readouterr().err in page


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
    assert structure.FORMAT in text


def test_the_brain_page_shows_the_shipped_example_and_every_check():
    page = ROOT / "docs" / "brain-contract.md"
    assert (EXAMPLE / "my_brain.py").read_text(encoding="utf-8") in blocks(page, "python")
    [study] = (t for t in blocks(page, "toml") if "my_brain.py" in t)
    assert study in (EXAMPLE / "compare.toml").read_text(encoding="utf-8")
    for name in ("keeps the contract", *conformance.checks()):
        assert f"| {name} |" in page.read_text(encoding="utf-8")


@pytest.mark.long
def test_the_brain_page_shows_what_brains_prints_in_a_narrow_terminal(monkeypatch, capsys):
    """Each part that it shows; dots stand for the rest."""
    monkeypatch.setenv("SWARMCENSUS_TERMINAL", "80")
    assert main(["brains"]) == 0
    printed = re.sub(" +$", "", capsys.readouterr().out, flags=re.MULTILINE)
    [shown] = (
        t for t in blocks(ROOT / "docs" / "brain-contract.md", "console") if t.startswith("$ swarmcensus brains\n")
    )
    parts = shown.removeprefix("$ swarmcensus brains\n").split("...\n")
    assert len(parts) == 4
    for part in parts[:3]:
        assert part in printed


@pytest.mark.parametrize("script", sorted((ROOT / "benchmarks").glob("*.py")), ids=lambda script: script.stem)
def test_benchmarks_find_what_they_measure(script, monkeypatch):
    monkeypatch.syspath_prepend(script.parent)
    runpy.run_path(str(script), run_name="measured elsewhere")


def test_the_page_shows_every_shipped_metric_and_the_example_is_its_file():
    page = ROOT / "docs" / "metrics.md"
    hook = runpy.run_path(str(ROOT / "docs_hooks" / "tables.py"))["on_page_markdown"]
    built = hook(page.read_text(encoding="utf-8"), page=None, config=None, files=None)
    rows = re.findall(r"^\| `([a-z-]+)` \| (\w+) \| (\w+) \|", built, re.M)
    shipped = [metrics.load(name) for name in metrics.PLUGINS.shipped]
    assert rows == [(metric.name, metric.unit, "low" if metric.low else "high") for metric in shipped]
    example = (ROOT / "studies" / "example" / "overshoot.py").read_text(encoding="utf-8")
    assert example in list(blocks(page, "python"))


def test_the_architecture_page_shows_the_rooms_in_the_order_that_is_held():
    rooms = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"][0]["layers"]
    page = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    assert re.findall(r"│ (\w+) ", page) == rooms
    assert {path.parent.name for path in (ROOT / "src" / "swarmcensus").glob("*/__init__.py")} == set(rooms)
    for room in rooms:
        said = (ROOT / "src" / "swarmcensus" / room / "__init__.py").read_text().split('"""')[1].splitlines()
        assert [line.partition(":")[0] for line in said[2:5]] == ["In", "Out", "Must not know"], room
    for room, file in re.findall(r"`(\w+)/(\w+\.py)`", page):
        assert (ROOT / "src" / "swarmcensus" / room / file).is_file(), file


@pytest.mark.long
def test_the_example_brain_conforms(untraced):
    assert all(check.fault is None for check in conformance.check(EXAMPLE / "my_brain.py"))


@pytest.mark.long
@pytest.mark.parametrize("page", [ROOT / "README.md"], ids=lambda page: page.name)
def test_the_brains_of_a_page_keep_the_contract(page, tmp_path):
    """All checks but those that compile, which the example brain goes through."""
    for text in blocks(page, "python"):
        if "MEMORY" in text:
            (tmp_path / "mine.py").write_text(text, encoding="utf-8")
            assert all(check.fault is None for check in conformance.examine(tmp_path / "mine.py", PROMISES))


def test_the_recorded_example_is_what_its_study_makes(tmp_path, monkeypatch, capsys):
    """The commands of docs/data-format.md give the files of studies/example, and the numbers that it shows.

    Where a change was meant to alter numbers, make both anew.
    """
    page = ROOT / "docs" / "data-format.md"
    shutil.copytree(ROOT / "studies", tmp_path / "studies")
    monkeypatch.chdir(tmp_path)
    example = tmp_path / "studies" / "example"
    (example / "observations.csv").unlink()
    (example / "links.csv").unlink()
    assert main(["run", "studies/example/recorded.toml"]) == 0
    [shown] = (t for t in blocks(page, "console") if "--recording" in t)
    capsys.readouterr()
    for _, *arguments in commands(shown):
        assert main(arguments) == 0
    assert (example / "observations.csv").read_bytes() == (EXAMPLE / "observations.csv").read_bytes()
    assert (example / "links.csv").read_bytes() == (EXAMPLE / "links.csv").read_bytes()
    assert capsys.readouterr().out.endswith(shown[shown.index("minimalistic on") :])


def test_the_clusters_page_lists_every_key_and_shows_its_job(tmp_path, monkeypatch):
    page = ROOT / "docs" / "clusters.md"
    text = page.read_text(encoding="utf-8")
    assert set(re.findall(r"^\| `(\w+)` \|", text, re.MULTILINE)) == set(Queue.model_fields)
    [toml], [shown] = blocks(page, "toml"), blocks(page, "text")
    job = Queue.model_validate(tomllib.loads(toml) | {"interface": "lo"})
    monkeypatch.chdir(tmp_path)  # where the folder of its logs is made
    with job.start() as cluster:
        script = cluster.job_script()
    script = re.sub(r"tcp://\S+ --name \S+", "tcp://10.0.0.1:40211 --name SLURMCluster-0", script)
    script = re.sub(r"^\S+ -m", "/home/me/venv/bin/python -m", script, flags=re.MULTILINE)
    assert [line for line in script.replace(" lo", " ib0").splitlines() if line] == [
        line for line in shown.splitlines() if line
    ]
