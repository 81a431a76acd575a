"""Grids of settings: the full one and each case's, and arenas by their side."""

import pytest

import swarmcensus as sc
from swarmcensus.studies import addresses
from swarmcensus.studies.coordinates import coordinates_of
from swarmcensus.support.formatting import counted
from swarmcensus.worlds import arena
from swarmcensus.worlds.bodies import Body

BASE = {
    "trials": 1,
    "swarm": {"robots": [10, 20], "accuracy": 0.7},
    "world": {"topology": "ring", "fill_ratio": 0.5},
    "schedule": {"rounds": 50},
}
MOVING = BASE | {"world": {"topology": "moving", "fill_ratio": 0.5}, "schedule": {"ticks": 50}}


def study(base=BASE, **changes):
    return sc.Study(**{k: base.get(k, {}) | v if isinstance(v, dict) else v for k, v in (base | changes).items()})


def lines(made):
    return [(s.brain.name, str(s.topology), s.robots, s.rounds) for s in made.settings()]


def refused(base=BASE, **changes):
    with pytest.raises(sc.InputError) as caught:
        study(base, **changes)
    return str(caught.value)


# ---- cases


def test_each_case_adds_a_grid_of_its_own():
    made = study(case=[{"robots": [100, 200], "rounds": 500}, {"topology": ["full", "line"], "brain": "legacy"}])
    assert lines(made) == [
        ("minimalistic", "ring", 10, 50), ("minimalistic", "ring", 20, 50),
        ("minimalistic", "ring", 100, 500), ("minimalistic", "ring", 200, 500),
        ("legacy", "full", 10, 50), ("legacy", "full", 20, 50), ("legacy", "line", 10, 50), ("legacy", "line", 20, 50),
    ]  # fmt: skip
    assert made.checkpoints[-1] == 500
    assert [b.name for b in made.brains] == ["minimalistic", "legacy"]
    assert [t.name for t in made.topologies] == ["ring", "full", "line"]
    assert sc.Study.parse(made.text).settings() == made.settings()
    again = study(case=[{"robots": [20, 30]}, {"robots": [30, 40]}])
    assert [s.robots for s in again.settings()] == [10, 20, 30, 40]  # each once


def test_a_case_may_move_where_the_rest_stands():
    made = study(case=[{"topology": "moving", "side": 3.0, "ticks": "10 s", "floor": "half"}])
    moving = [s for s in made.settings() if s.body]
    assert [(s.robots, s.rounds, s.side, str(s.floor)) for s in moving] == [
        (10, 100, 3.0, "half"),
        (20, 100, 3.0, "half"),
    ]
    # what the base says of fixed networks is left out there, and the other way round
    back = study(MOVING, world={"density": 1.0, "floor": "half"}, case=[{"topology": "ring", "rounds": 9}])
    assert [(s.density, s.floor, s.rounds) for s in back.settings()[2:]] == [(None, None, 9)] * 2
    # a case's density stands in place of the base's side
    other = study(MOVING, world={"side": 3.0}, case=[{"density": 2.0}])
    assert [s.density for s in other.settings()[2:]] == [2.0, 2.0]


@pytest.mark.parametrize(
    ("case", "said"),
    [
        ([{"robots": 5}, {"robotz": 5}], "unknown key case[1].robotz: did you mean 'robots'?"),
        ([{"body": {}}], "unknown key case[0].body"),
        ([{"robots": [10, 20]}], "case[0] adds no setting"),
        ([{"robots": 5}, {"robots": 5}], "case[1] adds no setting"),
        ([{"robots": [5, 5]}], "a value is twice in a list"),
        ([{"ticks": 5}], "case[0].ticks"),
        ([{"topology": "moving", "side": 1, "rounds": 5}], "case[0].rounds"),
        ([{"topology": "moving"}], "case[0]: world.density is missing"),
        ([{"accuracy": [0.7, 1.5]}], "case[0].accuracy[1] = 1.5"),
        ([{"topology": {"name": "far", "edges": [[0, 19]]}}], "edge (0, 19) of topology 'far' leads to a robot"),
        ([{"topology": {"name": "x", "edges": [[0, 1]]}}, {"topology": {"name": "x", "edges": [[0, 2]]}}],
         "two topologies of world.topology and of cases have one name: x"),
        ({"robots": 5}, "case = {robots = 5}"),
        ([{"accuracy": [k / 999 for k in range(999)], "fill_ratio": [k / 999 for k in range(999)]}], "its lists span"),
        ([{"robots": 2**31 - 1}], "values to keep"),
    ],
)  # fmt: skip
def test_what_is_wrong_with_a_case_is_named(case, said):
    assert said in refused(case=case)


def test_checks_hold_for_every_grid():
    assert "faults[0].robots = 8: there are 5 robots" in refused(
        faults=[{"at": 1, "robots": 8, "stop": "talking"}], case=[{"robots": 5}]
    )
    assert "measure.local = true" in refused(
        measure={"local": True}, case=[{"topology": "moving", "side": 3, "ticks": 9}]
    )
    assert study(measure={"checkpoints": 90}, case=[{"rounds": 90}]).checkpoints == [90]
    assert "comes after the last round, 90" in refused(measure={"checkpoints": 91}, case=[{"rounds": 90}])
    with pytest.warns(UserWarning, match="carries no information"):
        study(case=[{"accuracy": 0.5}])


def test_results_of_cases_are_run_kept_and_replayed(here):
    (here / "net.csv").write_text("u,v\n0,1\n1,2\n")
    network = {"file": "net.csv", "directed": True}
    case = {"brain": "legacy", "topology": network, "robots": 4, "rounds": 6}
    made = study(trials=2, swarm={"robots": 3}, schedule={"rounds": 4}, case=[case])
    sc.save(sc.run(made, jobs=1), here / "r.nc")
    (here / "net.csv").unlink()
    kept = sc.load(here / "r.nc")
    assert kept["brain"].values.tolist() == ["minimalistic", "legacy"]
    assert kept["edges_net"].attrs["directed"] == 1
    assert sc.replay(kept, 1, 1).sizes["round"] == 7
    assert not sc.verify(kept, sample=1.0, jobs=1).differences


# ---- side


def test_a_side_is_a_density_for_each_number_of_robots():
    made = study(MOVING, world={"side": [2.0, 3.7]}, swarm={"robots": [7, 25]})
    for setting, side in zip(made.settings(), [2.0, 3.7] * 2, strict=True):
        assert arena.side(setting.robots, setting.density, Body()) == pytest.approx(side, rel=1e-12)
        assert coordinates_of(setting)["side"] == side
    [equal] = study(MOVING, world={"density": made.settings()[3].density}, swarm={"robots": 25}).settings()
    assert addresses.fingerprint(equal, 1) == addresses.fingerprint(made.settings()[3], 1)


@pytest.mark.parametrize("robots", [1, 5, 25, 333])
def test_the_sizes_that_messages_name_are_taken(robots):
    for key, wrong in (("side", 0.01), ("density", 1000)):
        swarm = {"robots": robots}
        said = refused(MOVING, world={key: wrong}, swarm=swarm)
        assert f"world.{key} = {float(wrong)}: the arena cannot hold {counted(robots, 'robot')}" in said
        study(MOVING, world={key: float(said.removesuffix(" m").split()[-1])}, swarm=swarm)


def test_one_of_density_and_side_is_wanted():
    assert "world.density is missing" in refused(MOVING)
    assert "world.density and world.side both say" in refused(MOVING, world={"side": 3, "density": 1})
    assert 'world.side is of robots that move: it goes with topology = "moving"' in refused(world={"side": 3})
    assert "tiles wide" in refused(MOVING, world={"side": 1e9}, swarm={"robots": 1})
