"""Times with a unit, wherever a study counts ticks."""

import pytest
from PIL import Image

import swarmcensus as sc
from swarmcensus.cli.commands import main
from swarmcensus.studies import addresses
from swarmcensus.support.times import parse_time

STUDY = {
    "trials": 1,
    "swarm": {"robots": 5, "accuracy": 0.7},
    "world": {"topology": "moving", "side": 3, "fill_ratio": 0.5},
}


def study(world={}, **tables):  # noqa: B006
    return sc.Study(**STUDY | {"world": STUDY["world"] | world} | tables)


@pytest.mark.parametrize(
    ("text", "tick", "ticks"),
    [("17 min", 0.1, 10_200), ("90 s", 0.1, 900), ("1 h", 0.1, 36_000), ("0.3 s", 0.1, 3), ("1.5min", 0.25, 360),
     (" 2e1 s ", 0.7, None), ("21 s", 0.7, 30), ("7 s", 1 / 3, 21), ("100000.05 s", 0.1, None)],
)  # fmt: skip
def test_times_are_whole_numbers_of_ticks(text, tick, ticks):
    if ticks is None:
        with pytest.raises(ValueError, match="should be a whole number, such as"):
            parse_time(text).ticks(tick)
    else:
        assert parse_time(text).ticks(tick) == ticks


def test_every_key_that_counts_ticks_takes_times():
    made = study(
        schedule={"ticks": ["17 min", 300, "2 min"]},
        measure={"checkpoints": ["1 min", 7]},
        faults=[{"at": "5 s", "robots": 1, "stop": "talking"}],
        case=[{"ticks": "1 h", "robots": 3}],
        world={"body": {"message_delay": "0.4 s"}},
    )
    assert [s.rounds for s in made.settings()] == [10_200, 300, 1200, 36_000]
    assert made.checkpoints == [7, 600]
    assert [(f.at, s.body.message_delay) for s in made.settings() for f in s.faults] == [(50, 4)] * 4
    again = sc.Study.parse(made.text)
    assert '"17 min"' in made.text
    assert [addresses.fingerprint(s, 1) for s in again.settings()] == [
        addresses.fingerprint(s, 1) for s in made.settings()
    ]
    slow = study(schedule={"ticks": "17 min"}, world={"body": {"tick": 0.5, "message_delay": "0 s"}})
    assert [(s.rounds, s.body.message_delay) for s in slow.settings()] == [(2040, 0)]


@pytest.mark.parametrize(
    ("tables", "said"),
    [
        ({"schedule": {"ticks": "1.25 s"}},
         'schedule.ticks = "1.25 s": that is 12.5 ticks of 0.1 s: should be a whole number, such as "1.2 s" (12) or '
         '"1.3 s" (13)'),
        ({"schedule": {"ticks": ["1 s", "0 s"]}}, 'such as "0.1 s" (1)'),
        ({"schedule": {"ticks": "1e999 h"}}, "2,147,483,647 at the most"),
        ({"schedule": {"ticks": "5 m"}}, "(s, min or h)"),
        ({"schedule": {"ticks": ["1 s", 10]}}, "a value is twice in a list"),
        ({"case": [{"ticks": "0.25 s"}]}, 'case[0].ticks = "0.25 s"'),
        ({"faults": [{"at": "0.25 s", "robots": 1, "stop": "moving"}]}, 'faults[0].at = "0.25 s"'),
        ({"measure": {"checkpoints": "0.25 s"}}, 'measure.checkpoints = "0.25 s"'),
        ({"world": {"body": {"message_delay": "0.25 s"}}}, 'world.body.message_delay = "0.25 s"'),
        ({"world": {"body": {"message_delay": "9 h"}}}, "less than or equal to 1,000"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_named(tables, said):
    with pytest.raises(sc.InputError) as caught:
        study(**tables)
    assert said in str(caught.value)


def test_rounds_have_no_clock():
    both = {"topology": ["ring", "moving"]}
    for tables, key in (
        ({"faults": [{"at": "5 s", "robots": 1, "stop": "talking"}]}, "faults[0].at"),
        ({"measure": {"checkpoints": [3, "5 s"]}}, "measure.checkpoints"),
    ):
        with pytest.raises(sc.InputError) as caught:
            study(both, **tables)
        assert f'{key} = "5 s": the rounds of fixed networks have no clock' in str(caught.value)
    assert {s.rounds for s in study(both, schedule={"ticks": "1 s"}).settings()} == {1000, 10}
    with pytest.raises(sc.InputError, match="should be a valid integer"):
        study(both, schedule={"rounds": "5 s"})


@pytest.mark.long
def test_commands_take_times(here, refused, capsys):
    made = study({"body": {"tick": 0.5}}, schedule={"ticks": 20}, measure={"checkpoints": [12, 20]})
    sc.save(sc.run(made), "m.nc")

    def shown(*command):
        assert main(["show", "m.nc", *command]) == 0
        return capsys.readouterr().out

    assert shown("--checkpoint", "0.1 min") == shown("--checkpoint", "12") != shown()
    plot = ["plot", "m.nc", "--kind"]
    for name, tick in (("a.png", "4 s"), ("b.png", "8")):
        assert main([*plot, "arena", "--tick", tick, "--out", name]) == 0
    assert (here / "a.png").read_bytes() == (here / "b.png").read_bytes()
    capsys.readouterr()
    size = ["--width", "4", "--height", "5", "--dpi", "50"]
    assert main([*plot, "film", *size, "--first", "2 s", "--last", "4 s", "--every", "1", "--out", "f.gif"]) == 0
    assert capsys.readouterr().out == "f.gif: 5 frames\nf.gif.caption.txt\n"
    with Image.open("f.gif") as picture:
        assert picture.size == (200, 250)
    assert "that is 10.6 ticks of 0.5 s" in refused("show", "m.nc", "--checkpoint", "5.3 s")
    assert "--tick '1 h': this trial has ticks 0 to 20" in refused(*plot, "arena", "--tick", "1 h")
