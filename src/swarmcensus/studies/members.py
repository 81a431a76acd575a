"""Mixed swarms: some robots have another brain, other sensors or another speed, or lie."""

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import Field

from swarmcensus.brains import Adversary, Brain, lying_brain
from swarmcensus.studies.fields import (
    MaybeAccuracies,
    MaybeBeliefs,
    MaybeBrainsOrAdversaries,
    MaybeSpeeds,
    Sizes,
)
from swarmcensus.support.errors import StudyError
from swarmcensus.support.formatting import counted
from swarmcensus.support.toml_types import TomlTable, usual
from swarmcensus.worlds import Accuracy, Misjudgement


@dataclass(frozen=True)
class Member:
    """Some robots of a swarm, and how they differ from the others; None: they do not."""

    robots: int | float  # a number, or a fraction
    brain: Brain | Adversary | None = None
    accuracy: Accuracy | None = None
    assumed_accuracy: Accuracy | Misjudgement | None = None
    speed: float | None = None  # m/s, of robots that move
    honest: bool = True  # whether metrics count them
    share: bool = False  # whether `robots` is a fraction: 1.0 is all of them, 1 is one

    def count(self, robots: int) -> int:
        """Their number in a swarm of `robots`."""
        return round(self.robots * robots) if self.share else int(self.robots)

    def brain_in(self, brain: Brain) -> Brain:
        """Their brain in a swarm with this brain, which an adversary wraps."""
        return lying_brain(self.brain, brain) if isinstance(self.brain, Adversary) else self.brain or brain

    @property
    def traits(self) -> list[str]:
        """How they differ from the others."""
        sides = {"accuracy": self.accuracy, "assumed accuracy": self.assumed_accuracy, "speed": self.speed}
        own_brain = [self.brain.label] if self.brain is not None else []
        return own_brain + [f"{what} {value}" for what, value in sides.items() if value is not None]

    def __str__(self) -> str:
        """Their text in the dataset."""
        many = f"{float(self.robots)!r}" if self.share else str(self.robots)
        return " ".join([many, ", ".join(self.traits + ["not honest"] * (not self.honest))]).rstrip()

    @property
    def phrase(self) -> str:
        """Who they are, for titles: `20 % of robots always-black`. Adversaries are not honest in any case."""
        many = f"{100 * self.robots:g} % of robots" if self.share else counted(int(self.robots), "robot")
        lies = [] if self.honest or isinstance(self.brain, Adversary) else ["not honest"]
        return f"{many} {', '.join(self.traits + lies)}".rstrip()

    @property
    def form(self) -> dict[str, object]:
        """As in a study file."""
        given = {key: getattr(self, key) for key in Members.model_fields}
        return {key: value for key, value in given.items() if value is not None}

    @property
    def content(self) -> tuple[object, ...]:
        """All that a trial's numbers depend on."""
        brain = self.brain and (self.brain.name, self.brain.sha256, [*self.brain.parameters.items()])
        beliefs = (str(one) if one is not None else "" for one in (self.accuracy, self.assumed_accuracy))
        return self.robots, self.share, brain, *beliefs, self.speed, self.honest


class Members(TomlTable):
    """Robots that differ from the others.

    Each key but `honest` may be a list, which spans the grid.
    """

    robots: Sizes
    """How many: a number, or a fraction of the swarm."""
    brain: MaybeBrainsOrAdversaries = usual(None)
    """Their brain, or an adversary."""
    accuracy: MaybeAccuracies = usual(None)
    """The true b and w of their sensors."""
    assumed_accuracy: MaybeBeliefs = usual(None)
    """The b and w that they assume."""
    speed: MaybeSpeeds = usual(None)
    """How fast they move, in m/s."""
    honest: Annotated[bool, Field(strict=True)] = True
    """Whether metrics count them."""

    def every(self) -> Iterator[Member]:
        """All members that its lists span."""
        lists: list[list[Any]] = [
            self.robots, *(v or [None] for v in (self.brain, self.accuracy, self.assumed_accuracy, self.speed))
        ]  # fmt: skip
        for robots, brain, accuracy, assumed, speed in itertools.product(*lists):
            yield Member(robots, brain, accuracy, assumed, speed, self.honest, isinstance(robots, float))


def check(members: tuple[Members, ...], brains: list[Brain], sizes: list[int], moves: bool) -> None:
    """Raise StudyError if members do not fit a study's swarms."""
    for n, table in enumerate(members):
        where = f"members[{n}]"
        if table.honest and all(v is None for v in (table.brain, table.accuracy, table.assumed_accuracy, table.speed)):
            give = "give it a brain, an accuracy, an assumed_accuracy, a speed, or honest = false"
            raise StudyError(f"{where} differs in nothing from the others: {give}", key=where)
        if not any(table.robots):
            nobody = "that is nobody, and the table would mean nothing"
            raise StudyError.at(f"{where}.robots", table.robots[0], nobody)
        for size in table.robots:
            if size and not Member(size, share=isinstance(size, float)).count(max(sizes)):
                less = f"that is less than one of {counted(max(sizes), 'robot')}"
                raise StudyError.at(f"{where}.robots", size, less)
        if table.speed is not None and not moves:
            moving = 'is of robots that move: it goes with topology = "moving"'
            raise StudyError(f"{where}.speed {moving}", key=f"{where}.speed")
        hearing = [brain for brain in brains if not brain.is_oracle]  # an oracle hears no member
        for adversary in (a for a in table.brain or [] if isinstance(a, Adversary)):
            _check_adversary(where, table, adversary, hearing)
        for brain in dict.fromkeys(b for b in table.brain or [] if isinstance(b, Brain)):
            theirs = (b for before in members[:n] for b in before.brain or [] if isinstance(b, Brain))
            for other in (*hearing, *theirs):
                place, name = f"{where}.brain", repr(brain.name)
                same = "brains of one swarm have the same"
                if brain.message != other.message:
                    both = f"({_message_text(brain)}), and that of {other.name!r} ({_message_text(other)})"
                    raise StudyError.at(place, name, f"its MESSAGE is {both}: {same} MESSAGE")
                if brain.decides and other.decides and brain.options != other.options:
                    both = f"{brain.options}, and that of {other.name!r} {other.options}"
                    raise StudyError.at(place, name, f"its OPTIONS is {both}: {same} OPTIONS")
    for robots in sizes:
        for chosen in itertools.product(*(table.robots for table in members)):
            counts = [Member(size, share=isinstance(size, float)).count(robots) for size in chosen]
            if sum(counts) > robots:
                sizes_given = " and ".join(f"members[{n}].robots = {size:g}" for n, size in enumerate(chosen))
                raise StudyError.within(sizes_given, f"that is {sum(counts)} of {counted(robots, 'robot')}", "members")
            honest = robots - sum(c for c, table in zip(counts, members, strict=True) if not table.honest)
            if honest < 1:
                nobody = f"members: of {counted(robots, 'robot')} none is honest, and metrics count the honest ones"
                raise StudyError(nobody, key="members")


def _check_adversary(where: str, table: Members, adversary: Adversary, brains: list[Brain]) -> None:
    place, name = f"{where}.brain", repr(adversary.label)
    if table.honest:
        raise StudyError.at(place, name, "that is an adversary, which is not honest: add honest = false")
    for brain in brains:
        try:
            lying_brain(adversary, brain)
        except ValueError as error:
            raise StudyError.at(place, name, error) from None


def _message_text(brain: Brain) -> str:
    return ", ".join(name if not long else f"{name} of {long}" for name, long in brain.message.items())
