"""What robots should know at the end of a run, and values that a plan finds: `{choose = ...}` and `{worst = ...}`."""

from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from swarmcensus.studies.settings import Setting
from swarmcensus.support.errors import StudyError
from swarmcensus.support.options import command
from swarmcensus.support.toml_text import to_toml_value
from swarmcensus.support.toml_types import Number, TomlTable, says, usual
from swarmcensus.worlds import Body, Positive

MOST_BINS = 10_000
OPEN = {  # the keys that a plan may find, and how
    "choose": ("swarm.robots", "wanted.minutes"), "worst": ("swarm.accuracy", "world.fill_ratio", "members.brain"),
}  # fmt: skip
FINDS = {"choose": "finds a value between these", "worst": "finds the worst of these"}
Right = Annotated[
    Literal["majority"] | Annotated[int, Field(strict=True, ge=2, le=MOST_BINS)],
    says(f'should be "majority", or a number of bins from 2 to {MOST_BINS:,}', "majority"),
]


class Wanted(TomlTable):
    """What robots should know at the end, which `reached` measures and `plan` plans for; no numbers depend on it."""

    error: Annotated[Number, Field(gt=0.0, lt=0.5)] | None = usual(None)
    """The largest allowed distance of an estimate from the truth."""
    right: Right | None = usual(None)
    """Or "majority", or a number of bins: an estimate should be in the right one."""
    margin: Annotated[Number, Field(ge=0.0, lt=0.5)] = 0.0
    """The least distance of f from the edges between these bins, in plans."""
    probability: Annotated[Number, Field(ge=0.5, le=0.999)] = 0.95
    """The share of robots, over all trials, that should know it."""
    who: Literal["working", "all"] = "working"
    """Which honest robots count: those that still observe at the end, or all."""
    minutes: Positive | None = usual(None)
    """By when; without it, a plan finds the time."""
    round_seconds: Positive | None = usual(None)
    """The seconds of a round on fixed networks; by default 0.1 for each observation."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.error is not None and self.right is not None:
            raise ValueError("should have an error or right, and not both")
        if self.error is None and self.right is None and self.model_fields_set:
            raise ValueError('should have an error, such as 0.02, or right, such as "majority" or 10 bins')
        if self.margin and self.right is None:
            raise ValueError(f"margin = {self.margin:g}: it goes with right, because an error has no edges")
        return self

    @property
    def bins(self) -> int | None:
        """The number of bins, if an estimate should be in the right one."""
        return 2 if self.right == "majority" else self.right

    @property
    def goal(self) -> float | None:
        """The largest error, which is below one half, or the number of bins; None if nothing is wanted."""
        return self.error if self.error is not None else self.bins

    def round_minutes(self, setting: Setting) -> float:
        """The minutes of a round of a setting: a tick where robots move."""
        tick = (setting.body or Body()).tick
        fixed = self.round_seconds or setting.observations_per_round * tick
        return (tick if setting.body else fixed) / 60.0

    def check_time(self, setting: Setting) -> None:
        """Raise StudyError unless the setting lasts as long as robots have."""
        rounds = None if self.minutes is None else int(self.minutes / self.round_minutes(setting) + 1e-9)
        if rounds not in (None, setting.rounds):
            key = "ticks" if setting.body else "rounds"
            last = f"that is {rounds:,} {key}, and a trial has {setting.rounds:,}: set schedule.{key} = {rounds}"
            raise StudyError.at("wanted.minutes", f"{self.minutes:g}", last)


def open_values(tables: Mapping[str, Any]) -> dict[tuple[str | int, ...], tuple[str, Any]]:
    """The values of a study's tables that a plan finds: their places, each with "choose" or "worst" and the values."""
    found: dict[tuple[str | int, ...], tuple[str, Any]] = {}
    for name, table in tables.items():
        several = table if isinstance(table, list) else [table]
        for n, entries in enumerate(several):
            above = (name, n) if isinstance(table, list) else (name,)
            for key, value in entries.items() if isinstance(entries, Mapping) else ():
                if isinstance(value, Mapping) and len(value) == 1 and {*value} <= {*OPEN}:
                    found[*above, key] = next(iter(value.items()))
    return found


def key_of(place: tuple[str | int, ...]) -> str:
    """A place in messages: "swarm.robots", "members[0].brain"."""
    return f"{place[0]}[{place[1]}].{place[2]}" if len(place) > 2 else ".".join(map(str, place))


def check_open(tables: Mapping[str, Any], where: str) -> None:
    """Raise StudyError if a value is one that a plan finds."""
    for place, (word, values) in open_values(tables).items():
        key, file = key_of(place), (where.partition(" file ")[2] or where).partition(" with ")[0]
        finds = command("swarmcensus", "plan", file if file.endswith(".toml") else "STUDY.toml") + f" {FINDS[word]}; "
        if f"{place[0]}.{place[-1]}" not in OPEN[word]:
            finds = f"only {', '.join(OPEN[word])} may have {word}; "
        given = f"{key} = {to_toml_value({word: values})}"
        raise StudyError.within(where, f"{given}: {finds}a run takes one value, or a list of several", key, values)
