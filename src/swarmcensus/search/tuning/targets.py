"""What a search is for: a brain of the study, or an adversary of its members and the brain that it is to harm."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

from swarmcensus.brains import PLAIN, Adversary, Brain
from swarmcensus.studies import Setting, Study
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.options import wrong_option

One = TypeVar("One", Brain, Adversary)


@dataclass(frozen=True)
class Target:
    """The program that is searched, with the parameters that the study gives first, and whom it concerns."""

    program: Brain | Adversary
    brain: Brain  # the program itself, or the brain that the adversary is to harm
    table: int | None = None  # the table of members that has the adversary

    @property
    def harms(self) -> bool:
        """Whether the search is for the most harm: that an adversary does."""
        return self.table is not None

    def worlds(self, study: Study) -> list[Setting]:
        """The study's settings with this brain, and with this adversary if one is searched, each once."""
        own = (s for s in study.settings() if s.brain.with_numbers(PLAIN).as_written == self.brain.as_written)
        worlds = (world_with(s, self.program) for s in own if not self.harms or _lies_in(s, self.program))
        return list(dict.fromkeys(worlds))


def world_with(world: Setting, program: Brain | Adversary) -> Setting:
    """A world with this brain, in its number formats, or with this adversary in place of the same with other values."""
    if isinstance(program, Brain):
        return replace(world, brain=program.with_numbers(world.brain.numbers))
    members = (replace(m, brain=program) if _is_same(m.brain, program) else m for m in world.members)
    return replace(world, members=tuple(members))


def _is_same(program: Brain | Adversary | None, other: Brain | Adversary) -> bool:
    """Whether both are of the same file, with whatever parameters."""
    return program is not None and program.as_written == other.as_written


def _lies_in(setting: Setting, liar: Brain | Adversary) -> bool:
    return any(_is_same(member.brain, liar) for member in setting.members)


def target_of(study: Study, brain: str | None, adversary: str | None) -> Target:
    """The target that these names mean in the study. Raises InputError, naming what the study has."""
    if adversary is None:
        brains = _brains_of(study.settings())
        names = ", ".join(dict.fromkeys(each.name for each in brains))
        none = f"no brain of the study ({names}) has PARAMETERS to search"
        tunable = [each for each in brains if each.parameters]
        tuned = _only_brain(brain, brains, tunable, "have parameters", none, "it has no PARAMETERS to search")
        return Target(tuned, tuned)
    program, table = _adversary_to_search(study, adversary)
    brains = _brains_of(s for s in study.settings() if _lies_in(s, program))
    hearing, none = [each for each in brains if not each.is_oracle], "no brain of the study hears it"
    harmed = _only_brain(brain, brains, hearing, "hear it", none, "an oracle hears no liars")
    return Target(program, harmed, table)


def _only_brain(
    name: str | None, brains: Sequence[Brain], suitable: Sequence[Brain], what: str, none: str, unsuitable: str
) -> Brain:
    """The first brain with this name, or the only suitable one if `name` is None. Raises InputError."""
    names = list(dict.fromkeys(brain.name for brain in suitable))
    if name is None and len(names) != 1:
        raise wrong_option("brain", None, f"several brains {what}, {', '.join(names)}: name one" if names else none)
    brain = _named("brain", names[0] if name is None else name, brains)
    if brain not in suitable:
        raise wrong_option("brain", brain.name, unsuitable)
    return brain


def _adversary_to_search(study: Study, name: str) -> tuple[Adversary, int]:
    """The first adversary with this name in the study's members, and its table."""
    places = [(one, n) for n, table in enumerate(study.members) for one in table.brain or ()]
    liars = {one: n for one, n in reversed(places) if isinstance(one, Adversary)}
    if not liars:
        raise wrong_option(
            "adversary", name, "the study has no adversary: name it in a table of [[members]], with honest = false"
        )
    liar = _named("adversary", name, [*reversed(liars)])
    if not liar.parameters:
        raise wrong_option("adversary", name, "it has no PARAMETERS to search")
    if len(tables := sorted({n for one, n in places if _is_same(one, liar)})) > 1:
        raise wrong_option("adversary", name, f"members {tables} have it, and a search is of one table: leave one out")
    return liar, tables[0]


def _brains_of(settings: Iterable[Setting]) -> list[Brain]:
    return list(dict.fromkeys(setting.brain.with_numbers(PLAIN) for setting in settings))


def _named(kind: str, name: str, programs: Sequence[One]) -> One:
    """The first of these programs with this name. Raises InputError if there is none."""
    for program in programs:
        if program.name == name:
            return program
    names = list(dict.fromkeys(program.name for program in programs))
    raise wrong_option(kind, name, f"{did_you_mean(name, names)}the study has {', '.join(names)}")
