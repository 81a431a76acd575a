"""Single precision over a day: where it leaves double precision, and that brains that halve their sums stay."""

import json

import pytest

from swarmcensus import brains
from swarmcensus.cli.commands import main
from swarmcensus.conformance import single_life, suite
from swarmcensus.conformance.single_lives import single_lives
from tests import ring_days

LONG_LIVED = ("commons", "swift", "tracking", "steadfast")
WITHOUT = {"commons": "    if me.v > MOST:\n        me.s *= 0.5\n        me.v *= 0.5\n"}


def with_sums(name, s, v):
    """A mind with large sums, alone, after a round in which it saw and heard nothing."""
    brain = brains.load(name)
    me = brain.robot(0.8, 0.8)
    for field in ("s", "mean_s", "long_s"):
        if hasattr(me, field):
            setattr(me, field, s)
            setattr(me, field[:-1] + "v", v)
    brain.functions.fuse(me)
    return me


class TestHalving:
    @pytest.mark.parametrize(("name", "field"), [("commons", "v"), ("steadfast", "v"), ("tracking", "long_v")])
    def test_from_two_to_the_fourteenth_on(self, name, field):
        """Not a bit changes up to there; above, both sums are half of what they were, and their ratio is the same."""
        below, above = with_sums(name, 8000.0, 16384.0), with_sums(name, 8000.0, 16385.0)
        other = field[:-1] + "s"
        assert (getattr(below, other), getattr(below, field)) == (8000.0, 16384.0)
        assert (getattr(above, other), getattr(above, field)) == (4000.0, 8192.5)

    def test_swift_halves_all_that_is_linear(self):
        """After 2^16 rounds without momentum; what it estimates stays, up to the prior."""
        brain = brains.load("swift")
        me = brain.robot(0.8, 0.8)
        me.s, me.v, me.mean_s, me.mean_v, me.said_s, me.said_v = 9.0, 20.0, 9.0, 20.0, 8.5, 19.0
        me.unit, me.said_unit, me.rounds, me.company = 65536.0, 65535.0, 65536.0, -1.0
        brain.functions.fuse(me)
        assert (me.s, me.v, me.mean_s, me.mean_v, me.said_s, me.said_v) == (4.5, 10.0, 4.5, 10.0, 4.5, 10.0)
        assert (me.unit, me.said_unit, me.rounds) == (32768.5, 32768.5, 32768.5)

    def test_a_robot_alone_still_knows_what_the_page_says(self):
        """With weights 1 for the last 2^13 of evidence, 1/2 for those before, and so on: 1.5 * 2^14 readings count."""
        weights = [1.0] * 8192 + [0.5] * 8192 + [0.25] * 8192 + [0.125] * 8192 + [0.0625] * 8192
        counting = sum(weights) ** 2 / sum(w * w for w in weights)
        assert 0.5 * counting**-0.5 < 0.0033

    @pytest.mark.parametrize("robots_ahead", [1, 3])
    def test_robots_that_halve_first_do_not_bias_the_others(self, robots_ahead):
        """All robots have the same ratio of expected sums; so has every mean of them, halved or not."""
        brain = brains.load("commons")
        swarm = [brain.robot(0.8, 0.8) for _ in range(6)]
        for k, me in enumerate(swarm):
            me.v = 16384.0 + (100.0 if k < robots_ahead else -100.0)
            me.s = 0.55 * me.v
        for _ in range(50):
            said = [brain.functions.broadcast(me) for me in swarm]
            for k, me in enumerate(swarm):
                brain.functions.receive(me, said[k - 1])
                brain.functions.fuse(me)
        assert all(me.s / me.v == pytest.approx(0.55, abs=1e-12) for me in swarm)


class TestDays:
    """A day of a swarm at 10 Hz, a fifth of the messages lost; `swift` keeps its momentum only if none is."""

    @pytest.mark.long
    @pytest.mark.parametrize("name", [*LONG_LIVED, "self-taught"])
    def test_a_swarm_lives_a_day_in_single_precision(self, name):
        loss = 0.0 if name == "swift" else 0.2
        assert ring_days.median_error(brains.load(name), "single", single_life.DAY, loss) < 0.003

    @pytest.mark.long
    def test_swift_would_not_without_the_halving(self, tmp_path):
        source = brains.load("swift").source
        halving = "    if me.unit > MOST:\n        halve(me)\n"
        assert halving in source
        file = tmp_path / "unhalved.py"
        file.write_text(source.replace(halving, ""))
        assert ring_days.median_error(brains.load(file), "single", single_life.DAY, 0.0) > 0.01


class TestLives:
    def test_commons_needs_the_halving(self, tmp_path):
        """Without it, single precision leaves double precision within 2^26 readings."""
        source = brains.load("commons").source
        assert WITHOUT["commons"] in source
        file = tmp_path / "unhalved.py"
        file.write_text(source.replace(WITHOUT["commons"], ""))
        assert single_life.life(brains.load(file), 1000, beyond=True).first is not None
        assert single_life.life(brains.load("commons"), 1000, beyond=True) == (None, None)

    def test_counts_end_at_two_to_the_twenty_fourth(self):
        lived = single_life.life(brains.load("minimalistic"), beyond=True)
        assert 2**24 < lived.first < 2**24 + 250_000

    def test_the_very_reading_is_named(self, tmp_path):
        """At the reading 5,000 the sum is 2^24 + 1, which float32 has not."""
        source = brains.load("alone").source.partition("def estimate")[0]
        late = "def estimate(me):\n    return 1.0 if 16777216.0 + (me.t - 4999.0) > 16777216.5 else 0.0\n"
        file = tmp_path / "late.py"
        file.write_text(source + late)
        assert single_life.life(brains.load(file), 6000) == (5000, 5000)
        assert single_life.life(brains.load(file), 4999) == (None, None)

    @pytest.mark.long(but=["commons", "minimalistic"])
    @pytest.mark.parametrize("name", brains.shipped())
    def test_the_table_is_what_is_found(self, name):
        assert single_life.life(brains.load(name), beyond=True).first == single_lives()[name]

    def test_the_table_has_all(self):
        assert [*single_lives()] == brains.shipped()
        assert all(single_lives()[name] is None or single_lives()[name] > single_life.DAY for name in LONG_LIVED)


class TestShell:
    def test_check_says_at_which_reading(self, tmp_path, monkeypatch, capsys):
        monkeypatch.setattr(suite, "check", lambda path, wearing="": [suite.Check(suite.KEEPS, None)])
        assert main(["brains", "--check", "minimalistic", "--single", "--json"]) == 0
        found = json.loads(capsys.readouterr().out)
        assert found["single"] == {"alone": None, "hearing": None}
        assert found["notes"] == [
            "single precision stays within 0.01 of double precision for a day at 10 Hz, which is 864,000 readings"
        ]

    def test_it_needs_a_file(self, capsys):
        assert main(["brains", "--single"]) == 2
        assert "--single needs --check" in capsys.readouterr().err

    def test_the_list_has_a_column(self, capsys):
        assert main(["brains", "--json"]) == 0
        rows = {row["name"]: row for row in json.loads(capsys.readouterr().out)["brains"]}
        assert rows["minimalistic"]["single_precision_readings"] == single_lives()["minimalistic"]
