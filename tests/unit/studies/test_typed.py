"""What editors and type checkers see: a study's tables, and what public functions return."""

import importlib
import inspect
import re
import runpy
from pathlib import Path

import pytest

import swarmcensus as sc
from tests.support.places import ROOT

PROGRAM = """
import networkx as nx
import numpy as np
import swarmcensus as sc

sc.Study(trials=3, swarm=dict(robots=[2, 3], accuracy="U(0.6, 0.8)"), world={"topology": "ring", "fill_ratio": 0.5})
sc.Study(
    trials={"until": "convergence_error median +- 0.1"},
    swarm=dict(robots=range(2, 5), accuracy=np.linspace(0.6, 0.9, 3), brain=["voter", {"file": "a.py", "p": 2}]),
    world=dict(topology=[nx.path_graph(3), "full"], fill_ratio={"from": 0.9, "to": 0.1, "at": 5}, message="ratio16"),
    schedule=dict(ticks="17 min"), case=[dict(robots=5)], members=[dict(robots=0.1, brain="shouter", honest=False)],
    faults=[dict(at=3, robots=1, stop="sensing")], measure=dict(checkpoints=[1, 2], metrics="mean-error"),
    labels={"voter": "Voter model"},
).with_(trials=4, seed=None)
world = sc.Study.load("study.toml", {"density": 2}).world
sc.Study(trails=3, swarm=dict(robots=2, accuracy=0.8), world=dict(topology="ring", fill_ratio=0.5))  # E: "trials"
sc.Study(trials=3, swarm=dict(robot=2, accuracy=0.8), world=dict(topology="ring", fill_ratio=0.5))  # E: "robot"
sc.Study(trials=3, swarm=dict(robots="2", accuracy=0.8), world=dict(topology="ring", fill_ratio=0.5))  # E: "robots"
sc.Study(trials=3, swarm={"robots": 2, "accuracy": 1}, world={"topology": "ring", "fil_ratio": 0.5})  # E: "fil_ratio"

results = sc.load("results.nc")
sc.plot.save(sc.plot.lines(results, y="correct"), "lines.png")
sc.plot.lines(results).axis  # E: "axis"
sc.plot.lines(results, width="column", labels={"a.py": "A"}).savefig("lines.pdf")
sc.plot.lines(results, width="colum")  # E: "width"
sc.compare(results).verdicts  # E: "verdicts"
print(sc.check("brain.py").notes[0].upper(), sc.leaderboard().ranking.costs, sc.reproduce().claims[0].verdict)
sc.check("brain.py").faults  # E: "faults"
"""


def test_a_study_s_typed_tables_are_those_of_its_models():
    """If not: `python tools/typed_tables.py`."""
    tool = runpy.run_path(str(ROOT / "tools" / "typed_tables.py"))
    assert tool["FILE"].read_text(encoding="utf-8") == tool["text"]()
    assert (Path(sc.__file__).parent / "py.typed").is_file()


def test_public_names_do_not_depend_on_imports():
    for name in sc.__all__:
        if home := getattr(getattr(sc, name), "__module__", None):
            importlib.import_module(home)
    modules = {name for name in sc.__all__ if inspect.ismodule(getattr(sc, name))}
    assert modules == {"plot", "theory"}


@pytest.mark.long
def test_type_checker_finds_mistakes(tmp_path):
    api = pytest.importorskip("mypy.api")
    program = tmp_path / "program.py"
    program.write_text(PROGRAM, encoding="utf-8")
    options = ["--config-file=", "--disable-error-code=import-untyped", "--hide-error-context", "--strict"]
    said, failure, _ = api.run([*options, f"--cache-dir={tmp_path}", str(program)])
    assert not failure
    found: dict[int, str] = {}
    for line, message in re.findall(r"program\.py:(\d+): error: (.*)", said):
        found[int(line)] = found.get(int(line), "") + message
    wanted = {k: text.partition("# E: ")[2] for k, text in enumerate(PROGRAM.splitlines(), 1) if "# E: " in text}
    assert found.keys() == wanted.keys(), said
    assert all(wanted[k] in found[k] for k in wanted), said
