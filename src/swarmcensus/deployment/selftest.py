"""A test of a translated brain: a small swarm lives the same history in C and in CPython, and both print their bits."""

import ast
import struct
from collections.abc import Sequence
from typing import Any, NamedTuple

from swarmcensus.basics.errors import BrainError
from swarmcensus.basics.options import command
from swarmcensus.brains import Brain
from swarmcensus.brains.single import rounded_to_single
from swarmcensus.deployment.messages import messages_of, owing
from swarmcensus.deployment.unit import Unit
from swarmcensus.robot.history import ACCURACIES, FAR, LOOKS, LOST, ROBOTS, ROUNDS, SEED, SHARE, STOPS, live

EXACT = {"sqrt", "floor", "ceil", "frexp", "ldexp", "pi"}  # of math: all machines give the same bits


def expected(brain: Brain) -> str:
    """What the self-test of a brain prints, from CPython. Raises InputError if the brain fails in it."""
    single = brain.numbers.precision == "single"
    width = rounded_to_single if single else float
    minds = [brain.robot(width(b), width(w), float(i)) for i, (b, w) in enumerate(ACCURACIES)]
    try:
        return lived(brain, brain.functions, minds)
    except Exception as error:
        what = f"{type(error).__name__}: {str(error).partition(chr(10))[0]}"
        raise BrainError(
            f"brain {brain.name!r} fails in the self-test: {what}; "
            f"{command('swarmcensus', 'brains', '--check', brain.name)} shows where",
            key="brain",
            value=brain.name,
        ) from error


def lived(brain: Brain, functions: Any, minds: Sequence[Any], codec: Any = None) -> str:
    """What the self-test prints in this process, with a brain's `functions`, blank `minds`, and a codec of messages."""
    radios = [messages_of(brain) for _ in minds]
    for radio in radios:
        radio.codec = codec or radio.codec
    single = brain.numbers.precision == "single"
    lines = live(functions, minds, radios, list(brain.memory), owed_places(brain), brain.uses.luck, single)
    return "".join(f"{line}\n" for line in lines)


def owed_places(brain: Brain) -> list[int]:
    """Which numbers of a message owe something to the next, in the order of the self-test."""
    return [place for part in owing(brain) for place in part.places]


class Difference(NamedTuple):
    """How the output of a self-test differs from what is expected."""

    line: int  # the first line that differs, counted from 1; 0 if none does
    largest: float  # the largest difference of numbers, relative to those above 1; infinite if other things differ


def first_rounds(text: str, rounds: int) -> str:
    """The part of a self-test's output that is about its first rounds."""
    return "".join(line for line in text.splitlines(keepends=True) if int(line.split()[0]) <= rounds)


def is_exact(brain: Brain) -> bool:
    """Whether a brain uses only what IEEE 754 defines to the last bit: no functions such as exp, no other powers."""
    nodes = list(ast.walk(ast.parse(brain.source)))
    called = {
        node.attr for node in nodes if isinstance(node, ast.Attribute) and getattr(node.value, "id", "") == "math"
    }
    powers = (node for node in nodes if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow))
    exponents = {ast.unparse(node.right) for node in powers} - {"2", "(-20)", "-20", "BINS"}
    return called <= EXACT and not exponents


def compare(wanted: str, found: str) -> Difference:
    """Compare the output of a self-test with the expected one."""
    rows = list(zip(wanted.splitlines(), found.splitlines(), strict=False))
    first = next((k for k, (one, other) in enumerate(rows, 1) if one != other), 0)
    if len(wanted.splitlines()) != len(found.splitlines()):
        return Difference(first or len(rows) + 1, float("inf"))
    largest = max((_distance(one, other) for one, other in rows if one != other), default=0.0)
    return Difference(first, largest)


def _distance(one: str, other: str) -> float:
    mine, yours = one.split(), other.split()
    if len(mine) != len(yours) or mine[:2] != yours[:2]:
        return float("inf")
    last = len(mine) if mine[2] == "memory" else len(mine) - 1  # a message's bytes may change with a number's last bit
    if "silent" in (mine[-1], yours[-1]) and mine[-1] != yours[-1]:
        return float("inf")
    return max(map(_apart, mine[2:last], yours[2:last]), default=0.0)


def _apart(one: str, other: str) -> float:
    if one == other:
        return 0.0
    if "nan" in (one, other):
        return float("inf")
    x, y = (struct.unpack(">f" if len(text) == 8 else ">d", bytes.fromhex(text))[0] for text in (one, other))
    return float(abs(x - y) / max(1.0, abs(x)))


def in_c(brain: Brain, unit: Unit) -> str:
    """The self-test's C source, for a file beside brain.h."""
    answers = ["    test_put_number(estimate(me));"]
    answers += ["    test_put_number(decide(me));"] * brain.decides
    answers += ["    test_put_number(done(me) ? 1 : 0);"] * brain.ends
    answers += ["    test_put_number(jam(me) ? 1 : 0);"] * brain.jams
    if brain.has_interval:
        answers += [
            "    const struct interval ends = interval(me);",
            "    test_put_number(ends.low);",
            "    test_put_number(ends.high);",
        ]
    if brain.steers:
        answers += [
            "    test_give_luck(me);",
            "    struct wish wish = {0, 0};",
            "    test_put_number(steer(me, &wish) ? 1 : 0);",
            "    test_put_number(wish.speed);",
            "    test_put_number(wish.turn);",
        ]
    memory = []
    for name, items in brain.lengths.items():
        memory += _put(unit.field(name), items)
    owed = len(owed_places(brain))
    memory += _put("owed", owed) if owed else []
    return SOURCE.format(
        robots=ROBOTS,
        rounds=ROUNDS,
        stops=", ".join(map(str, STOPS)),
        looks=", ".join(map(str, LOOKS)),
        accuracies=", ".join(f"{{{unit.real(b)}, {unit.real(w)}}}" for b, w in ACCURACIES),
        seed=SEED,
        share=SHARE,
        far=FAR,
        lost=LOST,
        word="uint32_t" if unit.number == "float" else "uint64_t",
        top=28 if unit.number == "float" else 60,
        luck="    me->luck = luck;" if brain.uses.luck else "    (void)me;\n    (void)luck;",
        unit_of_luck=unit.real(2.0**-24),
        name=", (number)i" if brain.uses.name else "",
        done=" && !done(me)" if brain.ends else "",
        jam="jam(&test_swarm[i]) ? false : " if brain.jams else "",
        answers="\n".join(answers),
        memory="\n".join(memory),
    )


def _put(field: str, items: int) -> list[str]:
    if not items:
        return [f"    test_put_number(me->{field});"]
    return [f"    for (int32_t k = 0; k < {items}; k++) {{", f"        test_put_number(me->{field}[k]);", "    }"]


SOURCE = """\
// A swarm of {robots} robots lives {rounds} rounds and prints estimates, messages and memory in bits. Compare what it
// prints with expected.txt, which Python wrote. brain.h says which options the compiler needs.

#include "brain.h"

#define ROBOTS {robots}
#ifndef ROUNDS
#define ROUNDS {rounds}
#endif

#ifdef __AVR__
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>

static void test_put(char c) {{
    while (!(UCSR0A & _BV(UDRE0))) {{
    }}
    UDR0 = (uint8_t)c;
}}

static void test_begin(void) {{
    UBRR0 = 0;  // a sixteenth of the processor's clock
    UCSR0B = _BV(TXEN0);
}}

static void test_end(void) {{
    while (!(UCSR0A & _BV(UDRE0))) {{
    }}
    cli();  // a simulator ends here
    sleep_enable();
    sleep_cpu();
}}
#else
#include <stdio.h>

static void test_put(char c) {{ putchar(c); }}
static void test_begin(void) {{}}
static void test_end(void) {{ fflush(stdout); }}
#endif

static struct brain test_swarm[ROBOTS];
static uint8_t test_messages[ROBOTS][BRAIN_MESSAGE_BYTES];
static bool test_speaks[ROBOTS];
static uint32_t test_state = {seed};

static uint32_t test_draw(void) {{
    test_state = test_state * UINT32_C(1664525) + UINT32_C(1013904223);
    return test_state;
}}

static uint16_t test_draw_below(uint16_t n) {{ return (uint16_t)((test_draw() >> 16) % n); }}

static void test_give_luck(struct brain *me) {{
    const number luck = (number)((test_draw() >> 9) * 2 + 1) * {unit_of_luck};
{luck}
}}

static void test_put_text(const char *text) {{
    while (*text) {{
        test_put(*text++);
    }}
}}

static void test_put_whole(uint16_t x) {{
    if (x >= 10) {{
        test_put_whole(x / 10);
    }}
    test_put((char)('0' + x % 10));
}}

static void test_put_digit(uint8_t digit) {{ test_put((char)(digit < 10 ? '0' + digit : 'a' + digit - 10)); }}

static void test_put_number(number x) {{
    union {{
        number value;
        {word} bits;
    }} both;
    both.value = x;
    test_put(' ');
    if (x != x) {{
        test_put_text("nan");
        return;
    }}
    for (int8_t shift = {top}; shift >= 0; shift -= 4) {{
        test_put_digit((uint8_t)(both.bits >> shift & 15));
    }}
}}

static void test_put_place(uint16_t round, uint8_t i) {{
    test_put_whole(round);
    test_put(' ');
    test_put_whole(i);
}}

static void test_put_answers(struct brain *me) {{
{answers}
}}

static void test_put_message(uint8_t i) {{
    test_put(' ');
    if (!test_speaks[i]) {{
        test_put_text("silent");
        return;
    }}
    for (uint16_t k = 0; k < BRAIN_MESSAGE_BYTES; k++) {{
        test_put_digit(test_messages[i][k] >> 4);
        test_put_digit(test_messages[i][k] & 15);
    }}
}}

static void test_put_memory(const struct brain *me) {{
{memory}
}}

static bool test_is_stop(uint16_t round) {{
    static const uint16_t stops[] = {{{stops}}};
    for (uint8_t k = 0; k < sizeof stops / sizeof *stops; k++) {{
        if (stops[k] == round) {{
            return true;
        }}
    }}
    return false;
}}

static void test_look(struct brain *me) {{
    static const uint8_t numbers[] = {{{looks}}};
    const uint8_t looks = numbers[test_draw_below(sizeof numbers)];
    uint8_t blacks = 0;
    for (uint8_t k = 0; k < looks; k++) {{
        blacks = (uint8_t)(blacks + (test_draw_below(100) < {share}));
    }}
    test_give_luck(me);
    if (looks > 0{done}) {{
        observe(me, blacks, looks);
    }}
}}

static void test_listen(uint8_t i) {{
    for (uint8_t j = 0; j < ROBOTS; j++) {{
        const uint8_t apart = (uint8_t)((i + ROBOTS - j) % ROBOTS);
        if (apart == 0) {{
            continue;
        }}
        const bool is_far = test_draw_below({far}) != 0 && apart != 1 && apart != ROBOTS - 1;
        if (!is_far && test_draw_below({lost}) != 0 && test_speaks[j]) {{
            test_give_luck(&test_swarm[i]);
            brain_hear(&test_swarm[i], test_messages[j]);
        }}
    }}
}}

int main(void) {{
    static const number accuracies[ROBOTS][2] = {{{accuracies}}};
    test_begin();
    for (uint8_t i = 0; i < ROBOTS; i++) {{
        brain_start(&test_swarm[i], accuracies[i][0], accuracies[i][1]{name});
    }}
    for (uint16_t round = 1; round <= ROUNDS; round++) {{
        for (uint8_t i = 0; i < ROBOTS; i++) {{
            test_look(&test_swarm[i]);
        }}
        for (uint8_t i = 0; i < ROBOTS; i++) {{
            test_speaks[i] = {jam}brain_send(&test_swarm[i], test_messages[i]);
        }}
        for (uint8_t i = 0; i < ROBOTS; i++) {{
            test_listen(i);
        }}
        for (uint8_t i = 0; i < ROBOTS; i++) {{
            test_give_luck(&test_swarm[i]);
            fuse(&test_swarm[i]);
            test_put_place(round, i);
            test_put_answers(&test_swarm[i]);
            test_put_message(i);
            test_put('\\n');
        }}
        for (uint8_t i = 0; i < ROBOTS && test_is_stop(round); i++) {{
            test_put_place(round, i);
            test_put_text(" memory");
            test_put_memory(&test_swarm[i]);
            test_put('\\n');
        }}
    }}
    test_end();
    return 0;
}}
"""
