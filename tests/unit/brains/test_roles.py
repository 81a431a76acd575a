"""What a brain says of its message: roles, by its own word or by the usual names; and what is no opinion."""

import pytest

from swarmcensus import brains
from swarmcensus.support.errors import InputError
from tests.support.lying import RICH
from tests.support.second import MEANS, brain, changed

BOTH = changed(("(estimate(me),)", "(estimate(me), me.n)"), ('("x",)', '("x", "n")'))


def with_roles(text):
    return changed(("MEMORY = {", f"ROLES = {text}\nMEMORY = {{"), source=BOTH)


def test_usual_names_are_known_and_others_are_told():
    assert brain(BOTH).roles == {"x": "estimate"}
    assert brains.load("minimalistic").roles == {"x_hat": "estimate", "alpha": "confidence"}
    assert brain(with_roles('{"n": "confidence"}')).roles == {"n": "confidence"}
    assert brain(RICH).roles["belief"] == "belief"
    assert not brain(BOTH).is_opinion
    assert brain(changed(("MEMORY = {", "OPINION = True\nMEMORY = {"))).is_opinion


@pytest.mark.parametrize(
    ("roles", "said"),
    [
        ('("n",)', 'ROLES should be a dict such as {"x_hat": "estimate"}'),
        ('{"y": "estimate"}', "ROLES names 'y', which is not in MESSAGE"),
        ('{"n": "truth"}', "ROLES['n'] = 'truth': should be one of estimate, opinion, option, belief, confidence"),
        ('{"n": "belief"}', "ROLES['n'] = 'belief': a belief is a vector, and other roles are numbers"),
        ('{"n": "information"}', "ROLES names an information but no confid"),
    ],
)
def test_wrong_roles_are_told(roles, said):
    with pytest.raises(InputError) as error:
        brain(with_roles(roles))
    assert said in str(error.value)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("MEMORY = {", "OPINION = 1\nMEMORY = {", "OPINION = 1"),
        ("MEMORY = {", "jam = 3\nMEMORY = {", "jam is 3, not a function"),
    ],
)
def test_wrong_opinions_and_noises_are_told(old, new, said):
    with pytest.raises(InputError) as error:
        brain(changed((old, new)))
    assert said in str(error.value)


def test_a_brain_that_makes_noise_has_no_sums():
    source = brains.load("minimalistic").source + "\n\ndef jam(me):\n    return me.t > 5.0\n"
    with pytest.raises(InputError, match="SUMS cannot be combined with jam"):
        brain(source)
    with pytest.raises(InputError, match=r"line 29: jam may end without returning"):
        brain(MEANS + "\n\n\ndef jam(me):\n    if me.t > 1.0:\n        return True\n")
