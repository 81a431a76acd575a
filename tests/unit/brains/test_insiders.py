"""Adversaries that know the brain they wrap: what they say by field, what they read, and what is refused."""

from pathlib import Path

import pytest

from swarmcensus import brains
from swarmcensus.brains import adversary
from swarmcensus.checks import suite
from swarmcensus.checks.machine_code import agrees
from swarmcensus.cli.commands import main
from swarmcensus.support.errors import InputError
from tests.support.lives import lived
from tests.support.lying import RICH, adversary_of, robot
from tests.support.places import EXAMPLE
from tests.support.second import MEANS, brain, fixed

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
    """3 of 4 are black: x = 0.75, confidence 2, t = 4, n = 3; a quarter is told of all other fields.

    The information is a quarter of the confidence that `boast` would tell, here the honest one.
    """
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
    quick = brains.lying_brain(knowing(("pace",), "def lie(me, x):\n    return me.pace\n"),
                               weighs.with_parameters({"pace": 0.25}))  # fmt: skip
    assert quick.functions.broadcast(robot(quick, 3, 4)) == (0.25,)


@pytest.mark.interpreted
def test_a_swarm_with_insiders_lives_as_by_brute_force():
    members = [{"robots": 2, "brain": adversary_of(SOURCE), "honest": False}]
    (setting,) = fixed(brain(RICH), robots=7, rounds=10, looks=2, members=members, topology="ring")
    lived(setting)


@pytest.mark.long
def test_machine_code_says_and_knows_the_same(untraced):
    agrees(brains.lying_brain(adversary_of(SOURCE), brain(RICH)))


@pytest.mark.parametrize(
    ("lies", "source", "said"),
    [
        (knowing(("n", "nn")), MEANS, "KNOWS names 'nn' in line 1 of liar.py, and the brain has no such field"),
        (knowing(("mod",)), RICH, "and the brain has no such field: did you mean 'mood'?"),
        (knowing(("belief",)), RICH, "KNOWS names 'belief' in line 1 of liar.py, which is a vector of the brain"),
        (
            adversary_of(HONEST + "\n\ndef say_belief(me, value):\n    return 1.0\n"),
            RICH,
            "say_belief in line 5 of liar.py returns a number, and belief is a vector of 4",
        ),
    ],
)
def test_an_unfit_brain_is_refused_with_its_line(lies, source, said):
    with pytest.raises(ValueError, match=r"the adversary 'liar\.py' cannot wrap the brain 'brain\.py': ") as error:
        brains.lying_brain(lies, brain(source))
    assert said in str(error.value)


@pytest.mark.parametrize(
    ("source", "said"),
    [
        ('KNOWS = "n"\n' + HONEST, "line 1: KNOWS = 'n': should be a tuple of fields of the brain"),
        ('X = 1\nKNOWS = ("n", 2)\n' + HONEST, "line 2: KNOWS = ('n', 2): should be a tuple"),
        ('MEMORY = {"n": 0.0}\nKNOWS = ("n",)\n' + HONEST, "line 2: KNOWS names 'n', which is a field of its own"),
        ('KNOWS = ("luck",)\n' + HONEST, "KNOWS names 'luck', which every adversary has"),
        (HONEST.replace("x\n", "me.n\n"), "line 2: lie uses me.n: a robot has only b, w"),
        (
            'KNOWS = ("n",)\n' + HONEST.replace("return x", "me.n = 1.0\n    return x"),
            "line 3: lie sets me.n",
        ),
        (HONEST + "\ndef say_x(me):\n    return 1.0\n", "say_x takes 1 arguments: 2 are right"),
        (HONEST + "\ndef say_x(me, v):\n    pass\n", "line 4: say_x may end without returning"),
        (HONEST + "\ndef say_x(me, v):\n    return me.luck\n", "say_x reads me.luck, which is new"),
        ("say_x = 1.0\n" + HONEST + "\ndef say_x(me, v):\n    return v\n", "say_x is also the name of a function"),
    ],
)
def test_faults_of_an_insider_are_named(source, said):
    with pytest.raises(InputError, match=r"^adversary file liar\.py") as error:
        adversary_of(source)
    assert said in str(error.value)


def test_the_shell_notes_what_is_never_said_and_shows_what_is(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("knows.py").write_text(SOURCE)
    Path("rich.py").write_text(RICH)
    assert suite.notes("knows.py", "rich.py") == ["say_other says nothing: the MESSAGE of rich.py has no other"]
    assert suite.notes("always-black") == []
    assert main(["brains", "--show", "knows.py", "--wrapping", "rich.py"]) == 0
    shown = capsys.readouterr().out
    assert "def liar_say_t(me, value):\n    return value + 10.0 * me.n + 100.0 * me.liar_rounds + me.mood" in shown
    assert "KNOWS" not in shown
    assert main(["brains", "--show", "knows.py", "--wrapping", "commons"]) == 2
    assert "cannot wrap the brain 'commons': KNOWS names 'n' in line 3 of knows.py" in capsys.readouterr().err
    assert main(["brains", "--show", "knows.py"]) == 2
    assert "KNOWS names 'mood'" in (error := capsys.readouterr().err)
    assert error.endswith("no such field: name another brain with --wrapping\n")


def test_the_shipped_insider_is_what_its_first_lines_say():
    """By hand: sums move by `step`, own sums by `own`, both further by `grow` a round, from round `sleeps` on."""
    told = {"step": 0.02, "own": 0.05, "short": -0.01, "grow": 0.01}
    told |= {"weight": 3.0, "sleeps": 1.0, "noise": 4.0, "anew": 2.0}
    lies = adversary.load("insider.py", EXAMPLE).with_parameters(told)
    used, honest = brains.lying_brain(lies, brains.load("census")), brains.load("census")
    fields = list(honest.message)

    def said(one, me):
        return dict(zip(fields, one.functions.broadcast(me), strict=True))

    me, other = robot(used, 7, 10), robot(honest, 7, 10)
    assert said(used, me) == pytest.approx(said(honest, other))  # asleep
    for one, state in ((used, me), (honest, other)):
        state.luck = 0.75
        one.functions.fuse(state)
        one.functions.observe(state, 7, 10)
    found, due = said(used, me), said(honest, other)
    for total, weight, step in (("s", "v", 0.02), ("own_s", "own_v", 0.05), ("short_s", "short_v", -0.01)):
        x = due[total] / due[weight]
        moved = x + min(max(1.0 - x, -max(step + 0.01, 0.0)), max(step + 0.01, 0.0))
        if total == "s":
            moved = min(x, 1.0) + min(1.0 - min(x, 1.0), 0.03)
        assert found[weight] == pytest.approx(3.0 * due[weight])
        assert found[total] == pytest.approx(moved * 3.0 * due[weight])
    assert (found["noise"], found["anew"]) == pytest.approx((4.0 * due["noise"], 2.0))
    assert (found["coins"], found["company"]) == (due["coins"], due["company"])
