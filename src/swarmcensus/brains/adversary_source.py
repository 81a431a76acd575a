"""An adversary wears a brain: of both one brain's source is made, which keeps the contract and can be read.

The robot observes, receives and fuses as its brain does; what it says is altered by what the message's fields mean.
"""

import ast
import functools
import linecache
from pathlib import Path

from swarmcensus.basics.errors import InputError
from swarmcensus.brains.adversary import Adversary
from swarmcensus.brains.brain import Brain, parse, unread
from swarmcensus.brains.contract import CONSTANTS, FUNCTIONS, MAY_HAVE
from swarmcensus.brains.renaming import fields_of_liar, free_prefix, imports, renamed, speaks_of
from swarmcensus.brains.syntax import GIVEN_ON_ASKING
from swarmcensus.brains.telling import VALUES, Field, Names, functions_source

ANEW = ("MEMORY", "PARAMETERS", "SUMS")  # constants of a brain that are not as its file says
ALTERED_BY = {"receive": "hear", "fuse": "plot", "jam": "jam"}  # a brain's function, by which of an adversary


def worn(adversary: Adversary, brain: Brain) -> Brain:
    """The brain of a robot that lies in a swarm of `brain`. Raises ValueError where the two do not go together."""
    return _worn(adversary, brain, adversary.is_read and brain.is_read)


@functools.lru_cache(maxsize=256)
def _worn(adversary: Adversary, brain: Brain, read: bool) -> Brain:
    """The same; files that were read and files that were not are equal otherwise."""
    own = {_names(adversary, brain).own + name: value for name, value in adversary.given}
    return _made(adversary.as_written, brain.as_written, read).with_parameters(dict(brain.given) | own)


@functools.lru_cache(maxsize=256)
def _made(adversary: Adversary, brain: Brain, read: bool) -> Brain:
    if brain.is_oracle:
        raise ValueError(f"brain {brain.name!r}: an oracle hears no liar: no adversary can wear it")
    fields = [Field(name, brain.roles.get(name, ""), long) for name, long in brain.message.items()]
    if not any(field.role in VALUES for field in fields):
        raise ValueError(
            f"the adversary {adversary.name!r} cannot lie: of the MESSAGE of {brain.name!r}, "
            f"({', '.join(brain.message)}), nothing is known to be one of {', '.join(VALUES)}: say what its MESSAGE "
            "means with ROLES"
        )
    # as the command line names it, which messages do too
    path = Path(f"{adversary.path} --wearing {brain.path}")
    try:
        source = source_of(adversary, brain, fields)
        if not read:
            return unread(adversary.name, source)
        linecache.cache[str(path)] = (len(source), None, source.splitlines(keepends=True), str(path))
        return parse(source, adversary.name, path)
    except InputError as error:
        told = str(error)
    except RecursionError:
        told = "its brackets or operators are nested too deep"
    raise ValueError(f"the adversary {adversary.name!r} cannot wear the brain {brain.name!r}: {told}")


def _names(adversary: Adversary, brain: Brain) -> Names:
    sources = adversary.source, brain.source
    return Names(*(free_prefix(prefix, sources) for prefix in ("liar_", "honest_", "worn_")))


def source_of(adversary: Adversary, brain: Brain, fields: list[Field]) -> str:
    """Both as one source. Raises InputError."""
    names, has = _names(adversary, brain), adversary.says.functions
    tree, lies = ast.parse(brain.source), ast.parse(adversary.source)
    for given in GIVEN_ON_ASKING:
        if given in {*brain.memory, *brain.says.parameters} and speaks_of(lies, given):
            raise InputError(f"it asks for me.{given}, and the brain has a field of its own of this name")
    own = ({names.own + k: v for k, v in table.items()} for table in (adversary.says.memory, adversary.says.parameters))
    memory, parameters = (a | b for a, b in zip((brain.memory, brain.says.parameters), own, strict=True))
    altered = {"broadcast", *(made for made, by in ALTERED_BY.items() if by in has)}
    kept = {*FUNCTIONS, *MAY_HAVE, *CONSTANTS} - altered - {*ANEW}
    constants = [f"MEMORY = {memory!r}", *([f"PARAMETERS = {parameters!r}"] if parameters else [])]
    parts = [
        f'"""{_first_line(lies)}\n\nWearing: {_first_line(tree)}\n"""',
        *(["import math"] if imports(tree) or imports(lies) else []),
        "\n".join(constants),
        renamed(tree, names.honest, kept, anew=ANEW),
        renamed(
            lies, names.own, (), fields_of_liar(names.own, {*adversary.says.memory, *adversary.says.parameters}), ANEW
        ),
        functions_source(fields, has, names, brain.options, brain.uses.silence),
    ]
    return "\n\n\n".join(parts) + "\n"


def _first_line(tree: ast.Module) -> str:
    return (ast.get_docstring(tree) or "no description").partition("\n")[0].replace("\\", "/").replace('"', "'")
