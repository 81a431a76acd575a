"""Plans: what each brain needs, in words and as a table, and the files in which they are stored."""

import dataclasses
import math
from collections import defaultdict
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

from swarmcensus.search.planning.mission import Mission
from swarmcensus.search.planning.predictions import Prediction
from swarmcensus.search.planning.simulating import Curve
from swarmcensus.simulation import sampling
from swarmcensus.studies import Study, to_text, with_values
from swarmcensus.support.answers import Answer
from swarmcensus.support.files import atomic_write, check_output
from swarmcensus.support.formatting import counted, decimals_for
from swarmcensus.support.intervals import Estimate
from swarmcensus.support.printed_tables import ASKED, NOTHING, REST, Column, Table
from swarmcensus.support.toml_text import to_toml

DRAWN, MOST_DRAWN = 200, 1000  # trials and robots with beliefs that represent others
HEADS = {
    "how long": "the shortest time", "how many": "the smallest swarm", "trade-off": "robots against minutes",
    "enough": "whether these are enough",
}  # fmt: skip

Question = Literal["how long", "how many", "trade-off", "enough"]


@dataclass(frozen=True)
class Need:
    """One brain in a swarm of one size, in one world: what it needs, with intervals.

    Ends of intervals are None if no simulated time or size is surely enough, or if the number was given. `theory` is
    the prediction in minutes.
    """

    brain: str
    robots: int
    answer: Literal["reached", "not reached"]
    minutes: float
    theory: Prediction
    topology: str
    accuracy: str  # that is planned for
    fill_ratio: float  # the worst of the range
    trials: int
    share: Estimate  # of right robots
    world: Mapping[str, str] = field(default_factory=dict)  # the values of keys in which the mission's worlds differ
    density: float | None = None  # swarm density, if the mission gives it
    side: float | None = None  # of the area in metres, if robots move
    robots_low: int | None = None
    robots_high: int | None = None
    minutes_low: float | None = None
    minutes_high: float | None = None
    calibration: float | None = None  # the error that wrong beliefs about b and w add; None if robots know b and w
    lie: str | None = None  # the worst of the adversaries

    @property
    def place(self) -> str:
        """What sets its world apart from others, in words."""
        said = {"topology": "{}", "density": "D = {}"}
        return ", ".join(
            said.get(key, f"{key} {{}}").format(value) for key, value in self.world.items() if key != "robots"
        )

    @property
    def line(self) -> tuple[str, str]:
        """The brain and the world, which several sizes of swarms share."""
        return self.brain, self.place


def need_of(
    mission: Mission, brain: str, robots: int, minutes: float, rounds: Prediction, curve: Curve, **results: Any
) -> Need:
    """A need with the `results` of simulations, in the case of a curve."""
    f, lie = curve.case
    setting = replace(mission.setting, accuracy=mission.accuracy, fill_ratio=f, robots=min(robots, MOST_DRAWN))
    added = sampling.belief_error(setting, mission.study.seed, 0, DRAWN)
    return Need(
        brain, robots, minutes=minutes, theory=rounds.minutes(mission), topology=mission.setting.topology.title,
        accuracy=str(mission.accuracy), world=mission.world, density=mission.density, side=mission.sized(robots).side,
        calibration=None if math.isnan(added) else added, fill_ratio=f, lie=None if lie is None else lie.label,
        trials=curve.shares.shape[1], **results,
    )  # fmt: skip


@dataclass(repr=False)
class Plan(Answer):
    """The question of missions, one for each world, and the rows that answer it."""

    question: Question
    missions: list[Mission]
    needs: list[Need]

    @property
    def mission(self) -> Mission:
        """The mission of the first world."""
        return self.missions[0]

    @property
    def title(self) -> str:  # type: ignore[override]
        """The question, and what is wanted."""
        wanted = f"{100 * self.mission.wanted.probability:g} % of robots {self.mission.goal}"
        return f"{self.mission.study.name}: {HEADS[self.question]}; wanted: {wanted}"

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
        who = f"{need.brain} ({need.place})" if need.place else need.brain
        if self.question == "enough":
            share = f"{_percent(need.share.value)} % {_shares(need)} are right"
            return f"{who}: {sizes} and {time} are {self._verdict(need)}: {share}"
        if self._is_late(need):
            return f"{who} needs more than {time} with {sizes}"
        found = f"{sizes} for {time}" if self.question == "how many" else f"{time} with {sizes}"
        return f"{who} needs {found}"

    def _is_late(self, need: Need) -> bool:
        """Whether more time is needed than was simulated."""
        return need.answer == "not reached" and self.question != "enough"

    def _verdict(self, need: Need) -> str:
        if self.question != "enough":
            return need.answer if need.answer == "not reached" else ""
        uncertain = need.share.low < self.mission.wanted.probability <= need.share.high
        return "not " * (need.answer != "reached") + "enough" + ", but not certain" * uncertain

    @property
    def fields(self) -> dict[str, Any]:  # type: ignore[override]
        """What was asked."""
        mission = self.mission
        return {
            "question": self.question, "goal": str(mission.goal), "probability": mission.wanted.probability,
            "truth": "floor" if any(one.on_floor for one in self.missions) else "nominal",
            "seed": mission.study.seed, "mission": to_toml(mission.tables),
        }  # fmt: skip

    @property
    def rows(self) -> list[dict[str, Any]]:  # type: ignore[override]
        """A row for each need, with the same names for all."""
        return [
            {k: v for k, v in dataclasses.asdict(need).items() if k not in ("share", "theory", "world")}
            | {k: v for k, v in need.world.items() if k not in ("topology", "density", "robots")}
            | dict(zip(("right", "right_low", "right_high"), need.share, strict=True))
            | {f"theory_{name}": value for name, value in need.theory._asdict().items()}
            for need in self.needs
        ]

    def tables(self, limit: int) -> list[Table]:
        """One table, with the columns that tell its rows apart."""
        mission, lying = self.mission, self.mission.has_liars
        who = "honest, working robots" if lying else "robots"
        unreal = [", and nobody lied"] * lying + [", and no message were lost"] * (mission.setting.link_success < 1)

        def column(head: str, cell: Callable[[Need], str], *ends: Callable[[Need], str], **more: Any) -> Column:
            intervals = [end(need) for end in ends for need in self.needs]
            return Column(head, [*map(cell, self.needs)], intervals=intervals, **{"name": head, **more})

        columns = [
            column("brain", lambda need: need.brain, number=False),
            *(
                Column(key.replace("_", " "), [need.world[key] for need in self.needs], number=False, name=key)
                for key in mission.world
                if key != "robots"
            ),
            column("robots", lambda need: f"{need.robots:,}", _sizes),
            column("side, m", lambda need: _digits(need.side), name="side", rank=REST,
                   meaning="of the square that results from the density and the number of robots"),
            column("minutes", lambda need: "> " * self._is_late(need) + _digits(need.minutes), _times, rank=ASKED),
            column("right %", lambda need: _percent(need.share.value), _shares,
                   name="right", rank=ASKED,
                   meaning=f"share of {who} that are right at that time, for the worst f of the range"),
            column("f", lambda need: f"{need.fill_ratio:g}", name="fill_ratio", rank=REST),
            column("calibration", lambda need: _digits(need.calibration), rank=REST,
                   meaning="error that wrong beliefs about b and w add to the estimate from all readings"),
            column("lie", lambda need: need.lie or NOTHING, number=False, rank=REST),
            column("answer", self._verdict, number=False),
            column("theory: all", lambda need: _digits(need.theory.pooled), name="theory_pooled", rank=REST,
                   meaning=f"minutes if every robot knew all readings at once{''.join(unreal)}"),
            column("mixed", lambda need: _digits(need.theory.mixed), name="theory_mixed", rank=REST,
                   meaning="the same if robots mix sums with their neighbours"),
            column("alone", lambda need: _digits(need.theory.alone), name="theory_alone", rank=REST,
                   meaning="the same if robots hear nobody"),
        ]  # fmt: skip
        several = {"side": mission.density is not None, "lie": len(mission.lies) > 1}
        trials = [need.trials for need in self.needs]
        notes = [f"simulated in {counted(max(trials), 'trial')}, seed {mission.study.seed}"]
        if min(trials) < max(trials):
            notes.append(f"not reached: where this was clear after {min(trials)} trials, no more were run")
        shown = [column for column in columns if several.get(column.name, True) and any(column.cells)]
        return [Table(shown, above=[self._world()], notes=lambda _: notes).first(limit)]

    def _world(self) -> str:
        """The world of the mission, in one line, without what rows say."""
        mission, others = self.mission, self.mission.accuracies[1:]
        low, high = mission.fill_ratios
        worst = f", the worst of {', '.join(map(str, others))}" * bool(others)
        tables = (mission.tables[name] for name in ("world", "swarm", "measure"))
        said = {key: to_text(value) for table in tables for key, value in table.items()}
        said |= {"topology": mission.setting.topology.title, "accuracy": f"{mission.accuracy}{worst}"}
        said["fill_ratio"] = f"{low:g} to {high:g}" if low < high else f"{low:g}"
        parts = [f"{key} {text}" for key, text in said.items() if key not in ("brain", "robots", *mission.world)]
        if len(mission.lies) > 1:
            parts.append(f"liars are the worst of {', '.join(lie.label for lie in mission.lies)}")
        else:
            parts += [member.phrase for member in mission.setting.members]
        return ", ".join(parts + [counted(len(mission.study.faults), "fault")] * bool(mission.study.faults))

    @property
    def best(self) -> Need:
        """The need that takes least: of those that reach the goal, the shortest time, or the smallest swarm."""
        reached = [need for need in self.needs if need.answer == "reached"] or self.needs

        def size(need: Need) -> float:
            return need.robots if self.question == "how many" else need.minutes

        return min(reached, key=size)

    def study(self, base: Path | None = None) -> str:
        """The text of a study file that runs the best need, with other random numbers, and measures `reached`.

        It lasts until the upper end of the time's interval, or has the upper end of the number of robots, where these
        are known. Raises InputError if the study cannot be read in the folder `base`.
        """
        best = self.best
        mission = next(one for one in self.missions if one.world == best.world)
        brain = next(one for one in mission.study.swarm.brain if one.label == best.brain)
        length = "ticks" if mission.moves else "rounds"
        robots, rounds = best.robots_high or best.robots, mission.rounds(best.minutes_high or best.minutes)
        values = {
            "seed": mission.study.seed + 1, "swarm.robots": robots, "swarm.brain": brain, f"schedule.{length}": rounds,
            "swarm.accuracy": mission.accuracy,
            "world.fill_ratio": best.fill_ratio,
        }  # fmt: skip
        tables = {name: table for name, table in mission.tables.items() if table}
        tables["wanted"] = tables["wanted"] | {"minutes": rounds * mission.round_minutes}
        if mission.liars is not None:
            tables["members"] = [dict(table) for table in tables["members"]]
            lie = next(one for one in mission.lies if one.label == best.lie)
            tables["members"][mission.liars]["brain"] = lie
        about = f"# As planned: {self._sentence(best)}. Run it: reached is the share of robots {mission.goal}.\n"
        text = about + to_toml(with_values(tables, values))
        Study.parse(text, where="the planned study", context={"base": base or Path(), "warned": True})
        return text

    def write(self, path: str | Path) -> None:
        """Write the planned study, whole or not at all. Raises InputError."""
        check_output("out", path, (".toml",))
        text = self.study(Path(path).parent)
        with atomic_write(path) as temporary:
            temporary.write_text(text, encoding="utf-8")


def _sizes(need: Need) -> str:
    return _ends(need.robots_low, need.robots_high, "{:,}".format)


def _times(need: Need) -> str:
    return _ends(need.minutes_low, need.minutes_high, _digits)


def _shares(need: Need) -> str:
    return _ends(*need.share[1:], _percent)


def _ends(low: Any, high: Any, form: Callable[[Any], str]) -> str:
    """The ends of an interval; empty if nothing is known of it."""
    return "" if low is None else f"[{form(low)}, {'more' if high is None else form(high)}]"


def _percent(share: float) -> str:
    return f"{100.0 * share:.1f}"


def _digits(value: float | None) -> str:
    """A number in three digits, or more if there are more before the point."""
    if value is None:
        return NOTHING
    return f"{value:,.{decimals_for(value, 3)}f}" if value else "0"
