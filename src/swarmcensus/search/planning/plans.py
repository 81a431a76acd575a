"""Plans: a row for each brain and size, and the files in which they are stored."""

import dataclasses
import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

from swarmcensus.search.planning.mission import Mission
from swarmcensus.search.planning.predictions import Prediction
from swarmcensus.search.planning.simulating import Curve, Share
from swarmcensus.studies import to_toml_value
from swarmcensus.support.errors import InputError
from swarmcensus.support.files import atomic_write, check_output

MOST_LINES = 8  # in a figure

Question = Literal["how long", "how many", "trade-off", "enough"]
Answer = Literal["reached", "not reached", "not simulated"]


@dataclass(frozen=True)
class Row:
    """One brain in a swarm of one size, in one world: what it needs, with intervals.

    Ends of intervals are None if no simulated time or size is surely enough, or if the number was given. `theory` is
    the prediction in minutes, which is the answer if nothing was simulated.
    """

    brain: str
    robots: int
    answer: Answer
    minutes: float
    theory: Prediction
    topology: str
    accuracy: str  # that is planned for
    density: float | None = None  # swarm density, if the mission gives it
    side: float | None = None  # of the area in metres, if robots move
    robots_low: int | None = None
    robots_high: int | None = None
    minutes_low: float | None = None
    minutes_high: float | None = None
    share: Share | None = None
    fill_ratio: float | None = None  # the worst of the range
    lie: str | None = None  # the worst of the adversaries
    trials: int = 0


def row_of(mission: Mission, brain: str, robots: int, minutes: float, theory: Prediction) -> Row:
    """A row of which nothing has been simulated yet."""
    return Row(
        brain, robots, "not simulated", minutes, theory, str(mission.free.topology[0]), str(mission.accuracy),
        density=mission.density, side=mission.sized(robots).side,
    )  # fmt: skip


def with_case(row: Row, curve: Curve) -> Row:
    """The row with the case and the number of trials of a curve."""
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
        """The plan as plain data."""
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

    @property
    def records(self) -> list[dict[str, Any]]:
        """A flat record for each row, with the same names for all."""
        return [
            {k: v for k, v in dataclasses.asdict(row).items() if k not in ("share", "theory")}
            | dict(zip(("right", "right_low", "right_high"), row.share or (None, None, None), strict=True))
            | {f"theory_{name}": value for name, value in row.theory._asdict().items()}
            for row in self.rows
        ]

    def save(self, path: str | Path) -> None:
        """Write the plan as .json or .toml, whole or not at all. Raises InputError."""
        check_out(path)
        data = self.data
        if Path(path).suffix.lower() == ".json":
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
    """Raise InputError if a figure of the plan would have more lines than a reader can distinguish."""
    lines = len(mission.brains) * len(mission.worlds)
    if lines > MOST_LINES:
        raise InputError(
            f"a line for each brain, network and density would be {lines} lines, and a figure has at most "
            f"{MOST_LINES}: name fewer of them"
        )


def check_out(path: str | Path, *inputs: Path) -> None:
    """Raise InputError if a plan cannot be written there."""
    check_output("out", path, (".json", ".toml"), *inputs)
