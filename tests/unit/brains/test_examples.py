"""The examples of the contract's optional functions: they keep it, and are of use."""

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus import brains
from tests.support.places import EXAMPLE

BRAINS = ["pairwise", "prior", "histogram", "quiet", "sprt", "leader", "liar", "forgetful"]


def ran(name, **tables):
    """A study's results, with fewer trials and rounds."""
    schedule = {"rounds": 200, "observations_per_round": 10}
    return sc.run(sc.Study.load(EXAMPLE / f"{name}.toml").with_(trials=4, schedule=schedule, **tables), jobs=2)


def test_each_uses_what_it_is_there_to_show():
    used = {name: brains.load(EXAMPLE / f"{name}.py") for name in BRAINS}
    assert used["pairwise"].uses.random == {"receive"}
    assert used["prior"].parameters == {"prior": 10.0, "expected": 0.5}
    assert used["histogram"].lengths["belief"] == used["histogram"].options == 10
    assert used["quiet"].uses.silence
    assert used["sprt"].decides
    assert used["sprt"].ends
    assert used["leader"].uses.name
    assert all(len(one.source.splitlines()) < 80 for one in used.values())


@pytest.mark.long
def test_all_believe_better_than_chance():
    """Nearer to the truth than 0.5, which is believed before anything is seen; decisions are mostly right."""
    data = ran("optional-functions")
    off = abs(data["final_estimate"] - data["fill_ratio"]).median(["trial", "robot"])
    assert (off < 0.05).all()
    better = data["brain"].isin(["minimalistic", "pairwise.py", "prior.py"]).values
    assert (off.values[better] < 0.02).all()
    decided = data["right_option"].notnull().any("trial").values
    right = (data["decision"] == data["right_option"]).mean(["trial", "robot"]).values[decided]
    assert set(data["brain"].values[decided]) == {"histogram.py", "sprt.py"}
    assert (right > 0.85).all()


@pytest.mark.long
def test_the_more_liars_the_more_wrong():
    data = ran("liars")
    assert set(data["members"].values) == {"", *(f"0.{k} liar.py, not honest" for k in (1, 2, 3))}
    for brain in ("my_brain.py", "pairwise.py", "quiet.py"):
        for topology in ("ring", "scale-free"):
            some = data.sel(setting=((data["brain"] == brain) & (data["topology"] == topology)).values)
            off = np.nanmedian(abs(some["final_estimate"] - 0.75).values, axis=(1, 2))
            assert (np.diff(off) > 0).all()


@pytest.mark.long
def test_who_forgets_notices_that_the_floor_is_another():
    """Of rounds from the change on: the sooner it forgets the sooner, and who remembers all does not in this time."""
    study = sc.Study.load(EXAMPLE / "changing.toml").with_(trials=4)
    assert [study.trials, *(len(grid.world.fill_ratio) for grid in study.grids)] == [4, 2, 1]
    data = sc.run(study, jobs=2)
    way, half = data["fill_ratio_change"].values, data["half"].values
    rounds = np.median(data["recovery_time"], axis=(1, 2))
    for change in ("0.85 to 0.25 at 300", "0.85 to 0.25 at 300 until 700"):
        never, soon, late = (
            rounds[(way == change) & chosen][0] for chosen in (np.isnan(half), half == 30, half == 100)
        )
        assert never == np.inf
        assert soon < 150
        assert soon < 0.5 * late < 200
    before = data["correct"].sel(checkpoint=[100, 299]).values[way != ""]
    assert (before == 1).mean() > 0.9
    # nobody notices that the sensors wear: as 0.9 is believed and 0.65 is true, 0.25 is taken for more
    wrapped = np.median(data["final_estimate"].values[way == ""], axis=(1, 2))
    assert (wrapped > 0.3).all()
