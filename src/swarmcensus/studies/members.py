"""Mixed swarms: some robots have another brain, other sensors or another speed, or lie."""

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Annotated, Any

from pydantic import Field

from swarmcensus.brains import Adversary, Brain, lying_brain
from swarmcensus.studies.fields import MaybeAccuracies, MaybeBeliefs, MaybeBrainsOrAdversaries, MaybeSpeeds, Name, Sizes
from swarmcensus.support.errors import StudyError
from swarmcensus.support.formatting import counted
from swarmcensus.support.toml_types import TomlTable, usual
from swarmcensus.worlds import Accuracy, Misjudgement

TRAITS = ("brain", "accuracy", "assumed_accuracy", "speed")  # keys in which members may differ from the others


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
    label: str = field(default="", compare=False)  # in place of its traits

    def count(self, robots: int) -> int:
        """Their number in a swarm of `robots`."""
        return round(self.robots * robots) if self.share else int(self.robots)

    def brain_in(self, brain: Brain) -> Brain:
        """Their brain in a swarm with this brain, which an adversary wraps."""
        return lying_brain(self.brain, brain) if isinstance(self.brain, Adversary) else self.brain or brain

    @property
    def traits(self) -> dict[str, str]:
        """How they differ from the others, by key."""
        values = {key: getattr(self, key) for key in TRAITS if getattr(self, key) is not None}
        return {key: v.label if key == "brain" else f"{key.replace('_', ' ')} {v}" for key, v in values.items()}

    @property
    def name(self) -> str:
        """The label, or else how they differ."""
        return self.label or ", ".join(self.traits.values())

    def __str__(self) -> str:
        """Their text in the dataset."""
        many = f"{float(self.robots)!r}" if self.share else str(self.robots)
        return self._said(many, self.honest)

    def _said(self, many: str, honest: bool) -> str:
        return f"{many} {', '.join(filter(None, [self.name, 'not honest' * (not honest)]))}".rstrip()

    @property
    def phrase(self) -> str:
        """Who they are, for titles: `20 % of robots always-black`. Adversaries are not honest in any case."""
        many = f"{100 * self.robots:g} % of robots" if self.share else counted(int(self.robots), "robot")
        return self._said(many, self.honest or isinstance(self.brain, Adversary))

    @property
    def form(self) -> dict[str, object]:
        """As in a study file."""
        given = {key: getattr(self, key) for key in Members.model_fields}
        return {key: value for key, value in given.items() if value not in (None, "")}

    @property
    def content(self) -> tuple[object, ...]:
        """All that a trial's numbers depend on."""
        brain = self.brain and (self.brain.name, self.brain.sha256, [*self.brain.parameters.items()])
        beliefs = (str(one) if one is not None else "" for one in (self.accuracy, self.assumed_accuracy))
        return self.robots, self.share, brain, *beliefs, self.speed, self.honest


class Members(TomlTable):
    """Robots that differ from the others.

    Each key but `honest` and `label` may be a list, which spans the grid.
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
    label: Name | None = None
    """What tables and figures call them."""

    def every(self) -> Iterator[Member]:
        """All members that its lists span."""
        lists: list[list[Any]] = [self.robots, *(getattr(self, key) or [None] for key in TRAITS)]
        varied = {key for key, values in zip(TRAITS, lists[1:], strict=True) if len(values) > 1}
        for robots, *values in itertools.product(*lists):
            given = dict(zip(TRAITS, values, strict=True))
            member = Member(robots, **given, honest=self.honest, share=isinstance(robots, float))
            apart = (text for key, text in member.traits.items() if key in varied)
            yield replace(member, label=", ".join([self.label, *apart])) if self.label else member


def check(members: tuple[Members, ...], brains: list[Brain], sizes: list[int], moves: bool) -> None:
    """Raise StudyError if members do not fit a study's swarms."""
    for n, table in enumerate(members):
        where = f"members[{n}]"
        if table.label and table.label in [before.label for before in members[:n]]:
            raise StudyError.at(f"{where}.label", f'"{table.label}"', "two tables of members have this label")
        if table.label == "plain":
            raise StudyError.at(f"{where}.label", '"plain"', "so are swarms without members called")
        if table.honest and all(getattr(table, key) is None for key in TRAITS):
            give = "give it a brain, an accuracy, an assumed_accuracy, a speed, or honest = false"
            raise StudyError(f"{where} differs in nothing from the others: {give}", key=where)
        if not any(table.robots):
            raise StudyError.at(f"{where}.robots", table.robots[0], "that is nobody, and the table would mean nothing")
        for size in table.robots:
            if size and not Member(size, share=isinstance(size, float)).count(max(sizes)):
                raise StudyError.at(f"{where}.robots", size, f"that is less than one of {counted(max(sizes), 'robot')}")
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
