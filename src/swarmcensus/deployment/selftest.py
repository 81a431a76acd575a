"""A test of a translated brain: a small swarm lives the same history in C and in CPython, and both print their bits.

The history is drawn by a generator of whole numbers of 32 bits, so that every machine draws the same.
"""

import struct
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from swarmcensus.basics.errors import InputError
from swarmcensus.brains import Brain, numbers
from swarmcensus.brains.single import rounded_to_single
from swarmcensus.deployment.messages import messages_of
from swarmcensus.deployment.unit import Unit
from swarmcensus.robot.runtime import Messages

ACCURACIES = ((0.9, 0.8), (0.75, 0.6), (0.3, 0.4), (1.0, 0.7), (0.5, 0.5), (0.8, 0.9))  # b and w of each robot
ROBOTS = len(ACCURACIES)
ROUNDS = 300
STOPS = (1, 2, 3, 5, 9, 17, 33, 65, 129, 200, ROUNDS)  # rounds after which all memory is printed
LOOKS = (0, 1, 3, 10)  # readings in a round, one of these
SHARE = 43  # percent of readings that are black
FAR = 5  # one in so many pairs of robots that are no neighbours on the ring hears each other
LOST = 4  # one in so many messages is lost
SEED = 20


class Draws:
    """A linear congruential generator (Knuth's constants, as in Numerical Recipes) modulo 2^32."""

    def __init__(self) -> None:
        """Begin."""
        self.state = SEED

    def next(self) -> int:
        """The next state."""
        self.state = (self.state * 1664525 + 1013904223) % 2**32
        return self.state

    def below(self, n: int) -> int:
        """A whole number from 0 to n - 1."""
        return (self.next() >> 16) % n

    def luck(self) -> float:
        """An odd number of 2^-24, in (0, 1), which both precisions hold exactly."""
        return ((self.next() >> 9) * 2 + 1) / 2**24


def expected(brain: Brain) -> str:
    """What the self-test of a brain prints, from CPython. Raises InputError if the brain fails in it."""
    try:
        return "".join(f"{line}\n" for line in _lines(brain))
    except Exception as error:
        what = f"{type(error).__name__}: {str(error).partition(chr(10))[0]}"
        raise InputError(
            f"brain {brain.name!r} fails in the self-test: {what}; swarmcensus brains --check {brain.name} shows where"
        ) from error


def _lines(brain: Brain) -> Iterator[str]:
    single = brain.numbers.precision == "single"
    width = rounded_to_single if single else float
    draws, call = Draws(), brain.functions
    minds = [brain.robot(width(b), width(w), float(i)) for i, (b, w) in enumerate(ACCURACIES)]
    radios = [messages_of(brain) for _ in minds]

    def bits(values: Sequence[float]) -> str:
        return " ".join(_bits(float(value), single) for value in values)

    def give(me: Any) -> None:
        luck = draws.luck()
        if brain.uses.luck:
            me.luck = luck

    for k in range(1, ROUNDS + 1):
        for me in minds:
            looks = LOOKS[draws.below(len(LOOKS))]
            blacks = sum(draws.below(100) < SHARE for _ in range(looks))
            give(me)
            if looks and not (brain.ends and call.done(me)):
                call.observe(me, float(blacks), float(looks))
        said: list[bytes | None] = []
        for me, radio in zip(minds, radios, strict=True):
            message = None if brain.jams and call.jam(me) else call.broadcast(me)
            said.append(None if message is None else radio.coded(message))
        for i, me in enumerate(minds):
            for j, data in enumerate(said):
                near = (i - j) % ROBOTS in (1, ROBOTS - 1)
                hears = i != j and (draws.below(FAR) == 0 or near) and draws.below(LOST) != 0
                if hears and data is not None:
                    give(me)
                    call.receive(me, radios[i].read(data))
        for i, me in enumerate(minds):
            give(me)
            call.fuse(me)
            answers = [call.estimate(me), *(call.decide(me) for _ in range(brain.decides))]
            answers += [float(bool(call.done(me))) for _ in range(brain.ends)]
            answers += [float(bool(call.jam(me))) for _ in range(brain.jams)]
            answers += [*(call.interval(me) if brain.has_interval else ())]
            if brain.steers:
                give(me)
                wish = call.steer(me)
                answers += [0.0, 0.0, 0.0] if wish is None else [1.0, *wish]
            data = said[i]
            yield f"{k} {i} {bits(answers)} {'silent' if data is None else data.hex()}"
        if k in STOPS:
            for i, (me, radio) in enumerate(zip(minds, radios, strict=True)):
                memory = numbers({name: _value(getattr(me, name)) for name in brain.memory})
                yield f"{k} {i} memory {bits([*memory, *_owed(brain, radio)])}"


def _value(value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value


def _owed(brain: Brain, radio: Messages) -> list[float]:
    owing = brain.parts if brain.numbers.feedback else ()
    return [radio.owed[place] for part in owing if part.owed for place in part.places]


def _bits(value: float, single: bool) -> str:
    if value != value:
        return "nan"
    if single:
        return struct.pack(">f", value).hex()
    return struct.pack(">d", value).hex()


class Difference(NamedTuple):
    """How the output of a self-test differs from what is expected."""

    line: int  # the first line that differs, counted from 1; 0 if none does
    largest: float  # the largest difference of numbers, relative to those above 1; infinite if other things differ


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
    owed = len(_owed(brain, messages_of(brain)))
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
