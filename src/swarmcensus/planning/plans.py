"""What a plan comes to: a row for each brain and size, and how it is kept in a file."""

import dataclasses
import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

from swarmcensus.basics.errors import InputError
from swarmcensus.basics.files import atomic_write, check_writable
from swarmcensus.basics.options import in_shell, option
from swarmcensus.planning.mission import Mission
from swarmcensus.planning.predictions import Start
from swarmcensus.planning.simulating import Curve, Share
from swarmcensus.studies.toml_text import to_toml_value

MOST_LINES = 8  # of a figure

Question = Literal["how long", "how many", "trade-off", "enough"]
Answer = Literal["reached", "not reached", "not simulated"]


@dataclass(frozen=True)
class Row:
    """One brain in a swarm of one size, in one world: what it needs, and how sure that is.

    Ends of intervals are None where nothing that was looked at is surely enough, or where a number was given. `theory`
    is in minutes, and stands for what was not simulated.
    """

    brain: str
    robots: int
    answer: Answer
    minutes: float
    theory: Start
    topology: str
    accuracy: str  # that is planned for
    density: float | None = None  # of robots that move, where it is given
    side: float | None = None  # of their area, in metres
    robots_low: int | None = None
    robots_high: int | None = None
    minutes_low: float | None = None
    minutes_high: float | None = None
    share: Share | None = None
    fill_ratio: float | None = None  # the worst one of the range
    lie: str | None = None  # the worst one
    trials: int = 0


def row_of(mission: Mission, brain: str, robots: int, minutes: float, theory: Start) -> Row:
    """A row in a world of the mission, of which nothing was simulated yet."""
    return Row(
        brain, robots, "not simulated", minutes, theory, str(mission.free.topology[0]), str(mission.accuracy),
        density=mission.density, side=mission.sized(robots).side,
    )  # fmt: skip


def of_case(row: Row, curve: Curve) -> Row:
    """The row with the case and the trials that a curve is of."""
    lie = None if curve.case.lie is None else curve.case.lie.label
    return replace(row, fill_ratio=curve.case.fill_ratio, lie=lie, trials=curve.shares.shape[1])


@dataclass(frozen=True)
class Plan:
    """A mission's question, and the rows that answer it."""

    question: Question
    mission: Mission
    rows: list[Row]
    text: str  # the mission as TOML

    @property
    def data(self) -> dict[str, Any]:
        """All of it as plain data."""
        rows = [
            {k: v for k, v in dataclasses.asdict(row).items() if v is not None}
            | {"theory": row.theory._asdict()}
            | ({"share": list(row.share)} if row.share else {})
            for row in self.rows
        ]
        truth = "floor" if any(world.on_floor for world in self.mission.worlds) else "nominal"
        return {
            "question": self.question,
            "goal": str(self.mission.goal),
            "confidence": self.mission.wanted.confidence,
            "truth": truth,
            "seed": self.mission.seed,
            "mission": self.text,
            "rows": rows,
        }

    def save(self, path: str | Path) -> None:
        """Write it as .json or .toml, whole or not at all. Raises InputError."""
        check_out(path)
        data = self.data
        if Path(path).suffix == ".json":
            text = json.dumps(data, indent=1, allow_nan=False) + "\n"
        else:
            rows = data.pop("rows")
            lines = [f"{key} = {to_toml_value(value)}" for key, value in data.items()]
            for row in rows:
                lines += ["", "[[rows]]", *(f"{key} = {to_toml_value(value)}" for key, value in row.items())]
            text = "\n".join(lines) + "\n"
        with atomic_write(path) as temporary:
            temporary.write_text(text, encoding="utf-8")


def check_lines(mission: Mission) -> None:
    """Raise InputError where a figure of the plan would have more lines than can be told apart."""
    lines = len(mission.brains) * len(mission.worlds)
    if lines > MOST_LINES:
        raise InputError(
            f"a line a brain, network and density would be {lines} lines, and a figure has {MOST_LINES} at the most: "
            "name fewer of them"
        )


def check_out(path: str | Path, *inputs: Path) -> None:
    """Raise InputError where a plan cannot be written there."""
    if Path(path).suffix not in (".json", ".toml"):
        raise InputError(f"{option('out', str(path)) if in_shell() else path}: a plan is written as .json or .toml")
    check_writable(path, *inputs)
