"""Additions of another package: found by their entry points, with keys of their own, checked, and remembered."""

import contextlib
import json
import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import swarmcensus as sc
from swarmcensus import brains
from swarmcensus.brains import adversary, metrics
from swarmcensus.cli.commands import main
from swarmcensus.figures import kinds
from swarmcensus.robots import targets
from swarmcensus.simulation import sampling
from swarmcensus.studies import addresses
from swarmcensus.support import plugins
from swarmcensus.support.readers import AS_TERMINAL
from swarmcensus.worlds import distributions, patterns, wiring
from tests.support.long import in_two_sizes
from tests.support.places import DOCS
from tests.support.small import study_of

# processes begun here go known ways: what is new in them is traced in this one
pytestmark = pytest.mark.usefixtures("untraced_processes")
PAGE = (DOCS / "adding.md").read_text(encoding="utf-8")
EXAMPLES = {  # files, and their sections
    "lowest": "A metric", "cylinder": "A topology", "hills": "A kind of floor", "beta": "A sensor spread",
    "violins": "A figure", "pebble": "A target of `deploy`",
}  # fmt: skip

MORE = {
    "pairs": """
        from typing import Annotated
        from pydantic import Field
        def edges(robots, chance, *, share: Annotated[float, Field(le=1)] = 1.0):
            pairs = chance.generator().permutation(robots)[: robots // 2 * 2].reshape(-1, 2)
            return pairs[: round(share * len(pairs))]
        def check(robots, *, share):
            if robots < 4:
                raise ValueError("there should be four robots")
        """,
    "dice": """
        import random
        def edges(robots):
            return [(i, (i + random.randrange(1, robots)) % robots) for i in range(robots)]
        """,
    "chain": """
        DIRECTED = True
        def edges(robots, *, steps: list[int] = [1]):
            return {(i, i + s) for s in steps for i in range(robots - s)}
        """,
    "photo": """
        from swarmcensus.worlds.pictures import PictureFile
        def score(arena, chance, *, file: PictureFile, bright: bool = True):
            return lambda tiles: chance.noise(tiles) + file.grey[0, 0]
        def check(arena, *, file, bright):
            if arena.side > 9:
                raise ValueError("the picture is of a smaller place")
        """,
    "dots": """
        def paint(arena, chance, share, *, seldom: float = 1.0):
            return lambda tiles: chance.noise(tiles) < share / seldom
        """,
    "broken": "x = = 1",
    "wrong": """
        from types import SimpleNamespace as File
        import numpy as np
        far, loop, two = (File(edges=lambda robots, pairs=pairs: pairs) for pairs in ([(0, 12)], {(1, 1)}, [(0, 1, 2)]))
        typo = File(edges=lambda robots: robot)
        def edges(robots, *, x: "Nope" = 3):
            return []
        unclear = File(edges=edges)
        def edges(robots, *, day):
            return []
        odd = File(edges=edges)
        flat = File(score=lambda arena, chance: lambda tiles: tiles[0])
        def score(arena, chance):
            generator = chance.generator()
            return lambda tiles: generator.random(tiles.shape[:2])
        fickle = File(score=score)
        wide, hole = File(quantile=lambda u, a: a * u), File(quantile=lambda u: np.nan * u)
        def check(a):
            if a > 3:
                raise ValueError("a should be 3 at the most")
        wide.check = check
        """,
    "drawings": """
        from matplotlib.figure import Figure
        def boxes(results, *, color: str = "brain", whiskers: float = 1.5, title: str | None = None):
            figure = Figure()
            figure.add_subplot().set_title(f"{color} {whiskers:g} {title}")
            return figure
        def fails(results):
            return {}["no such\\nkey"]
        def nothing(results):
            pass
        def awry(results, more):
            pass
        """,
}
MORE_POINTS = {
    "topologies": ["pairs", "dice", "chain", "broken", "gone", "empty"]
    + [f"wrong:{name}" for name in ("far", "loop", "two", "typo", "unclear", "odd")],
    "floors": ["photo", "dots", "empty", "wrong:flat", "wrong:fickle"],
    "spreads": ["empty", "wrong:wide", "wrong:hole"],
    "figures": ["gone", *(f"drawings:{name}" for name in ("boxes", "fails", "nothing", "awry"))],
}


def section(title):
    return PAGE.partition(f"\n## {title}\n")[2].partition("\n## ")[0]


def install(folder, name, files, points):
    """Put a package into a folder as pip would; `points` are its entry points, group by group."""
    (folder / name).mkdir(parents=True)
    for module, text in {"__init__": "", "empty": "", **files}.items():
        lines = text.splitlines(keepends=True)
        indent = " " * min((len(line) - len(line.lstrip()) for line in lines if line.strip()), default=0)
        (folder / name / f"{module}.py").write_text("".join(line.removeprefix(indent) for line in lines))
    said = folder / f"{name}-1.0.dist-info"
    said.mkdir()
    (said / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
    groups = (f"[{group}]\n" + "".join(f"{k} = {v}\n" for k, v in entries.items()) for group, entries in points.items())
    (said / "entry_points.txt").write_text("".join(groups))


@pytest.fixture(scope="module")
def package(tmp_path_factory):
    """A folder in which the package "meadow" is installed."""
    files = {
        "stubborn": brains.load("legacy").source + "# under another name\n",
        "grey": '"""Grey: one half."""\n\n\ndef lie(me, x):\n    return 0.5\n',
    }
    files |= {name: re.search(r"```python\n(.*?)```", section(at), re.DOTALL)[1] for name, at in EXAMPLES.items()}
    [shown] = re.findall(r"```text\n(.*?)```", section("In a package of your own"), re.DOTALL)
    points = tomllib.loads(shown)["project"]["entry-points"]
    for kind, entries in MORE_POINTS.items():
        points[f"swarmcensus.{kind}"] |= {entry.partition(":")[2] or entry: f"meadow.{entry}" for entry in entries}
    folder = tmp_path_factory.mktemp("site")
    install(folder, "meadow", MORE | files, points)
    return folder


def forget():
    """Forget the entry points of other packages, because other ones are installed now."""
    for kind in (brains, adversary, metrics, wiring, patterns, distributions, kinds, targets):
        kind.PLUGINS.__dict__.pop("outside", None)
        kind.PLUGINS.clashes.clear()


@contextlib.contextmanager
def there(package):
    """The package is installed in this process."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(package)
        forget()
        yield
    forget()


@pytest.fixture
def installed(package, here):
    with there(package):
        yield package


AGAIN = ("run", "replay", "merge")
TOLD = """
import contextlib, io, json, sys
from swarmcensus.cli.commands import main
said = []
for command in json.loads(sys.argv[1]):
    with contextlib.redirect_stderr(io.StringIO()) as error:
        said.append((main(command), error.getvalue()))
json.dump(said, sys.stderr)
"""


def elsewhere(package, *commands):
    """Run commands in another process, with the package. Gives the exit code of each, and what it says."""
    command = [sys.executable, "-c", TOLD, json.dumps([[str(word) for word in command] for command in commands])]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(package), *sys.path])}
    return json.loads(subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stderr)


# ---- topologies, kinds of floor and spreads
FIXED = """
seed = 5
trials = 2
schedule.rounds = 12
[swarm]
robots = 30
accuracy = ["beta(8, 2)", {black = 0.9, white = "beta(5, 1)"}]
assumed_accuracy = [0.8, {error = "beta(1, 9)"}]
[world]
topology = ["cylinder", {name = "cylinder", columns = 5}, {name = "pairs", share = 0.5}, {name = "chain", steps = [1, 3]}, "ring"]
fill_ratio = 0.45
"""  # noqa: E501
MOVING = """
seed = 5
trials = 2
swarm = {robots = 10, accuracy = "beta(8, 2)"}
schedule.ticks = 40
[world]
topology = "moving"
side = 2
floor = ["hills", {hills = 0.25}, "dots", {photo = "leaf.png", bright = false}, "half"]
fill_ratio = 0.45
"""


def leaf(folder):
    Image.fromarray(np.full((2, 2), 100, np.uint8)).save(folder / "leaf.png")


@pytest.fixture(scope="module")
def done(package, tmp_path_factory):
    """A folder with three studies and their results, made from the command line."""
    folder = tmp_path_factory.mktemp("plugins")
    leaf(folder)
    for name, text in (("fixed", FIXED), ("moving", MOVING), ("measured", MEASURED)):
        (folder / f"{name}.toml").write_text(text)
    with there(package), pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        for name in ("fixed", "moving", "measured"):
            assert main(["run", f"{name}.toml", "-q"]) == 0
    return folder


def test_dataset_names_plugins_with_their_keys(done):
    fixed, moving = sc.load(done / "fixed.nc"), sc.load(done / "moving.nc")
    names = ["cylinder", "cylinder(columns=5)", "pairs(share=0.5)", "chain(steps=[1,3])", "ring"]
    assert list(dict.fromkeys(fixed["topology"].values)) == names
    assert set(fixed["accuracy"].values) == {"beta(8.0,2.0)", "black=0.9 white=beta(5.0,1.0)"}
    assert set(fixed["assumed_accuracy"].values) == {"0.8", "error=beta(1.0,9.0)"}
    assert moving["floor"].values.tolist() == ["hills", "hills(0.25)", "dots", "photo(leaf,false)", "half"]
    assert moving["floor_leaf"].dtype == np.uint16


@in_two_sizes("share", 0.01, 1.0)
def test_trials_are_verified_bit_for_bit(installed, done, share):
    for name in ("fixed", "moving", "measured"):
        assert sc.verify(done / f"{name}.nc", share).differences == []


CHANGED = {
    "cylinder": ("fixed", dict.fromkeys(AGAIN, "the topology cylinder of meadow was changed since")),
    "hills": ("moving", dict.fromkeys(AGAIN, "the floor hills of meadow was changed since")),
    "beta": ("fixed", dict.fromkeys(AGAIN, "the spread beta of meadow was changed since")),
    "stubborn": ("measured", {"run": "the brain stubborn of meadow was", "verify": "brain 'stubborn': its source"}),
    "lowest": ("measured", {"run": "is of another run: metrics is", "verify": "metric 'lowest': its source has"}),
}


@pytest.mark.long
@pytest.mark.parametrize("files", [("cylinder", "hills", "stubborn"), ("beta", "lowest")], ids=" ".join)
def test_results_of_a_changed_file_are_not_mixed(files, package, done, here):
    shutil.copytree(package, "site")
    commands = []
    for file in files:  # each of a study of its own
        study, refusals = CHANGED[file]
        path, used, given = Path("site", "meadow", f"{file}.py"), f"{file}.nc", f"given_{file}.py"
        shutil.copy(done / f"{study}.nc", used)
        shutil.copy(path, given)
        path.write_text(path.read_text() + "# a word more\n")
        every = {
            "run": ("run", done / f"{study}.toml", "--out", used), "merge": ("merge", used, "--out", "y.nc"),
            "replay": ("replay", used, "--setting", 0, "--trial", 0), "verify": ("verify", used, "--sample", 1),
        }  # fmt: skip
        commands += [every[name] for name in refusals] + [(*every["verify"], "--brain-file", given)]
    found = iter(elsewhere(here / "site", *commands))
    for study, refusals in (CHANGED[file] for file in files):
        for due in refusals.values():
            code, said = next(found)
            assert code == 2
            assert [due in line for line in said.splitlines() if not line.startswith("warning: ")] == [True]
        code, said = next(found)  # a busy machine may be spoken of
        assert (code, "its source" in said) == (0, False) or study != "measured"
    assert not Path("y.nc").exists()


def test_results_of_a_missing_package_are_readable(done, refused):
    assert main(["show", str(done / "moving.nc")]) == 0
    said = refused("replay", done / "moving.nc", "--setting", 0, "--trial", 0)
    assert 'swarm.accuracy = "beta(8, 2)"' in said
    assert said.endswith(": these results were made with meadow 1.0, not installed here")
    results = done / "measured.nc"
    assert main(["show", str(results)]) == main(["replay", str(results), "--setting", "0", "--trial", "0"]) == 0
    for command in (("replay", "--setting", 1, "--trial", 0), ("verify", "--sample", 1)):
        assert "the brain 'stubborn' is a file" in refused(command[0], results, *command[1:])


def test_draws_depend_on_names_and_fingerprints_on_files(installed):
    settings = {str(s.topology): s for s in sc.Study.parse(FIXED).settings()}
    assert len({addresses.fingerprint(s, 5) for s in settings.values()}) == len(settings)
    assert len({tuple(addresses.losses_key(s, 5)) for s in settings.values()}) == len(settings)
    pairs = settings["pairs(share=0.5)"]
    key, mark = addresses.losses_key(pairs, 5), addresses.fingerprint(pairs, 5)
    pairs.topology.__dict__["edition"] = "another"
    assert (addresses.losses_key(pairs, 5) == key).all()
    assert addresses.fingerprint(pairs, 5) != mark
    shipped = study_of(accuracy="U(0.5, 0.9)", topology=["ring", "full"]).settings()
    assert not any(addresses._editions(setting) for setting in shipped)


LINES = """trials = 2
swarm = {{robots = 12, accuracy = {accuracy}}}
world = {{topology = {topology}, {more}fill_ratio = 0.45}}
schedule.{length} = 5
"""


@pytest.mark.parametrize(("key", "value", "said"), [
    # topologies
    ("topology", '"cilynder"', "did you mean 'cylinder'? a topology is one of full, grid, line, moving, "),
    ("topology", '{name = "cylinder", columns = 2}', "'cylinder' of 12 robots, columns = 2: a cylinder has whole rows"),
    ("topology", '{name = "cylinder", columns = "x"}', "topology cylinder: columns = 'x': should be a whole number"),
    ("topology", '{name = "cylinder", column = 4}', "no key column: did you mean 'columns'? it has columns"),
    ("topology", '"broken"', "topology 'broken', meadow.broken of meadow: not Python: invalid syntax, at "),
    ("topology", '"gone"', "topology 'gone', meadow.gone of meadow: ModuleNotFoundError"),
    ("topology", '"empty"', "topology 'empty', meadow.empty: it has no function edges"),
    ("topology", '"far"', "its edge (0, 12) leads to a robot that is not there: they are numbered 0 to 11"),
    ("topology", '"loop"', "its edge (1, 1) joins a robot to itself"),
    ("topology", '"two"', "its edges should be pairs of robot numbers, from 0"),
    ("topology", '"dice"', "its edges should be the same at each call: those that differ from trial"),
    ("topology", '"typo"', "topology 'typo' of 12 robots: NameError: name 'robot' is not defined, at "),
    ("topology", '{name = "odd", day = 2024-02-29}', "topology odd: day should be a number, a text, true or false, or"),
    ("topology", '"unclear"', "the keys of meadow.wrong.edges cannot be read: NameError"),
    # floors
    ("floor", '"hill"', 'did you mean \'hills\'? a floor is one of {benchmark = "star", '),
    ("floor", "{hills = 1, length = 2}", "floor hills: hills is its length"),
    ("floor", '"photo"', "floor photo needs the key file: write {photo = ..., bright = true}"),
    ("floor", '{photo = "none.png"}', "none.png: there is no such file"),
    ("floor", '{photo = "leaf.png"}', 'world.floor = {photo = "leaf.png", bright = true}'),
    ("floor", '"flat"', "floor flat: for tiles (1, 3, 2) it should give a finite number each, (1, 3)"),
    ("floor", "{dots = 0}", "floor dots(0): ZeroDivisionError"),
    ("floor", '"fickle"', "a tile should have the same value at each call, in any order"),
    # spreads
    ("accuracy", '"bta(8, 2)"', "did you mean 'beta'? a sensor accuracy is"),
    ("accuracy", '"beta(8)"', "beta(a, b) needs 2 numbers, not 1"),
    ("accuracy", '"beta(8, inf)"', "a sensor accuracy is"),
    ("accuracy", '"wide(2)"', "a sensor accuracy lies in [0, 1], and wide(2.0) gives 2"),
    ("accuracy", '"wide(4)"', "wide(a): a should be 3 at the most"),
    ("accuracy", '"hole()"', "and hole() gives nan"),
])  # fmt: skip
def test_wrong_input_is_refused_in_a_line(key, value, said, installed, refused):
    plain = {"accuracy": "0.7", "topology": '"ring"', "more": "", "length": "rounds"}
    if key == "floor":
        plain |= {"topology": '"moving"', "more": f"side = 10, floor = {value}, ", "length": "ticks"}
    else:
        plain[key] = value
    leaf(Path())
    Path("s.toml").write_text(LINES.format(**plain))
    error = refused("run", "s.toml", "--out", "s.nc")
    assert said in error
    assert error.startswith("swarmcensus: study file s.toml: ")


def test_a_file_changed_during_a_run_is_reported(installed, package):
    study = sc.Study.parse(FIXED)
    path = package / "meadow" / "cylinder.py"
    before = path.read_text()
    try:
        path.write_text(before + "# a word more\n")
        with pytest.raises(sc.InputError, match=r"topology 'cylinder': .*cylinder\.py was changed since it was"):
            sc.run(sc.Study.parse(FIXED))
    finally:
        path.write_text(before)
    assert (len(study.additions), study.additions["topology cylinder"]["package"]) == (4, "meadow")


# ---- brains, metrics and figures
MEASURED = """
trials = 3
swarm = {brain = ["legacy", "stubborn"], robots = 8, accuracy = 0.7}
world = {topology = "ring", fill_ratio = 0.55}
schedule = {rounds = 40}
measure = {metrics = ["lowest", "first-right"]}
"""


def test_a_brain_and_a_metric_do_what_their_files_say(installed, done):
    results = sc.load(done / "measured.nc")
    assert results["brain"].values.tolist() == ["legacy", "stubborn"]
    assert (results["final_estimate"][0] == results["final_estimate"][1]).all()
    assert results["lowest"].attrs["long_name"] == "lowest estimate"
    for setting in (0, 1):
        curves = sc.replay(results, setting, 2)["estimate"].values[1:]
        assert (results["lowest"].values[setting, 2] == curves.min(axis=0)).all()


def test_figure_of_a_package_is_drawn_from_python_and_a_shell(installed, done):
    figure = sc.plot.violins(sc.load(done / "measured.nc"), y="lowest", x="brain")
    assert figure.axes[0].get_ylabel() == "lowest (1)"
    assert {"violins", "boxes", "fails"} <= {*dir(sc.plot)}
    plot = ["plot", str(done / "measured.nc"), "--kind"]
    assert main([*plot, "violins", "--y", "lowest", "--x", "brain", "--out", "v.svg"]) == 0
    sc.plot.save(figure, "w.svg")
    assert Path("v.svg").read_bytes() == Path("w.svg").read_bytes()
    assert main([*plot, "boxes", "--color", "topology", "--option", "whiskers=3", "--out", "b.svg"]) == 0
    assert "topology 3 None" in Path("b.svg").read_text()


@pytest.mark.parametrize(("kind", "said"), [
    ("violin", "did you mean 'violins'?"),
    ("boxes --x robots", "--kind boxes has no key x: "),
    ("boxes --option whisker=1", "--kind boxes has no key whisker: "),
    ("boxes --option whiskers=wide", "--kind boxes: whiskers = 'wide': should be a valid number"),
    ("boxes --option whiskers", "--option whiskers"),
    ("fails", "figure 'fails', meadow.drawings:fails: KeyError: 'no such"),
    ("nothing", "figure 'nothing' returned NoneType: should be a matplotlib Figure"),
    ("awry", "figure 'awry', meadow.drawings:awry: should be a function of results and keyword-only options"),
    ("gone", "figure 'gone', meadow.gone of meadow: ModuleNotFoundError"),
])  # fmt: skip
def test_faults_of_a_plugin_figure(kind, said, installed, done, refused):
    assert said in refused("plot", done / "measured.nc", "--kind", *kind.split())


# ---- adversaries
@pytest.mark.long
def test_plugin_adversary(installed, monkeypatch):
    members = [{"robots": 2, "brain": "grey", "honest": False}]
    data = sc.run(study_of(robots=6, rounds=5, trials=2, members=members), jobs=1)
    assert data["adversary"].values.tolist() == ["grey"]
    assert json.loads(data.attrs["additions"])["adversary grey"]["package"] == "meadow"
    assert sc.verify(data, 1.0).differences == []


# ---- targets
def test_a_target_of_another_package_writes_its_files(installed, tmp_path):
    made = sc.deploy("minimalistic", tmp_path / "made", target="pebble", accuracy={"black": 0.9, "white": 0.8})
    assert {path.name for path in made.fields["folder"].iterdir()} == {"brain.py", "sensor.txt"}
    assert (made.fields["folder"] / "sensor.txt").read_text(encoding="utf-8") == "0.9 0.8"


# ---- every kind of plugin
def test_plugins_are_listed_without_being_run(installed, monkeypatch, capsys):
    monkeypatch.setenv(AS_TERMINAL, "400")
    for name in [name for name in sys.modules if name.startswith("meadow.")]:
        del sys.modules[name]
    assert main(["list"]) == 0
    assert {name for name in sys.modules if name.startswith("meadow.")} == set()
    printed = capsys.readouterr()
    rows = [line.split() for line in printed.out.splitlines() if line]
    tables = ["brains", "adversaries", "metrics", "topologies", "floors", "spreads", "figures", "targets"]
    assert [row[0] for row in rows if row[-1] == "from"] == tables
    by = {row[0]: row for row in rows}
    assert by["lowest"][1:] == ["The", "lowest", "estimate", "that", "a", "robot", "ever", "holds.", "meadow"]
    assert by["minimalistic"][-1] == by["scale-free"][-1] == by["scatter"][-1] == "swarmcensus"
    assert by["grey"][1:] == ["Grey:", "one", "half.", "meadow"]
    assert by["always-black"][-1] == "swarmcensus"
    assert by["stubborn"][-1] == by["violins"][-1] == by["beta"][-1] == "meadow"
    assert by["broken"][1:4] == ["cannot", "be", "read:"]
    assert by["cylinder"][1:3] == ["columns", "A"]
    assert by["small-world"][1:3] == ["neighbours,", "rewired"]
    assert by["beta"][1:4] == ["a,", "b", "Beta:"]
    assert printed.err == ""


def test_shipped_names_need_no_package_search(monkeypatch):
    forget()
    monkeypatch.setattr(plugins, "entry_points", lambda **_: pytest.fail("other packages were looked through"))
    world = {"topology": ["full", "ring", "line", "scale-free", "moving"], "density": 2, "fill_ratio": 0.5,
             "floor": ["tiles", "half", {"clusters": 0.2}, {"stripes": 0.5}]}  # fmt: skip
    sc.Study(trials=1, swarm={"robots": 5, "accuracy": ["U(0.5, 0.9)", "N(0.7, 0.1)", 0.7]}, world=world)


def test_name_clashes_of_packages(tmp_path, monkeypatch):
    for name in ("one", "other"):
        points = {"swarmcensus.topologies": {"ring": f"{name}.mine", "cylinder": f"{name}.mine"}}
        install(tmp_path, name, {"mine": "def edges(robots): return []"}, points)
    monkeypatch.syspath_prepend(tmp_path)
    forget()
    (ring,) = study_of().settings()
    assert len(sampling.links(ring, 1, 0, 1).senders) == 10
    with pytest.raises(sc.InputError, match=r"two packages have a topology named 'cylinder': one\.mine, other\.mine"):
        study_of(topology="cylinder")
    forget()
