"""A package of plugins: the files that docs/adding.md shows, and some that are wrong."""

import re
import tomllib

from swarmcensus import brains
from tests.support.places import DOCS

PAGE = (DOCS / "adding.md").read_text(encoding="utf-8")
EXAMPLES = {
    "lowest": "A metric",
    "cylinder": "A topology",
    "hills": "A kind of floor",
    "beta": "A sensor spread",
    "violins": "A figure",
    "pebble": "A target of `deploy`",
}  # files, and their sections

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


def install_meadow(folder):
    """Put the package into a folder."""
    files = (
        MORE
        | {"stubborn": brains.load("legacy").source + "# under another name\n"}
        | {"grey": '"""Grey: one half."""\n\n\ndef lie(me, x):\n    return 0.5\n'}
        | {name: re.search(r"```python\n(.*?)```", section(title), re.DOTALL)[1] for name, title in EXAMPLES.items()}
    )
    [shown] = re.findall(r"```text\n(.*?)```", section("In a package of your own"), re.DOTALL)
    points = tomllib.loads(shown)["project"]["entry-points"]
    for kind, entries in MORE_POINTS.items():
        points[f"swarmcensus.{kind}"] |= {entry.partition(":")[2] or entry: f"meadow.{entry}" for entry in entries}
    install(folder, "meadow", files, points)
