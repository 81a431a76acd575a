"""Adversaries in studies: how they are named, what results say of them, and that results stand for themselves."""

import json
import pickle
import re
from pathlib import Path

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus.cli.commands import main
from swarmcensus.results.merging import merge
from swarmcensus.runs import clusters
from swarmcensus.runs.verifying import verify
from swarmcensus.studies import addresses
from swarmcensus.summaries.selecting import where
from tests.support.second import MEANS
from tests.support.small import study_of

pytestmark = pytest.mark.interpreted

MINE = '"""Grey: it says one half, and a little more each round."""\n\nPARAMETERS = {"more": 0.01}\nMEMORY = {"k": 0.0}\n\n\ndef lie(me, x):\n    return 0.5 + me.k\n\n\ndef plot(me):\n    me.k += me.more\n'  # noqa: E501
STUDY = """
name = "liars"
seed = 5
trials = 3
swarm = {brain = ["minimalistic", "legacy"], robots = 10, accuracy = 0.8}
world = {topology = "ring", fill_ratio = 0.3}
schedule = {rounds = 12}
[[members]]
robots = [0, 1, 0.3]
brain  = ["always-black", {file = "slow-liar", pace = [0.01, 0.02]}, "jammer", "grey.py"]
honest = false
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("liars")
    (folder / "grey.py").write_text(MINE)
    (folder / "s.toml").write_text(STUDY)
    sc.save(sc.run(sc.Study.load(folder / "s.toml"), jobs=1), folder / "s.nc")
    return folder


@pytest.fixture
def here(folder, monkeypatch):
    monkeypatch.chdir(folder)
    return folder


@pytest.fixture
def data(folder):
    return sc.load(folder / "s.nc")


@pytest.mark.long
def test_liars_are_a_number_and_have_a_name(data):
    assert data.sizes["setting"] == 2 * (1 + 2 * 5)
    assert data["liars"].values.tolist() == 2 * ([0] + [1] * 5 + [3] * 5)
    who = ["always-black", "slow-liar pace=0.01", "slow-liar pace=0.02", "jammer", "grey.py"]
    assert data["adversary"].values.tolist() == 2 * ["", *who, *who]
    assert data["members"].values[6] == "0.3 always-black, not honest"
    known = np.isfinite(data["final_estimate"].values[:11]).sum(axis=(1, 2))
    assert (known == 3 * (10 - data["liars"].values[:11])).all()
    assert json.loads(data.attrs["brains"]).keys() == {"minimalistic", "legacy"}
    assert json.loads(data.attrs["adversaries"]).keys() == {"always-black", "slow-liar", "jammer", "grey.py"}
    assert where(data, "liars == 3 and adversary == 'jammer'").sizes["setting"] == 2
    assert where(data, "liars < 2").sizes["setting"] == 12


def test_liars_shift_what_the_honest_believe(data):
    """Towards black, and the more of them the farther; grey ones towards one half; who is jammed hears nothing."""
    ours = data.isel(setting=data["brain"].values == "legacy")
    mean = dict(zip(zip(ours["adversary"].values.tolist(), ours["liars"].values.tolist(), strict=True),
                    ours["final_estimate"].mean(["trial", "robot"]).values.tolist(), strict=True))  # fmt: skip
    assert mean["", 0] < mean["always-black", 1] < mean["always-black", 3]
    assert mean["", 0] < mean["grey.py", 3] < mean["always-black", 3]
    heard = where(data, "adversary == 'jammer' and liars == 1")["messages_heard"]
    assert (heard.sum(["robot"]).values == 9 * 24 - 24 - 2 * 12).all()  # 9 honest ones; two hear none; noise is none


# ---- results stand for themselves
def test_a_trial_is_replayed(here, data):
    for setting in (0, 6, 7, 21):
        assert sc.replay(data, setting=setting, trial=1).sizes["robot"] == 10
    assert np.isfinite(sc.replay(data, setting=7, trial=0)["liar_far"].values[-1]).sum() == 3
    assert (sc.replay(data, setting=7, trial=0)["liar_far"].max() == pytest.approx(0.12)).item()


def test_a_change_is_noticed(here, data):
    data["final_estimate"].values[6, 0, 0] += 1e-15
    data["liars"].values[3] = 2
    found = verify(data, sample=1.0)
    assert [str(one).partition(":")[0] for one in found.differences] == ["setting 6, trial 0"]
    assert found.labels == ["setting 3: liars is 2 in the file and 1 by its study"]
    changed = data.assign_attrs(adversaries=data.attrs["adversaries"].replace("0.5 + me.k", "0.4 + me.k"))
    with pytest.raises(sc.InputError, match=r"adversary 'grey\.py': its source has changed since"):
        verify(changed)


def test_what_travels_to_a_worker_is_enough(here, tmp_path, monkeypatch):
    study = sc.Study.load("s.toml")
    sent = pickle.dumps(clusters.payload_of(study))
    monkeypatch.chdir(tmp_path)  # where no such file lies
    there, settings = clusters.read_payload(pickle.loads(sent))
    assert [addresses.fingerprint(s, 5) for s in settings] == [addresses.fingerprint(s, 5) for s in study.settings()]
    assert {a.name: a.source for a in there.adversaries} == {a.name: a.source for a in study.adversaries}


@pytest.mark.parametrize(("old", "new", "said"), [
    ("honest = false", "", "members[0].brain = 'always-black'"),
    ('["minimalistic", "legacy"]', '"always-black"', "that is an adversary, which wraps the brain of its swarm"),
    ('["minimalistic", "legacy"]', '"mute.py"', "name a role in ROLES"),
    ("pace = [0.01, 0.02]", "pace = 'a'", "not a number"),
    ('"grey.py"', '"bad.py"', "bad.py, line 2: lie uses me.y"),
    ('"grey.py"', '"none.py"', "none.py"),
])  # fmt: skip
def test_wrong_liars_are_named(tmp_path, old, new, said):
    (tmp_path / "grey.py").write_text(MINE)
    (tmp_path / "bad.py").write_text("def lie(me, x):\n    return me.y\n")
    (tmp_path / "mute.py").write_text(MEANS.replace('("x",)', '("words",)'))
    assert old in STUDY
    with pytest.raises(sc.InputError, match=re.escape(said)):
        sc.Study.parse(STUDY.replace(old, new, 1), context={"base": tmp_path})


@pytest.mark.long
def test_a_lie_that_fails_is_named_with_its_line(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("grey.py").write_text(MINE.replace("0.5 + me.k", "0.5 / (me.k - 0.02)"))
    study = STUDY.replace('["minimalistic", "legacy"]', '"minimalistic"').replace('"always-black", ', "")
    Path("s.toml").write_text(study.replace('{file = "slow-liar", pace = [0.01, 0.02]}, "jammer", ', ""))
    assert main(["run", "s.toml", "--jobs", "1"]) == 2
    said = capsys.readouterr().err
    assert re.search("ZeroDivisionError: (float )?division by zero, at grey.py --wrapping", said)
    assert "return 0.5 / (me.liar_k - 0.02)" in said


@pytest.mark.parametrize(("kind", "name", "source"), [
    ("brain", "theirs.py", f"{MEANS}\n\ndef decide(me):\n    return 1\n"), ("adversary", "grey.py", MINE),
])  # fmt: skip
def test_a_file_of_members_is_not_run_unasked(kind, name, source, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("ours.py").write_text(MEANS)
    Path(name).write_text(source)
    members = [{"robots": 1, "brain": name, "honest": False}]
    data = sc.run(study_of("ours.py", rounds=2, trials=1, members=members), jobs=1)
    Path(name).rename("given.py")
    with pytest.raises(sc.InputError, match=rf"the {kind} '{name}' is a file\. Files named in results are run only"):
        sc.replay(data, setting=0, trial=0)
    assert sc.verify(data, 1.0, brain_file=["ours.py", "given.py"]).differences == []


def test_results_with_liars_and_without_go_together():
    members = [{"robots": 2, "brain": "opposite", "honest": False}]
    plain, lying = (sc.run(study_of(robots=6, rounds=10, trials=2, members=one), jobs=1) for one in ((), members))
    for parts in ([plain, lying], [lying, plain]):
        both = merge(parts)
        assert sorted(zip(both["members"].values, both["honest"].values, strict=True)) == [
            ("", 6), ("2 opposite, not honest", 4)
        ]  # fmt: skip
        for k, one in enumerate(parts):
            found = both["final_estimate"].values[k, :, : one.sizes["robot"]]
            assert (found == one["final_estimate"].values[0]).all()
        found = verify(both, sample=1.0)
        assert (found.notes, found.labels, found.differences) == ([], [], [])
