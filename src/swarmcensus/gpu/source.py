"""The source of a program for a card: the brains of a setting in C, what fits them to the kernels, and the kernels."""

import functools
from collections.abc import Callable, Iterable
from importlib.resources import files
from string import Template
from typing import NamedTuple

from swarmcensus.brains import MOST, READ, STEPS, Brain, Part, length, numbers, slots
from swarmcensus.engine import codegen
from swarmcensus.engine.constants import FULL, LISTED, NOISE, PAIRS, SAID, SILENT
from swarmcensus.gpu.kernel_arguments import STRUCT
from swarmcensus.translation import OF_FIELDS, bare, codec_unit, in_c, parameter_in_c

MOST_STAGED = 4096  # numbers that `chains` has in shared memory at a time
MOST_AHEAD = 16  # numbers of messages that a robot of a large swarm reads before it takes the first of them
MOST_UNROLLED = 64  # numbers of a state that are copied one by one, and not in a loop: that takes long to compile


class Features(NamedTuple):
    """What the rounds of a setting have: kernels have no code for what they lack."""

    mode: int  # LISTED, FULL or PAIRS
    sound: bool  # no message is lost, and no part of a robot fails
    jams: bool
    signalled: bool  # robots may be silent or jam
    lucky: bool  # some brain uses luck
    judged: bool  # some brain decides, or may be done
    bounded: bool  # some brain has an interval
    changes: bool  # readings may be drawn from other tables in each round

    @property
    def counted(self) -> bool:
        """Whether messages are counted on the card, because how many there are is not known beforehand."""
        return self.signalled or not self.sound or self.mode == PAIRS


@functools.lru_cache(maxsize=1024)
def source(brains: tuple[Brain, ...], features: Features, kernels: str, threads: int) -> str:
    """The program with the kernels of a file, for blocks of so many threads; brains may have any parameters.

    Raises InputError for what C does not know.
    """
    number = "float" if brains[0].numbers.precision == "single" else "double"
    longest = max(len(slots(brain.lengths)) for brain in brains)
    width = len(codegen.message_numbers(brains[0], len(brains) > 1))
    defined = {name: int(value) for name, value in features._asdict().items()} | {
        "listed": LISTED, "full": FULL, "pairs": PAIRS, "silent": SILENT, "said": SAID, "noise": NOISE,
        "groups": len(brains), "width": width, "most_staged": MOST_STAGED,
        "ahead": max(1, MOST_AHEAD // max(width, 1)) if kernels == "crowds.cu" else 1,
        "additive": int(len(brains) == 1 and bool(brains[0].sums)), "counted": int(features.counted),
        "formats": int(any(brain.parts for brain in brains)), "most_threads": threads,
        "options": max(brain.options for brain in brains),
    }  # fmt: skip
    parts = [  # brains come before macros, which could have a name of theirs
        _text("types.h"),
        f'typedef {number} number;\n#define BRAIN_UNROLLED _Pragma("unroll{" 1" * (longest > MOST_UNROLLED)}")',
        *(_of_brain(group, brain, len(brains) > 1) for group, brain in enumerate(brains)),
        _text("machine.h"),
        "\n".join(f"#define {name.upper()} {value}" for name, value in defined.items()),
        STRUCT,
        *map(_text, ("given.h", "random.h")),
        _dispatch(brains),
        *map(_text, ("rounds.h", "sums.h", kernels)),
    ]
    return "\n\n".join(parts)


@functools.cache
def measures() -> str:
    """The program that measures estimates, whatever the brains."""
    number = "typedef double number;\n#define MOST_THREADS 1024"
    others = map(_text, ("given.h", "random.h", "tables.cu", "measures.cu"))
    return "\n\n".join([_text("types.h"), number, _text("machine.h"), STRUCT, *others])


@functools.cache
def _text(name: str) -> str:
    return (files("swarmcensus.gpu") / "kernels" / name).read_text(encoding="utf-8").strip()


def _field(name: str) -> str:
    return in_c(name, OF_FIELDS)


def _places(lengths: Iterable[tuple[str, int]]) -> list[str]:
    """The numbers of fields in C, in order."""
    return [f"{_field(name)}[{k}]" if long else _field(name) for name, long in lengths for k in range(max(long, 1))]


def _of_brain(group: int, brain: Brain, mixed: bool) -> str:
    """A brain and what fits it to the kernels, in a namespace."""
    number = "float" if brain.numbers.precision == "single" else "double"
    codec = codec_unit(number)
    said = _places(brain.message.items())
    coded = _coding_lines(brain, said, codec.real)
    parts = [
        f'extern "C" {{ BRAIN_CONSTANT number parameters_{group}[{max(len(numbers(brain.parameters)), 1)}]; }}',
        f"namespace brain_{group} {{",
        "\n".join(_parameters(group, brain)),
        bare(brain, "\n".join(coded), codec),
        _adapter(brain, said, coded, mixed),
        "\n".join(f"#undef {parameter_in_c(name)}" for name in brain.parameters),
        "}",
    ]
    return "\n\n".join(parts)


def _parameters(group: int, brain: Brain) -> list[str]:
    lines, at = [], 0
    for name, value in brain.parameters.items():
        place = f"(parameters_{group} + {at})" if length(value) else f"(parameters_{group}[{at}])"
        lines.append(f"#define {parameter_in_c(name)} {place}")
        at += max(length(value), 1)
    return lines


def _adapter(brain: Brain, said: list[str], coded: list[str], mixed: bool) -> str:
    """What every brain has for the kernels, around its own functions."""
    sums = _places((name, brain.lengths[name]) for name in brain.sums) if brain.sums and not mixed else []
    kept = [f"out[{k}] = {place};" for k, place in enumerate(f"message.{name}" for name in said)]
    if sums:  # what a message adds is computed once by its sender
        kept = ["struct brain hearer = {};", "receive(&hearer, &message);"]
        kept += [f"out[{k}] = hearer.{name};" for k, name in enumerate(sums)]
    quiet = f"for (int32_t n = 0; n < {len(sums or said)}; n++) {{ out[n] = 0; }}"
    taken = [f"message.{name} = in[{k}];" for k, name in enumerate(said)]
    bound = ["const struct interval ends = interval(me);", "*low = (double)ends.low;", "*high = (double)ends.high;"]
    return Template(_text("brain.h")).substitute(
        name="me->name = (number)i;" if brain.uses.name else "(void)i;",
        jam=_lines(["if (jam(me)) {", f"    {quiet}", f"    return {NOISE};", "}"] if brain.jams else []),
        quiet=quiet,
        silent=SILENT,
        said=SAID,
        coded=_lines(coded),
        kept=_lines(kept),
        taken=_lines(_add(sums, "in[{}]") if sums else ["struct message message;", *taken, "receive(me, &message);"]),
        sums=_lines(f"out[{k}] = me->{name};" for k, name in enumerate(sums)),
        put=_lines(f"me->{name} = in[{k}];" for k, name in enumerate(sums)),
        added=_lines(_add(sums, "in[{} * apart]")),
        luck="me->luck = luck;" if brain.uses.luck else "(void)luck;",
        decide="(double)decide(me)" if brain.decides else "-1.0",
        done="done(me)" if brain.ends else "false",
        bound=_lines(bound if brain.has_interval else ["*low = *high = NAN;"]),
    )


def _add(sums: list[str], term: str) -> list[str]:
    return [f"me->{name} = me->{name} + {term.format(k)};" for k, name in enumerate(sums)]


def _lines(lines: Iterable[str]) -> str:
    return "\n    ".join(lines)


def _coding_lines(brain: Brain, said: list[str], real: Callable[[float], str]) -> list[str]:
    """Lines that replace the parts of a message by what a receiver reads, and keep what rounding took of them."""
    if not brain.parts:
        return []
    owed = {place: f"me->owed[{slot}]" for slot, place in enumerate(brain.owed)}
    lines = [f"const number plain_{k} = message.{name};" for k, name in enumerate(said)]
    for k, _ in enumerate(said):
        sent = f"codec_added(plain_{k}, {owed[k]})" if k in owed else f"plain_{k}"
        lines.append(f"const number number_{k} = {sent};")
    lines += ["bool holds, clips = false;"]
    for part in brain.parts:
        lines += _code(part, said, owed, real)
    return [*lines, "clipped += clips;"]


def _code(part: Part, said: list[str], owed: dict[int, str], real: Callable[[float], str]) -> list[str]:
    """Lines that put what a receiver reads of a part into `message`."""
    places, coding, name = part.places, part.coding, READ[part.coding]
    steps = STEPS.get(coding) or MOST.get(coding)
    cast = "(number)(float)" if coding == "float32" else ""
    given = ", ".join([*(f"{cast}number_{k}" for k in places), *([] if steps is None else [real(steps)])])
    lines = [f"holds = codec_holds_{name}({given});", "clips = clips || !holds;"]
    if len(places) > 1:
        lines.append(f"const struct real_real pair_{places[0]} = codec_read_{name}({given});")
        reads = [f"pair_{places[0]}.first", f"pair_{places[0]}.second"]
    else:
        reads = [f"codec_read_{name}({given})"]
    for k, read in zip(places, reads, strict=True):
        lines.append(f"message.{said[k]} = {read};")
        if k in owed:
            rest = f"codec_rest(plain_{k}, {owed[k]}, number_{k}, message.{said[k]})"
            lines.append(f"{owed[k]} = holds ? {rest} : (number)0;")
    return lines


# what the kernels call of the brain of a robot's group: result, arguments
CALLS = {
    "say": ("int32_t", "number *out, int64_t &clipped"),
    "take": ("void", "const number *in"),
    "get_sums": ("void", "number *out"),
    "set_sums": ("void", "const number *in"),
    "add_sums": ("void", "const number *in, int64_t apart"),
    "luck": ("void", "number luck"),
    "look": ("void", "double blacks, double looks"),
    "fuse": ("void", ""),
    "estimate": ("double", ""),
    "decide": ("double", ""),
    "done": ("bool", ""),
    "bound": ("void", "double *low, double *high"),
}


def _dispatch(brains: tuple[Brain, ...]) -> str:
    """The brains of a swarm as one union, and functions that call that of a robot's group."""
    fields = [f"    struct brain_{group}::brain of_{group};" for group, _ in enumerate(brains)]
    parts = ["\n".join(["union Brains {", *fields, "};"])]
    starts = ["0", *(f"sizeof(struct brain_{group}::brain) / sizeof(number)" for group, _ in enumerate(brains))]
    start = "const number *blanks, int64_t i, double b, double w"
    for name, (result, arguments) in ({"start": ("void", start)} | CALLS).items():
        lines = [f"PART {result} robot_{name}(Brains &me, int64_t group{arguments and f', {arguments}'}) {{"]
        for group, _ in enumerate(brains):
            given = [argument.rpartition(" ")[2].strip("*&") for argument in arguments.split(",")] if arguments else []
            given = [f"blanks + {' + '.join(starts[: group + 1])}" if n == "blanks" else n for n in given]
            call = f"brain_{group}::robot_{name}({', '.join([f'&me.of_{group}', *given])})"
            is_last = group == len(brains) - 1
            other = f"    if (group == {group}) {{\n        return {call};\n    }}"
            lines.append(f"    return {call};" if is_last else other)
        parts.append("\n".join([*lines, "}"]))
    return "\n\n".join(parts)
