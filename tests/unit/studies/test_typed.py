"""What editors and type checkers see: a study's tables, and what public functions return."""

import importlib
import inspect
import re
from pathlib import Path

import numpy as np
import pytest

import swarmcensus as sc

PROGRAM = """
import networkx as nx
import numpy as np
import swarmcensus as sc

sc.Study(trials=3, swarm=dict(robots=[2, 3], accuracy="U(0.6, 0.8)"), world={"topology": "ring", "fill_ratio": 0.5})
swarm = sc.Swarm(robots=range(2, 5), accuracy=np.linspace(0.6, 0.9, 3), brain=["voter", {"file": "a.py", "p": 2}])
world = sc.World(
    topology=[nx.path_graph(3), "full"], fill_ratio={"from": 0.9, "to": 0.1, "at": 5}, message="ratio16",
    body=sc.Body(speed=0.1, message_delay="0.2 s"),
)
sc.Study(
    trials=sc.Until(until="convergence_error median +- 0.1"), swarm=swarm, world=world,
    schedule=sc.Schedule(ticks="17 min"), case=[dict(robots=5)],
    members=[sc.Members(robots=0.1, brain="shouter", honest=False), {"robots": 1, "accuracy": 0.6}],
    faults=[sc.Fault(at=3, robots=1, stop="sensing"), sc.Fault(at="9 s", robots={"named": [1]}, do="kill")],
    measure=sc.Measure(checkpoints=[1, 2], metrics="mean-error"), labels={"voter": "Voter model"},
).with_(trials=4, seed=None, density=2)
read = sc.Study.load("study.toml", {"density": 2}).world
sc.Study(trails=3, swarm=swarm, world=world)  # E: "trails"
sc.Swarm(robot=2, robots=3, accuracy=0.8)  # E: "robot"
sc.Swarm(robots="2", accuracy=0.8)  # E: "robots"
sc.World(topology="ring", fill_ratio=0.5, message="ratio9")  # E: "message"
sc.Fault(at=3, robots=1, stop="smiling")  # E: "stop"

results = sc.load("results.nc")
sc.plot.save(sc.plot.lines(results, y="correct"), "lines.png")
sc.plot.lines(results).axis  # E: "axis"
sc.plot.lines(results, width="column", labels={"a.py": "A"}).savefig("lines.pdf")
sc.plot.lines(results, width="colum")  # E: "width"
sc.compare(results).verdicts  # E: "verdicts"
print(sc.check("brain.py").notes[0].upper(), sc.leaderboard().kinds, sc.reproduce().claims[0].verdict)
sc.check("brain.py").faults  # E: "faults"
"""


def test_tables_are_made_from_keywords():
    """With values as in a file, or of NumPy; a wrong one is named in a sentence."""
    world = {"topology": "moving", "fill_ratio": 0.5, "density": 1, "body": sc.Body(speed=0.1)}
    made = sc.Study(trials=3, swarm=sc.Swarm(robots=np.arange(2, 5), accuracy=np.float64(0.8)), world=sc.World(**world))
    assert [setting.robots for setting in made.settings()] == [2, 3, 4]
    assert sc.Study.parse(made.text).settings() == made.settings()
    for wrong, says in (
        (lambda: sc.Swarm(robots=0, accuracy=0.8), "Swarm: robots = 0: should be greater than or equal to 1"),
        (lambda: sc.Swarm(robts=3, accuracy=0.8), "Swarm: unknown key robts: did you mean 'robots'?"),
        (lambda: sc.World(topology="rng", fill_ratio=0.5), 'Worlds?: topology = "rng": '),
        (lambda: sc.Fault(at=3, robots=1), "should have either stop, or, for processes, do"),
    ):
        with pytest.raises(sc.InputError, match=says):
            wrong()
    with pytest.raises(sc.InputError, match=r"swarm = World\(.*\): should be a Swarm, or a dictionary"):
        sc.Study(trials=1, swarm=sc.World(topology="ring", fill_ratio=0.5), world=world)
    assert repr(sc.Swarm(robots=3, accuracy=0.8, brain="voter")) == 'Swarm(brain=["voter"], robots=[3], accuracy=[0.8])'
    assert (Path(sc.__file__).parent / "py.typed").is_file()


def test_public_names_do_not_depend_on_imports():
    for name in sc.__all__:
        if home := getattr(getattr(sc, name), "__module__", None):
            importlib.import_module(home)
    assert {name for name in sc.__all__ if inspect.ismodule(getattr(sc, name))} == {"plot", "theory"}


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
