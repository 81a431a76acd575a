"""Adversaries that know the brain they wrap: what they say by field, what they read, and what is refused."""

import re
from pathlib import Path

import pytest

from swarmcensus import brains
from swarmcensus.brains import adversary
from swarmcensus.checks import brain_to_check
from swarmcensus.checks.checking import notes_on
from swarmcensus.support.errors import InputError
from tests.support.lying import RICH, adversary_of, robot
from tests.support.places import EXAMPLE
from tests.support.second import MEANS, brain

SOURCE = '''"""Knows: it says each of three fields by another rule, the other fields by their roles."""

KNOWS = ("n", "mood")
PARAMETERS = {"more": 0.5}
MEMORY = {"rounds": 0.0}


def lie(me, x):
    return 0.25


def say_x(me, value):
    return value + 2.0 * me.more


def say_sure(me, value):
    return value - 10.0


def say_t(me, value):
    return value + 10.0 * me.n + 100.0 * me.rounds + me.mood


def say_other(me, value):
    return 7.0


def plot(me):
    me.rounds += 1.0
'''
HONEST = "def lie(me, x):\n    return x\n"


def knowing(names, lie=HONEST):
    return adversary_of(f"KNOWS = {names}\n\n\n{lie}")


def test_rules_by_field_or_role():
    """3 of 4 are black: x = 0.75, confidence 2, t = 4, n = 3; a quarter is told of all other fields. The information is
    a quarter of the confidence that `boast` would tell, here the honest one."""
    used = brains.lying_brain(adversary_of(SOURCE), brain(RICH))
    me = robot(used, 3, 4)
    me.luck = 0.625
    used.functions.fuse(me)
    who, x, vote, chosen, _, sure, known, t = used.functions.broadcast(me)
    assert (who, vote, chosen, known) == (3.0, 0.0, 1.0, 0.5)
    assert (x, sure) == (1.75, -8.0)  # neither is clipped
    assert t == 4.0 + 30.0 + 100.0 + 0.625
    assert used.functions.estimate(me) == 0.5  # nothing of its brain is changed


def test_silence_is_kept_and_parameters_are_known_too():
    used = brains.lying_brain(adversary_of(SOURCE), brain(RICH))
    assert used.functions.broadcast(used.robot(0.9, 0.8, 3.0)) is None
    weighs = brain(MEANS.replace("MEMORY = {", 'PARAMETERS = {"pace": 0.5}\nMEMORY = {'))
    used = brains.lying_brain(knowing(("pace", "n"), "def lie(me, x):\n    return me.pace\n"), weighs)
    assert used.functions.broadcast(robot(used, 3, 4)) == (0.5,)
    lies = knowing(("pace",), "def lie(me, x):\n    return me.pace\n")
    quick = brains.lying_brain(lies, weighs.with_parameters({"pace": 0.25}))
    assert quick.functions.broadcast(robot(quick, 3, 4)) == (0.25,)


@pytest.mark.parametrize(("lies", "source", "said"), [
    (knowing(("n", "nn")), MEANS, "KNOWS of liar.py names 'nn', and the brain has no such field"),
    (knowing(("mod",)), RICH, "and the brain has no such field: did you mean 'mood'?"),
    (knowing(("belief",)), RICH, "KNOWS of liar.py names 'belief', which is a vector of the brain"),
    (adversary_of(HONEST + "\n\ndef say_belief(me, value):\n    return 1.0\n"), RICH,
     "say_belief of liar.py returns a number, and belief is a vector of 4"),
])  # fmt: skip
def test_an_unfit_brain_is_refused(lies, source, said):
    with pytest.raises(ValueError, match=r"the adversary 'liar\.py' cannot wrap the brain 'brain\.py': ") as error:
        brains.lying_brain(lies, brain(source))
    assert said in str(error.value)


@pytest.mark.parametrize(("source", "said"), [
    ('KNOWS = "n"\n' + HONEST, "KNOWS = 'n': should be a tuple of fields of the brain"),
    ('X = 1\nKNOWS = ("n", 2)\n' + HONEST, "KNOWS = ('n', 2): should be a tuple"),
    ('MEMORY = {"n": 0.0}\nKNOWS = ("n",)\n' + HONEST, "KNOWS names 'n', which is a field of its own"),
    ('KNOWS = ("luck",)\n' + HONEST, "KNOWS names 'luck', which every adversary has"),
    (HONEST.replace("x\n", "me.n\n"), "line 2: lie uses me.n: a robot has only b, w"),
    ('KNOWS = ("n",)\n' + HONEST.replace("return x", "me.n = 1.0\n    return x"), "line 3: lie sets me.n"),
    (HONEST + "\ndef say_x(me):\n    return 1.0\n", "say_x: the number of its arguments should be 2, not 1"),
    (HONEST + "\ndef say_x(me, v):\n    pass\n", "line 4: say_x may end without returning"),
    (HONEST + "\ndef say_x(me, v):\n    return me.luck\n", "say_x reads me.luck, which is new"),
    ("say_x = 1.0\n" + HONEST + "\ndef say_x(me, v):\n    return v\n", "say_x is defined twice"),
])  # fmt: skip
def test_faults_of_an_insider_are_named(source, said):
    with pytest.raises(InputError, match=r"^adversary file liar\.py") as error:
        adversary_of(source)
    assert said in str(error.value)


def test_the_shell_notes_what_is_never_said_and_shows_what_is(here, accepted, refused):
    Path("knows.py").write_text(SOURCE)
    Path("rich.py").write_text(RICH)
    said = ["say_other says nothing: the MESSAGE of rich.py has no other"]
    assert notes_on("knows.py", brain_to_check("knows.py", "rich.py"), "rich.py") == said
    assert notes_on("always-black", brain_to_check("always-black"), "") == []
    shown = accepted("brains", "--show", "knows.py", "--wrapping", "rich.py").out
    assert "def liar_say_t(me, value):\n    return value + 10.0 * me.n + 100.0 * me.liar_rounds + me.mood" in shown
    said = refused("brains", "--show", "knows.py", "--wrapping", "commons")
    assert "cannot wrap the brain 'commons': KNOWS of knows.py names 'n'" in said
    error = refused("brains", "--show", "knows.py")
    assert re.search("names 'mood'.* no such field: name another brain with --wrapping$", error)


STEADFAST = brains.load("steadfast")
OURS = ("s", "v", "own_s", "own_v", "near")  # its message


def insider(**lie):
    """The shipped insider, as a brain."""
    return brains.lying_brain(adversary.load("insider.py", EXAMPLE).with_parameters(lie), STEADFAST)


def said_after(brain, me, blacks):
    """A robot's message after 20 more readings."""
    brain.functions.observe(me, blacks, 20)
    return brain.functions.broadcast(me)


@pytest.mark.parametrize(("lie", "due"), [
    ({"sleeps": 2.0, "step": 0.05}, lambda me: (me.s, me.v, me.own_s, me.own_v, me.near)),
    ({"step": 0.05, "own": 0.02, "weight": 3.0},
     lambda me: (3 * (me.s + 0.05 * me.v), 3 * me.v, 3 * (me.own_s + 0.02 * me.own_v), 3 * me.own_v, me.near)),
    ({"lean": 2.0},  # in a ratio of own sums one is 1 / (2 sqrt(own_v))
     lambda me: (me.s, me.v, me.own_s + me.own_v * 2.0 * 0.5 / me.own_v**0.5, me.own_v, me.near)),
    ({"from_r": -1.5}, lambda me: ((me.near - 1.5 * me.error) * me.v, me.v, me.own_s, me.own_v, me.near)),
    ({"from_r": 1.5, "lean": 1.0, "sides": 1.0, "second": 2.0},  # its own readings say more black than r
     lambda me: ((me.near - 1.5 * me.error) * me.v, me.v, me.own_s - 0.5 * me.own_v**0.5, me.own_v,
                 me.near - 2 * me.error)),
])  # fmt: skip
def test_the_shipped_insider_is_what_its_first_lines_say(lie, due):
    """After a round in which it has read 14 of 20 and a neighbour 12 of 20, as a robot that is honest."""
    assert tuple(STEADFAST.message) == OURS
    used, heard = insider(**lie), said_after(STEADFAST, STEADFAST.robot(0.8, 0.7), 12)
    liar, honest = used.robot(0.8, 0.7), STEADFAST.robot(0.8, 0.7)
    for one, me in ((used, liar), (STEADFAST, honest)):
        said_after(one, me, 14)
        one.functions.receive(me, heard)
        one.functions.fuse(me)
    assert used.functions.broadcast(liar) == pytest.approx(due(honest))
    assert 0.0 < honest.near - 1.5 * honest.error < honest.near < 1.0
