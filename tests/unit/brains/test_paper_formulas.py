"""The shipped brains against the paper's formulas by hand and against the exact likelihood by brute force."""

import decimal
import functools
import math
from decimal import Decimal
from fractions import Fraction
from itertools import product

import pytest
from scipy.optimize import minimize_scalar

from swarmcensus import brains
from swarmcensus.support.errors import InputError

MINIMALISTIC = brains.load("minimalistic")
LEGACY = brains.load("legacy")
COUNTS = [(t, n) for t in (1, 2, 7, 40) for n in sorted({0, 1, t // 3, t // 2, t - 1, t}) if n <= t]
SENSORS = [(b, w) for b, w in product((0.05, 0.3, 0.525, 0.675, 0.9, 1.0), repeat=2) if abs(b + w - 1) > 1e-9]


def looked(t, n, b, w, brain=MINIMALISTIC):
    me = brain.robot(b, w)
    brain.functions.observe(me, float(n), float(t))
    return me


def unlikelihood(f, t, n, b, w):
    """-ln p(n blacks of t | f) without the binomial coefficient."""
    p = b * f + (1 - w) * (1 - f)
    terms = [c * math.log(q) if q > 0 else -math.inf for c, q in ((n, p), (t - n, 1 - p)) if c]
    return -sum(terms)


def likelihood(f, t, n, b, w):
    """ln p(n blacks of t | f) without the binomial coefficient, exact to 60 digits."""
    p = b * f + (1 - w) * (1 - f)
    parts = []
    for count, chance in ((n, p), (t - n, 1 - p)):
        if count:
            parts.append(count * chance.ln() if chance > 0 else Decimal("-Infinity"))
    return sum(parts, Decimal(0))


class TestLocalEstimate:
    @pytest.mark.parametrize(
        ("t", "n", "b", "w", "expected"),
        [
            (10, 4, 1.0, 1.0, 0.4),  # perfect sensors: n / t
            (10, 5, 0.8, 0.6, (0.5 + 0.6 - 1) / (0.8 + 0.6 - 1)),  # Eq. 4, second case
            (10, 3, 0.8, 0.6, 0.0),  # n <= (1 - w) t
            (10, 9, 0.8, 0.6, 1.0),  # n >= b t
            (10, 4, 0.8, 0.6, 0.0),  # at the lower end itself
            (10, 8, 0.8, 0.6, 1.0),  # at the upper end itself
            (10, 3, 0.2, 0.4, (0.3 + 0.4 - 1) / (0.2 + 0.4 - 1)),  # a liar, ends exchanged
            (10, 1, 0.2, 0.4, 1.0),
            (10, 7, 0.2, 0.4, 0.0),
        ],
    )
    def test_paper_by_hand(self, t, n, b, w, expected):
        assert looked(t, n, b, w).x_hat == pytest.approx(expected, abs=1e-14)

    @pytest.mark.parametrize(("b", "w"), SENSORS)
    def test_maximises_the_exact_likelihood(self, b, w):
        for t, n in COUNTS:
            cost = functools.partial(unlikelihood, t=t, n=n, b=b, w=w)
            x_hat = looked(t, n, b, w).x_hat
            brute = minimize_scalar(cost, bounds=(0.0, 1.0), method="bounded", options={"xatol": 1e-12})
            assert cost(x_hat) <= min(brute.fun, cost(0.0), cost(1.0)) + 1e-9 * t
            if min(cost(0.0), cost(1.0)) > brute.fun + 1e-6:
                assert x_hat == pytest.approx(brute.x, abs=1e-4)

    @pytest.mark.parametrize(("b", "w"), SENSORS)
    def test_a_liar_is_as_good_as_the_truthful(self, b, w):
        """Reading every colour the other way round is the same evidence."""
        for t, n in COUNTS:
            one, other = looked(t, n, b, w), looked(t, t - n, 1 - b, 1 - w)
            assert one.x_hat == pytest.approx(other.x_hat, abs=1e-12)
            assert one.alpha == pytest.approx(other.alpha, rel=1e-9)

    def test_observations_add_up(self):
        at_once, by_parts = looked(30, 17, 0.7, 0.8), MINIMALISTIC.robot(0.7, 0.8)
        for n, t in ((3, 10), (10, 10), (4, 10)):
            MINIMALISTIC.functions.observe(by_parts, float(n), float(t))
        assert (by_parts.x_hat, by_parts.alpha) == (at_once.x_hat, at_once.alpha)


class TestLocalConfidence:
    @pytest.mark.parametrize(("b", "w"), [s for s in SENSORS if 1.0 not in s])
    def test_paper_eq_5(self, b, w):
        """Eq. 5 as printed, in exact fractions, where it has no 0 / 0."""
        b, w = Fraction(b), Fraction(w)
        for t, n in COUNTS:
            x = looked(t, n, float(b), float(w))
            q = (b + w - 1) ** 2
            if x.x_hat == 0.0:
                expected = q * (t * w**2 - 2 * (t - n) * w + (t - n)) / (w**2 * (w - 1) ** 2)
            elif x.x_hat == 1.0:
                expected = q * (t * b**2 - 2 * n * b + n) / (b**2 * (b - 1) ** 2)
            else:
                expected = q * Fraction(t) ** 3 / (n * (t - n))
            assert x.alpha == pytest.approx(float(expected), rel=1e-9)

    @pytest.mark.parametrize(("b", "w"), SENSORS)
    def test_second_derivative_of_the_exact_likelihood(self, b, w):
        for t, n in COUNTS:
            me = looked(t, n, b, w)
            with decimal.localcontext(prec=80):
                h = Decimal("1e-25")
                db, dw = Decimal(b), Decimal(w)
                p = Decimal(n) / t if 0.0 < me.x_hat < 1.0 else None
                f = (p + dw - 1) / (db + dw - 1) if p is not None else Decimal(me.x_hat)
                points = (f - h, f, f + h)
                if any(likelihood(x, t, n, db, dw) == Decimal("-Infinity") for x in points):
                    pytest.fail("the likelihood vanishes beside its own maximum")
                low, mid, high = (likelihood(x, t, n, db, dw) for x in points)
                curvature = -(low - 2 * mid + high) / h**2
            assert me.alpha == pytest.approx(float(curvature), rel=1e-6)

    @pytest.mark.parametrize("n", [0, 4, 10])
    @pytest.mark.parametrize(("b", "w"), [(1.0, 1.0), (1.0, 0.7), (0.7, 1.0)])
    def test_limits_of_perfect_accuracies(self, n, b, w):
        """At b = 1 or w = 1 the values are those that accuracies just below approach."""
        near = looked(10, n, min(b, 1 - 1e-9), min(w, 1 - 1e-9))
        at = looked(10, n, b, w)
        assert at.x_hat == pytest.approx(near.x_hat, abs=1e-7)
        assert at.alpha == pytest.approx(near.alpha, rel=1e-6)

    def test_perfect_sensor_that_sees_one_colour(self):
        assert looked(8, 0, 1.0, 1.0).alpha == 8.0
        assert looked(8, 8, 1.0, 1.0).alpha == 8.0

    @pytest.mark.parametrize(("b", "w"), [(0.5, 0.5), (0.7, 0.3), (0.9, 0.1), (1.0, 0.0), (0.0, 1.0)])
    def test_no_information(self, b, w):
        me = looked(10, 6, b, w)
        assert (me.x_hat, me.alpha) == (0.5, 0.0)

    def test_before_the_first_observation(self):
        me = MINIMALISTIC.robot(0.8, 0.8)
        assert (me.x_hat, me.alpha, me.x) == (0.5, 0.0, 0.5)


class TestFusion:
    def test_eqs_6_to_8_by_hand(self):
        me = looked(10, 5, 0.9, 0.8)
        alpha, x_hat = me.alpha, me.x_hat
        for message in ((0.2, 3.0), (0.6, 1.0)):
            MINIMALISTIC.functions.receive(me, message)
        MINIMALISTIC.functions.fuse(me)
        assert me.beta == 4.0
        assert me.x_bar == pytest.approx((0.2 * 3 + 0.6 * 1) / 4)
        assert me.x == pytest.approx((alpha * x_hat + 4 * me.x_bar) / (alpha + 4))
        assert MINIMALISTIC.functions.estimate(me) == me.x

    def test_informed_estimate_minimises_the_papers_cost(self):
        me = looked(10, 5, 0.9, 0.8)
        heard = [(0.2, 3.0), (0.6, 1.0), (0.9, 0.5)]
        for message in heard:
            MINIMALISTIC.functions.receive(me, message)
        MINIMALISTIC.functions.fuse(me)
        terms = [(me.x_hat, me.alpha), *heard]
        brute = minimize_scalar(lambda x: sum(a * (x - m) ** 2 for m, a in terms), bounds=(0, 1), method="bounded")
        assert me.x == pytest.approx(brute.x, abs=1e-5)

    @pytest.mark.parametrize("brain", [MINIMALISTIC, LEGACY], ids=lambda b: b.name)
    def test_without_neighbours_the_last_social_value_stays(self, brain):
        me = looked(10, 5, 0.9, 0.8, brain)
        brain.functions.receive(me, (0.2, 3.0))
        brain.functions.fuse(me)
        social = me.x_bar, me.beta
        brain.functions.observe(me, 9.0, 10.0)
        brain.functions.fuse(me)
        assert (me.x_bar, me.beta) == social
        assert me.x == pytest.approx((me.alpha * me.x_hat + 0.2 * 3) / (me.alpha + 3))

    def test_neighbours_that_know_nothing(self):
        me = looked(10, 5, 0.9, 0.8)
        MINIMALISTIC.functions.receive(me, (0.5, 0.0))
        MINIMALISTIC.functions.fuse(me)
        assert me.beta == 0.0
        assert me.x == pytest.approx(me.x_hat)

    def test_legacy_by_hand(self):
        me = looked(10, 5, 0.9, 0.8, LEGACY)
        for message in ((0.2, 3.0), (0.6, 1.0)):
            LEGACY.functions.receive(me, message)
        LEGACY.functions.fuse(me)
        assert me.x_bar == pytest.approx(0.4)
        assert me.beta == pytest.approx(2 / (1 / 3 + 1 / 1))
        assert me.x == pytest.approx((me.alpha * me.x_hat + me.beta * 0.4) / (me.alpha + me.beta))

    def test_legacy_harmonic_mean_with_a_zero_is_zero(self):
        me = looked(10, 5, 0.9, 0.8, LEGACY)
        for message in ((0.2, 3.0), (0.5, 0.0)):
            LEGACY.functions.receive(me, message)
        LEGACY.functions.fuse(me)
        assert me.beta == 0.0

    @pytest.mark.parametrize(("b", "w"), SENSORS[::7])
    def test_both_brains_share_the_local_estimate(self, b, w):
        for t, n in COUNTS:
            one, other = looked(t, n, b, w), looked(t, n, b, w, LEGACY)
            assert (one.x_hat, one.alpha) == (other.x_hat, other.alpha)


class TestContract:
    GOOD = MINIMALISTIC.source

    def parse(self, source, tmp_path):
        path = tmp_path / "mine.py"
        path.write_text(source)
        return brains.load(path)

    def test_a_mind_holds_its_memory_and_nothing_else(self):
        me = MINIMALISTIC.robot(0.8, 0.8)
        with pytest.raises(AttributeError):
            me.diary = 1.0

    @pytest.mark.parametrize(
        ("change", "said"),
        [
            (("def observe(me, blacks, looks):", "def observe(me, blacks, looks:"), "not Python"),
            (("def fuse(me):", "def fuze(me):"), "the function fuse is missing"),
            (("def broadcast(me):", "def broadcast(me, you):"), "broadcast takes 2 arguments: 1 are right"),
            (("MEMORY = {", "MEMORIES = {"), "MEMORY is missing"),
            (
                ('MESSAGE = ("x_hat", "alpha")', 'MESSAGE = "x_hat"'),
                "MESSAGE is 'x_hat', a text: a tuple of one name is",
            ),
            (('SUMS = ("heard",', 'SUMS = ("overheard",'), "SUMS names 'overheard'"),
            (('"t": 0.0', '"b": 0.0'), "reserved by the engine"),
            (('"t": 0.0', '"t": "zero"'), "not a number"),
            (('"t": 0.0', '"t t": 0.0'), "not a name"),
            (("MEMORY = {", "import os\nMEMORY = {"), "line 7: imports os"),
            (("    return me.x\n", "    return [me.x][0]\n"), "List in estimate"),
            (("    return me.x\n", "    return (lambda: me.x)()\n"), "Lambda in estimate"),
            (("def estimate(me):", "@staticmethod\ndef estimate(me):"), "decorator"),
            (("MEMORY = {", "class Diary: pass\nMEMORY = {"), "constants and small functions"),
            (("MEMORY = {", "print('hello')\nMEMORY = {"), "constants and small functions"),
            (("MEMORY = {", "X = 1 / 0\nMEMORY = {"), "a constant has no value: division by zero"),
            (("MEMORY = {", "X = {{}: 1.0}\nMEMORY = {"), "keys of a dict should be numbers or texts"),
            (("MEMORY = {", "X = {({},): 1.0}\nMEMORY = {"), "keys of a dict should be numbers or texts"),
            (("def estimate(me):", "def estimate(me):\n    estimate(me)"), "line 89: estimate calls itself"),
            (
                ("def fuse(me):", "def far(me):\n    near(me)\n\n\ndef near(me):\n    far(me)\n\n\ndef fuse(me):"),
                r"line \d+: (far calls near, which calls far|near calls far, which calls near): functions of a brain",
            ),
        ],
    )
    def test_faults_are_named(self, change, said, tmp_path):
        assert change[0] in self.GOOD
        with pytest.raises(InputError, match=said if "|" in said else said.replace("(", r"\(")) as caught:
            self.parse(self.GOOD.replace(*change), tmp_path)
        assert "mine.py" in str(caught.value)

    @pytest.mark.parametrize(
        "line",
        [
            "pow = eval",
            "pow = me.x; pow(me.x, 2)",
            "for pow in range(2): pow(2, 2)",
            "min((pow := me.x), 1.0); pow(2, 2)",
            "(abs, *pow) = (1, 2); pow(2, 2)",
            "del pow; pow(2, 2)",
            "math = me; math.sqrt(2.0)",
            "me.x = getattr",
            "me.x = __loader__",
            "__loader__('os')",
            "me.x = min(1, 2, key=exec)",
            "text = '{0.__class__}'; max(me, me, key=text.format)",
            "x = me.__class__",
            "me.__class__ = 1",
            "math.__loader__.load_module('os')",
            "math.__getattribute__('pi')",
            "x = math.sin.__self__",
            "math.pi = 3.0",
            "fuse.heard = 1.0",
            "me.x.real.imag",
            "raise SystemExit",
            "raise ValueError('no')",
            "assert print(1)",
            "x = f'{print(1)}'",
            "x: eval('1') = 1; x(2)",
            "try: me.x\n    except* ValueError as pow: pow(2, 2)",
            "with me as pow: pow(2, 2)",
            "import os as pow",
            "global pow; pow = 1",
            "async def pow(): pass",
            "x = [pow for pow in (1, 2)]",
            "x = (lambda pow: pow)(1)",
            "yield",
        ],
    )
    def test_no_line_reaches_code_that_the_contract_does_not_name(self, line, tmp_path):
        with pytest.raises(InputError, match=r"mine\.py, line \d+: "):
            self.parse(self.GOOD.replace("    return me.x\n", f"    {line}\n    return me.x\n"), tmp_path)

    @pytest.mark.parametrize(
        "head",
        [
            "# coding: utf-7",
            "from math import __loader__ as math",
            "from .math import sqrt",
            "from math import sqrt, __loader__ as root",
            "fuse = 1.0",
            "def first(me, pow=print(1)):\n    pass",
            "def first(me: print(1)):\n    pass",
            "def first(me, *, pow: print(1)):\n    pass",
            "def first(me, *pow):\n    pass",
            "def first(me) -> print(1):\n    pass",
            "@print\ndef first(me):\n    pass",
            "X: print(1) = 1",
            "if print(1): X = 1",
            "X = (Y := 1)",
            "X[0] = 1",
            "X = f'{1}'",
        ],
    )
    def test_no_first_line_runs_code(self, head, tmp_path, capsys):
        with pytest.raises(InputError, match=r"mine\.py"):
            self.parse(f"{head}\n{self.GOOD}", tmp_path)
        assert not capsys.readouterr().out

    def test_names_that_are_not_called_may_hide_functions(self, tmp_path):
        own = "    round, pow, fuse = 1.0, 2.0, 3.0\n    if round > pow + fuse:\n        raise ValueError\n"
        self.parse(f"# coding: utf8\n{self.GOOD}".replace("    return me.x\n", f"{own}    return me.x\n"), tmp_path)

    def test_no_such_brain(self):
        with pytest.raises(InputError, match="neither a shipped brain"):
            brains.load("nobody")

    def test_not_text(self, tmp_path):
        (tmp_path / "mine.py").write_bytes(b"\xff\xfe\x00")
        with pytest.raises(InputError, match="cannot be read as text"):
            brains.load(tmp_path / "mine.py")
