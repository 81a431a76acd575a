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
        return list(dict.fromkeys(world_with(s, self.program) for s in own if not self.harms or self.lies_in(s)))

    def lies_in(self, setting: Setting) -> bool:
        """Whether the adversary, with whatever parameters, is in this setting."""
        return any(_has(member.brain, self.program) for member in setting.members)


def world_with(world: Setting, program: Brain | Adversary) -> Setting:
    """A world with this brain, in its number formats, or with this adversary in place of the same with other values."""
    if isinstance(program, Brain):
        return replace(world, brain=program.with_numbers(world.brain.numbers))
    members = (replace(m, brain=program) if _has(m.brain, program) else m for m in world.members)
    return replace(world, members=tuple(members))


def _has(one: Brain | Adversary | None, program: Brain | Adversary) -> bool:
    """Whether both are the same file."""
    return one is not None and one.as_written == program.as_written


def target_of(study: Study, brain: str | None, adversary: str | None) -> Target:
    """The target that these names mean in the study. Raises InputError, naming what the study has."""
    if adversary is None:
        tuned = _brain_to_tune(study, brain)
        return Target(tuned, tuned)
    program, table = _adversary_to_search(study, adversary)
    return Target(program, _brain_to_harm(study, brain, program), table)


def _brain_to_tune(study: Study, name: str | None) -> Brain:
    """The first brain with this name in the study, or the only brain with parameters if `name` is None."""
    brains = _brains_of(study.settings())
    tunable = list(dict.fromkeys(brain.name for brain in brains if brain.parameters))
    if name is None:
        if len(tunable) != 1:
            problem = f"several brains have parameters, {', '.join(tunable)}: name one" if tunable else _none(brains)
            raise wrong_option("brain", None, f"{problem}")
        name = tunable[0]
    brain = _named("brain", name, brains)
    if not brain.parameters:
        raise wrong_option("brain", name, "it has no PARAMETERS to search")
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
    tables = sorted({n for one, n in places if _has(one, liar)})
    if len(tables) > 1:
        several = " and ".join(f"members[{n}]" for n in tables)
        raise wrong_option("adversary", name, f"{several} have it, and a search is of one table: leave one out")
    return liar, tables[0]


def _brain_to_harm(study: Study, name: str | None, liar: Adversary) -> Brain:
    """The brain of this name that hears the liar, or the only one that does if `name` is None."""
    brains = _brains_of(s for s in study.settings() if any(_has(m.brain, liar) for m in s.members))
    hearing = [brain for brain in brains if not brain.is_oracle]
    names = list(dict.fromkeys(brain.name for brain in hearing))
    if name is None:
        if len(names) != 1:
            heard = (
                f"several brains hear it, {', '.join(names)}: name one" if names else "no brain of the study hears it"
            )
            raise wrong_option("brain", None, f"{heard}")
        name = names[0]
    brain = _named("brain", name, brains)
    if brain.is_oracle:
        raise wrong_option("brain", name, "an oracle hears no liars")
    return brain


def _brains_of(settings: Iterable[Setting]) -> list[Brain]:
    return list(dict.fromkeys(setting.brain.with_numbers(PLAIN) for setting in settings))


def _named(kind: str, name: str, programs: Sequence[One]) -> One:
    """The first of these programs with this name. Raises InputError if there is none."""
    for program in programs:
        if program.name == name:
            return program
    names = list(dict.fromkeys(program.name for program in programs))
    raise wrong_option(kind, name, f"{did_you_mean(name, names)}the study has {', '.join(names)}")


def _none(brains: list[Brain]) -> str:
    names = dict.fromkeys(brain.name for brain in brains)
    return f"no brain of the study ({', '.join(names)}) has PARAMETERS to search"
