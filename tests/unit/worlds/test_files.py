"""Topologies, floors and spreads in files that a study names by their paths."""

import pickle
import shutil
from pathlib import Path

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus.analysis.explaining.wrong_beliefs import costs
from swarmcensus.cli.commands import main
from swarmcensus.runs import clusters
from swarmcensus.simulation import sampling
from swarmcensus.studies import addresses

WHEEL = """
def edges(robots, chance, *, spokes: int = 3):
    ends = chance.generator().permutation(robots - 3)[:spokes] + 2
    return [(i, (i + 1) % robots) for i in range(robots)] + [(0, int(end)) for end in ends]
"""
STAIN = """
def score(arena, chance, *, middle: float = 0.0):
    return lambda tiles: ((tiles * arena.tile - middle) ** 2).sum(axis=-1)
"""
WEDGE = """
def check(a, b):
    if a > b:
        raise ValueError("it needs a <= b")
def quantile(u, a, b):
    return a + (b - a) * u**0.5
"""
FIXED = """
trials = 2
members = [{robots = 1, accuracy = "my worlds/wedge.py(0.5, 0.6)"}]
schedule.rounds = 6
[swarm]
robots = 12
accuracy = ["my worlds/wedge.py(0.6, 0.9)", {black = "my worlds/wedge.py(0.7, 0.8)", white = 0.8}]
assumed_accuracy = {error = "my worlds/wedge.py(-0.1, 0.1)"}
[world]
topology = ["my worlds/wheel.py", {file = "my worlds/wheel.py", spokes = 5, label = "five spokes"}, "ring"]
fill_ratio = 0.45
"""
MOVING = """
trials = 2
swarm = {robots = 8, accuracy = 0.8}
schedule = {ticks = 20}
[world]
topology = "moving"
side = 2
floor = ["my worlds/stain.py", {file = "my worlds/stain.py", middle = 0.5}]
fill_ratio = 0.45
"""


@pytest.fixture
def files(here):
    Path("my worlds").mkdir()
    for name, text in (("wheel", WHEEL), ("stain", STAIN), ("wedge", WEDGE)):
        Path("my worlds", f"{name}.py").write_text(text)
    Path("fixed.toml").write_text(FIXED)
    Path("moving.toml").write_text(MOVING)
    return here


@pytest.mark.usefixtures("files")
def test_files_say_who_hears_whom_and_what_is_seen():
    settings = sc.Study.load("fixed.toml").settings()
    by = {str(s.topology): s for s in settings}
    assert [*by] == ["my worlds/wheel.py", "five spokes", "ring"]
    for name, spokes in (("my worlds/wheel.py", 3), ("five spokes", 5)):
        links = sampling.links(by[name], 0, 0, 2)
        graphs = [links.receivers[links.starts[k] : links.starts[k + 1]] for k in (0, 1)]
        assert [np.bincount(one)[0] for one in graphs] == [spokes + 2] * 2
        assert not np.array_equal(*graphs)
    others = sampling.accuracies(settings[-1], 0, 0, 500)[0].max(axis=1)  # one robot has a poorer sensor
    assert 0.7 < others.min() < others.max() < 0.8
    assert str(settings[0].accuracy) == "my worlds/wedge.py(0.6,0.9)"
    middles = [sampling.ground(s, 0, 0).all_tiles() for s in sc.Study.load("moving.toml").settings()]
    half = len(middles[0]) // 2
    assert [int(one[half - 50, half - 50]) for one in middles] == [1, 0]
    assert [int(one[half + 90, half + 90]) for one in middles] == [0, 1]


@pytest.mark.long(but_every=3)
@pytest.mark.usefixtures("files")
@pytest.mark.parametrize(("study", "changed"), [("fixed", "wheel"), ("fixed", "wedge"), ("moving", "stain")])
def test_results_of_files_are_verified_and_refused_after_a_change(study, changed, refused):
    assert main(["run", f"{study}.toml", "-q"]) == 0
    assert sc.verify(f"{study}.nc", 1).differences == sc.verify(f"{study}.nc", 1).labels == []
    for command in (["replay", f"{study}.nc", "--setting", "0", "--trial", "1"], ["run", f"{study}.toml"]):
        assert main(command) == 0
    assert sc.merge([f"{study}.nc"]).equals(sc.load(f"{study}.nc"))
    old = shutil.copy(Path("my worlds", f"{changed}.py"), "old.py")
    path = Path("my worlds", f"{changed}.py")
    path.write_text(path.read_text() + "# a word more\n")
    kind = {"wheel": "topology", "wedge": "spread", "stain": "floor"}[changed]
    again = refused("run", f"{study}.toml")
    assert f"{study}.nc: the {kind} my worlds/{changed}.py was changed since these results were made" in again
    for command, more in (("replay", ["--setting", 0, "--trial", 1]), ("verify", ())):
        assert f"the {kind} 'my worlds/{changed}.py' has changed since" in refused(command, f"{study}.nc", *more)
    assert main(["verify", f"{study}.nc", "--sample", "1", "--brain-file", old]) == 0
    assert main(["show", f"{study}.nc"]) == main(["merge", f"{study}.nc", "--out", "y.nc"]) == 0  # they run no file


@pytest.mark.usefixtures("files")
def test_accuracies_of_a_file_are_numbers_and_opening_results_runs_no_file():
    results = sc.run(sc.Study.load("fixed.toml"), jobs=1)
    Path("my worlds", "wedge.py").write_text("raise SystemExit")
    sc.save(results, "x.nc")
    again = sc.load("x.nc")
    assert again.identical(results)
    assert np.allclose(again["accuracy_black"][:2], [0.6 + 0.3 * 2 / 3, 0.7 + 0.1 * 2 / 3], atol=1e-3)
    assert {cost.error for cost in costs(again)} == {None}


@pytest.mark.usefixtures("files")
def test_clusters_get_the_sources():
    for name in ("fixed", "moving"):
        study = sc.Study.load(f"{name}.toml")
        payload = pickle.dumps(clusters.payload_of(study))
        Path("my worlds").rename("gone")
        there, _ = clusters.read_payload(pickle.loads(payload))
        Path("gone").rename("my worlds")
        marks = [[addresses.fingerprint(s, 0) for s in one.settings()] for one in (study, there)]
        assert marks[0] == marks[1]
        assert study.with_(trials=3).settings() == study.settings()


@pytest.mark.usefixtures("files")
def test_python_names_files_too():
    world = {"topology": [Path("my worlds/wheel.py")], "fill_ratio": 0.5}
    study = sc.Study(trials=1, swarm={"robots": 9, "accuracy": "my worlds/wedge.py(0.6, 0.7)"}, world=world)
    assert str(study.settings()[0].topology) == "my worlds/wheel.py"
    assert sc.Study.parse(study.text, context=study.context).settings() == study.settings()


LINES = """trials = 1
swarm = {{robots = 12, accuracy = {accuracy}}}
world = {{topology = {topology}, {more}fill_ratio = 0.45}}
"""


@pytest.mark.parametrize(("key", "value", "text", "said"), [  # tests/unit/support/test_plugins.py tries more functions
    ("topology", '"whel.py"', "", "there is no file whel.py"),
    ("topology", '"x.py"', "x = 1", "topology file x.py: it has no function edges"),
    ("topology", '"x.py"', "x = = 1", "topology file x.py: fails when it is loaded: not Python: invalid syntax"),
    ("topology", '"x.py"', "def edges(robots, *, label=3):\n    return []", "it has a key label, which means"),
    ("floor", '"x.py"', "x = 1", "floor file x.py: it has no function score"),
    ("floor", '{file = "x.py"}', "def score(arena, chance, *, file=1):\n    return 1", "it has a key file"),
    ("accuracy", '"y.py(0.7)"', "", "there is no file y.py"),
    ("accuracy", '"x.py(0.7)"', "x = 1", "spread file x.py: it has no function quantile"),
    ("accuracy", '{start = "x.py(2, 3)", drift = -1e-5}', WEDGE, "x.py(2.0,3.0) gives 2"),
])  # fmt: skip
def test_wrong_files_are_refused(key, value, text, said, here, refused):
    plain = {"accuracy": "0.7", "topology": '"ring"', "more": ""}
    if key == "floor":
        plain |= {"topology": '"moving"', "more": f"side = 10, floor = {value}, "}
    else:
        plain[key] = value
    Path("s.toml").write_text(LINES.format(**plain))
    if text:
        Path("x.py").write_text(text)
    error = refused("run", "s.toml", "--out", "s.nc")
    assert said in error
    assert error.startswith("swarmcensus: study file s.toml: ")
