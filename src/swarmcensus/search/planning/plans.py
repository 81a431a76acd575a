"""Plans: what each brain needs, in words and as a table, and the files in which they are stored."""

import dataclasses
import json
import math
from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from swarmcensus.search.planning.mission import Mission
from swarmcensus.search.planning.predictions import Prediction
from swarmcensus.search.planning.simulating import Curve, Share
from swarmcensus.support.answers import Answer
from swarmcensus.support.errors import InputError
from swarmcensus.support.files import atomic_write, check_output
from swarmcensus.support.formatting import counted
from swarmcensus.support.printed_tables import ASKED, NOTHING, REST, Column, Table
from swarmcensus.support.toml_text import to_toml_value

MOST_LINES = 8  # in a figure
HEADS = {
    "how long": "the shortest time", "how many": "the smallest swarm", "trade-off": "robots against minutes",
    "enough": "whether these are enough",
}  # fmt: skip

Question = Literal["how long", "how many", "trade-off", "enough"]


@dataclass(frozen=True)
class Need:
    """One brain in a swarm of one size, in one world: what it needs, with intervals.

    Ends of intervals are None if no simulated time or size is surely enough, or if the number was given. `theory` is
    the prediction in minutes, which is the answer if nothing was simulated.
    """

    brain: str
    robots: int
    answer: Literal["reached", "not reached", "not simulated"]
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

    @property
    def line(self) -> tuple[str, str, float | None]:
        """The brain and the world, which several sizes of swarms share."""
        return self.brain, self.topology, self.density


def need_of(
    mission: Mission, brain: str, robots: int, minutes: float, rounds: Prediction, curve: Curve | None = None,
    **results: Any,
) -> Need:  # fmt: skip
    """A need with the `results` of simulations, in the case of a curve; without a curve nothing was simulated."""
    if curve is not None:
        lie = None if curve.case.lie is None else curve.case.lie.label
        results |= {"fill_ratio": curve.case.fill_ratio, "lie": lie, "trials": curve.shares.shape[1]}
    return Need(
        brain, robots, minutes=minutes, theory=rounds.minutes(mission), topology=str(mission.free.topology[0]),
        accuracy=str(mission.accuracy), density=mission.density, side=mission.sized(robots).side,
        **{"answer": "not simulated"} | results,
    )  # fmt: skip


@dataclass(repr=False)
class Plan(Answer):
    """A mission's question, and the rows that answer it."""

    question: Question
    mission: Mission
    needs: list[Need]
    text: str  # the mission as TOML

    @property
    def title(self) -> str:  # type: ignore[override]
        """The question, and what is wanted."""
        wanted = f"{100 * self.mission.wanted.confidence:g} % of robots {self.mission.goal}"
        return f"{self.mission.name}: {HEADS[self.question]}; wanted: {wanted}"

    @property
    def sentences(self) -> list[str]:  # type: ignore[override]
        """What each brain needs in each world: of several sizes of swarms, the smallest and the largest."""
        lines = defaultdict(list)
        for need in self.needs:
            lines[need.line].append(need)
        return [self._sentence(need) for needs in lines.values() for need in needs[:: max(len(needs) - 1, 1)]]

    def _sentence(self, need: Need) -> str:
        sizes = f"{counted(need.robots, 'robot')} {_sizes(need)}".strip()
        time = f"{_digits(need.minutes)} minutes {_times(need)}".strip()
        free, who = self.mission.free, need.brain
        who += f" on {need.topology}" * (len(free.topology) > 1)
        who += f" at density {need.density:g}" if need.density is not None and len(free.density or ()) > 1 else ""
        if self.question == "enough":
            share = f": {_percent(need.share.value)} % {_shares(need)} are right" if need.share else ""
            return f"{who}: {sizes} and {time} are {self._verdict(need)}{share}"
        if self._is_late(need):
            return f"{who} needs more than {time} with {sizes}"
        found = f"{sizes} for {time}" if self.question == "how many" else f"{time} with {sizes}"
        return f"{who} needs {found}" + " by theory alone" * (need.answer == "not simulated")

    def _is_late(self, need: Need) -> bool:
        """Whether more time is needed than was simulated."""
        return need.answer == "not reached" and self.question != "enough"

    def _verdict(self, need: Need) -> str:
        if self.question != "enough" or not need.share:
            return {"reached": "", "not reached": "not reached", "not simulated": "theory alone"}[need.answer]
        uncertain = need.share.low < self.mission.wanted.confidence <= need.share.high
        return "not " * (need.answer != "reached") + "enough" + ", but not certain" * uncertain

    @property
    def fields(self) -> dict[str, Any]:  # type: ignore[override]
        """What was asked."""
        return {
            "question": self.question, "goal": str(self.mission.goal), "confidence": self.mission.wanted.confidence,
            "truth": "floor" if any(world.on_floor for world in self.mission.worlds) else "nominal",
            "seed": self.mission.seed, "mission": self.text,
        }  # fmt: skip

    @property
    def rows(self) -> list[dict[str, Any]]:  # type: ignore[override]
        """A row for each need, with the same names for all."""
        return [
            {k: v for k, v in dataclasses.asdict(need).items() if k not in ("share", "theory")}
            | dict(zip(("right", "right_low", "right_high"), need.share or (None, None, None), strict=True))
            | {f"theory_{name}": value for name, value in need.theory._asdict().items()}
            for need in self.needs
        ]

    def tables(self, limit: int) -> list[Table]:
        """One table, with the columns that tell its rows apart."""
        mission, free, known = self.mission, self.mission.free, self.mission.known
        who = "honest, working robots" if known.lying else "robots"
        unreal = [", and nobody lied"] * (known.lying > 0) + [", and no message were lost"] * (known.link_success < 1)

        def column(head: str, cell: Callable[[Need], str], *ends: Callable[[Need], str], **more: Any) -> Column:
            intervals = [end(need) for end in ends for need in self.needs]
            return Column(head, [*map(cell, self.needs)], intervals=intervals, **{"name": head, **more})

        columns = [
            column("brain", lambda need: need.brain, number=False),
            column("topology", lambda need: need.topology, number=False),
            column("density", lambda need: f"{need.density or 0:g}"),
            column("robots", lambda need: f"{need.robots:,}", _sizes),
            column("side, m", lambda need: _digits(need.side), name="side", rank=REST,
                   meaning="of the square that results from the density and the number of robots"),
            column("minutes", lambda need: "> " * self._is_late(need) + _digits(need.minutes), _times, rank=ASKED),
            column("right %", lambda need: _percent(need.share.value) if need.share else NOTHING, _shares,
                   name="right", rank=ASKED,
                   meaning=f"share of {who} that are right at that time, for the worst f of the range"),
            column("f", lambda need: NOTHING if need.fill_ratio is None else f"{need.fill_ratio:g}",
                   name="fill_ratio", rank=REST),
            column("lie", lambda need: need.lie or NOTHING, number=False, rank=REST),
            column("answer", self._verdict, number=False),
            column("theory: all", lambda need: _digits(need.theory.pooled), name="theory_pooled", rank=REST,
                   meaning=f"minutes if every robot knew all readings at once{''.join(unreal)}"),
            column("mixed", lambda need: _digits(need.theory.mixed), name="theory_mixed", rank=REST,
                   meaning="the same if robots mix sums with their neighbours"),
            column("alone", lambda need: _digits(need.theory.alone), name="theory_alone", rank=REST,
                   meaning="the same if robots hear nobody"),
        ]  # fmt: skip
        several = {
            "topology": len(free.topology) > 1, "density": len(free.density or ()) > 1, "side": bool(free.density),
            "lie": len(mission.lies) > 1,
        }  # fmt: skip
        trials = [need.trials for need in self.needs if need.trials] or [0]
        notes = {
            f"[95 %]: over {counted(max(trials), 'trial')}, seed {mission.seed}": max(trials) > 0,
            f"not reached: where this was clear after {counted(min(trials), 'trial')}, no more were run":
            min(trials) < max(trials),
            "theory alone: a simulation would take hours": not all(need.trials for need in self.needs),
        }  # fmt: skip
        shown = [column for column in columns if several.get(column.name, True) and any(column.cells)]
        applying = [note for note, applies in notes.items() if applies]
        return [Table(shown, above=[self._world()], notes=lambda _: applying).first(limit)]

    def _world(self) -> str:
        """The world of the mission, in one line."""
        mission, known, free = self.mission, self.mission.known, self.mission.free
        low, high = known.fill_ratio
        size = f"{mission.side:.4g} m x {mission.side:.4g} m" if mission.side is not None else ""
        if free.density:
            size = f"density {', '.join(f'{density:g}' for density in free.density)}"
        alone = [topology.moves for topology in free.topology] == [True]
        places = [f"{'' if alone else one} {size if one.moves else ''}".strip() for one in free.topology]
        worst = f", the worst of {', '.join(map(str, known.accuracy))}" * (len(known.accuracy) > 1)
        moving = [world for world in mission.worlds if world.moves]
        parts = {
            ", ".join(places): True,
            f"accuracy {self.needs[0].accuracy}{worst}": True,
            f"f = {low:g}" if low == high else f"f from {low:g} to {high:g}": True,
            f"link success {known.link_success:g}": known.link_success < 1.0,
            "single precision": known.precision == "single",
            f"messages in {known.message}": known.message != "double",
            f"{100 * known.failing:g} % of robots fail": known.failing > 0.0,
            f"{100 * known.lying:g} % lie ({', '.join(lie.label for lie in mission.lies)})": known.lying > 0.0,
        }
        text = ", ".join(part for part, applies in parts.items() if applies)
        if not moving:
            return text
        truth = "the floor's own share of black" if moving[0].on_floor else "the nominal f"
        where = " where robots move" if len(moving) < len(mission.worlds) and moving[0].on_floor else ""
        return f"{text}; the truth is {truth}{where}"

    def write(self, path: str | Path) -> None:
        """Write the plan as .json or .toml, whole or not at all. Raises InputError."""
        check_output("out", path, (".json", ".toml"))
        rows = [
            {k: v for k, v in dataclasses.asdict(need).items() if v is not None} | {"theory": need.theory._asdict()}
            for need in self.needs
        ]
        text = json.dumps(self.fields | {"rows": rows}, indent=1, allow_nan=False)
        if Path(path).suffix.lower() == ".toml":
            parts = [_toml(self.fields), *(f"[[rows]]\n{_toml(row)}" for row in rows)]
            text = "\n\n".join(parts)
        with atomic_write(path) as temporary:
            temporary.write_text(f"{text}\n", encoding="utf-8")


def _toml(table: dict[str, Any]) -> str:
    return "\n".join(f"{key} = {to_toml_value(value)}" for key, value in table.items())


def _sizes(need: Need) -> str:
    return _ends(need.robots_low, need.robots_high, "{:,}".format)


def _times(need: Need) -> str:
    return _ends(need.minutes_low, need.minutes_high, _digits)


def _shares(need: Need) -> str:
    return _ends(*need.share[1:], _percent) if need.share else ""


def _ends(low: Any, high: Any, form: Callable[[Any], str]) -> str:
    """The ends of an interval; empty if nothing is known of it."""
    return "" if low is None else f"[{form(low)}, {'more' if high is None else form(high)}]"


def _percent(share: float) -> str:
    return f"{100.0 * share:.1f}"


def _digits(value: float | None) -> str:
    """A number in three digits, or more if there are more before the point."""
    if value is None:
        return NOTHING
    if value >= 100.0 or not math.isfinite(value):
        return f"{value:,.0f}"
    return f"{value:.{max(0, 2 - math.floor(math.log10(value)))}f}" if value > 0.0 else "0"


def check_lines(mission: Mission) -> None:
    """Raise InputError if a figure of the plan would have more lines than a reader can distinguish."""
    lines = len(mission.brains) * len(mission.worlds)
    if lines > MOST_LINES:
        raise InputError(
            f"a line for each brain, network and density would be {lines} lines, and a figure has at most "
            f"{MOST_LINES}: name fewer of them"
        )
