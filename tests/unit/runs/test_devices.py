"""Studies on a card, for which a stand-in computes: what runs there, what on the CPU, and what is said."""

import logging
import threading
import time
import warnings
from unittest.mock import Mock

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus import brains
from swarmcensus.cli.commands import main
from swarmcensus.gpu import CardError, CardFull, CardLost, choosing
from swarmcensus.runs import devices, verifying
from swarmcensus.runs.running import run
from swarmcensus.support.errors import InputError, Interrupted
from tests.support.fake_card import FakeCard, Fuller, Rounding, put
from tests.support.results import same
from tests.support.small import BOTH, FAILS, RING, SMALL, study_of

TRIALS = 5
MISSION = """
trials = 50
swarm  = {robots = 6, accuracy = 0.8}
world  = {topology = "ring", fill_ratio = 0.55}
wanted = {error = 0.1}
"""

SWARM = {"robots": [4, 6], "accuracy": 0.7}
SHORT = {"rounds": 20, "observations_per_round": 10}


@pytest.fixture
def card(monkeypatch):
    return put(monkeypatch, FakeCard())


@pytest.fixture
def no_card(monkeypatch):
    monkeypatch.setattr(devices, "the_card", Mock(side_effect=CardError("this machine has no NVIDIA card")))


def ring(**more):
    return study_of(robots=4, rounds=20, trials=TRIALS, **more)


def failing_on(card, after, error):
    """The card fails with an error once it has run some batches."""
    ran = card.run_batch

    def run_batch(*given):
        if len(card.batches) == after:
            raise error
        return ran(*given)

    card.run_batch = run_batch
    return card


def test_a_study_of_all_kinds_gives_the_same_file(card, here):
    study, before = sc.Study.parse(SMALL).with_(measure={"local": True, "estimates": True}), threading.active_count()
    on_card = run(study, device="gpu", out="card.nc")
    assert same(on_card, run(study))
    assert on_card.attrs["device"] == "gpu (Fake 1)"
    assert "device" not in run(study).attrs
    assert {local for *_, local in card.batches} == {False, True}
    assert len(card.threads) == 1
    assert threading.active_count() <= before
    assert sum(trials for _, _, trials, local in card.batches if not local) == on_card.attrs["trials_done"]


def test_what_a_card_cannot_run_runs_on_the_cpu(card, caplog):
    caplog.set_level(logging.INFO)
    study = sc.Study(name="both", trials=TRIALS, seed=3, swarm=SWARM, world=BOTH, schedule=SHORT | {"ticks": 20})
    assert same(run(study, device="gpu"), run(study))
    assert caplog.text.count("both: 2 of 4 settings run on the CPU: robots move") == 1
    assert {setting.body for setting, *_ in card.batches} == {None}
    assert len(card.batches) == 2


@pytest.mark.parametrize("kind", [lambda: FakeCard(most=2), Fuller])
def test_batches_are_as_large_as_the_card_allows_and_half_where_it_is_full(kind, monkeypatch):
    card = put(monkeypatch, kind())
    assert same(run(ring(), device="gpu"), run(ring()))
    assert [(first, trials) for _, first, trials, _ in card.batches] == [(0, 2), (2, 2), (4, 1)]


def test_a_trial_too_large_for_the_card_ends_the_run(monkeypatch, here):
    put(monkeypatch, Fuller()).room = 0
    with pytest.raises(CardFull, match=r"^the memory of Fake 1 is full: it is too small for a trial of "):
        run(ring(), device="gpu", out="r.nc")
    assert not [*here.iterdir()]


def test_one_that_is_known_to_be_too_large_is_refused_before_anything_runs(card, here, monkeypatch):
    def most_trials(setting, *_):
        if setting.robots == 6:
            raise CardFull("Fake 1 has no room for a trial of 6 robots")
        return 1000

    card.most_trials = most_trials
    study = sc.Study(trials=TRIALS, seed=3, swarm=SWARM, world=RING, schedule={"rounds": 20_000})
    with pytest.raises(CardFull, match="no room for a trial of 6 robots"):
        run(study, device="gpu", out="r.nc")
    assert not card.batches
    assert not [*here.iterdir()]
    monkeypatch.setattr(choosing, "WORTH", 0.0)
    run(study.with_(schedule={"rounds": 20}), device="auto")
    assert {setting.robots for setting, *_ in card.batches} == {4}


def test_a_lost_card_ends_the_run_and_keeps_finished_work(monkeypatch, here):
    study = sc.Study(name="lost", trials=TRIALS, seed=3, swarm=SWARM, world=RING, schedule=SHORT)
    put(monkeypatch, failing_on(FakeCard(most=2), 4, CardLost("Fake 1 was lost")))
    with pytest.raises(CardLost, match=r"^Fake 1 was lost$"):
        run(study, device="gpu", out="r.nc")
    lines = []
    resumed = run(study, out="r.nc", say=lines.append)
    assert same(resumed, run(study))
    assert resumed.attrs["device"] == "gpu (Fake 1)"
    assert lines == ["r.nc: found 8 of 10 trials; 8 of them in 1 shard of a run that was cut off"]


def test_ctrl_c_stops_a_batch(card):
    begun = threading.Event()

    def run_batch(*given):
        begun.set()
        while not given[5][0]:
            time.sleep(0.001)

    def press(*_):
        if begun.is_set():
            raise KeyboardInterrupt

    card.run_batch = run_batch
    started = time.monotonic()
    with pytest.raises(Interrupted, match=r"^stopped after 0 of 5 trials$"):
        run(ring(), device="gpu", progress=press)
    assert time.monotonic() - started < 1.0


@pytest.mark.long
def test_failing_trials_fail_as_on_the_cpu(card, here):
    (here / "fails.py").write_text(FAILS)
    study = study_of("fails.py", robots=4, rounds=80, trials=20, fill_ratio=0.3)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        on_card, on_cpu = run(study, device="gpu"), run(study)
    assert same(on_card, on_cpu)
    assert on_card.attrs["failed"] == on_cpu.attrs["failed"]


def test_brains_that_do_not_translate_are_refused_with_their_line(card, refused, here):
    source = brains.load("minimalistic").source
    (here / "deep.py").write_text(source.replace("    me.t += looks\n", "    me.t += looks * min(1, 4_000_000_000)\n"))
    (here / "s.toml").write_text(SMALL.replace("swarm = {", 'swarm = {brain = ["minimalistic", "deep.py"], '))
    line = 1 + source.splitlines().index("    me.t += looks")
    assert refused("run", "s.toml", "--device", "gpu").startswith(f"swarmcensus: brain file deep.py, line {line}: ")
    assert not card.batches


def test_auto_takes_a_card_for_long_studies_only_and_says_so(card, caplog, monkeypatch):
    caplog.set_level(logging.INFO)
    assert same(run(ring(), device="auto"), run(ring()))
    assert not card.batches
    assert caplog.text.count("study: runs on the CPU: too short for a card to be worth its start") == 1
    long = study_of(robots=4, rounds=2, trials=160_000)
    monkeypatch.setattr(choosing, "cores", lambda: 1)
    auto = devices.Hardware(device="auto"), long, long.settings(), long.trials
    assert devices.placing_of(*auto).on_card.all()
    assert caplog.text.count("study: networks run on the card Fake 1") == 1
    monkeypatch.setattr(choosing, "cores", lambda: 1000)
    assert not devices.placing_of(*auto).on_card.any()


def test_auto_runs_on_the_cpu_without_a_card(no_card, caplog, monkeypatch):
    caplog.set_level(logging.INFO)
    monkeypatch.setattr(choosing, "WORTH", 0.0)
    assert same(run(ring(), device="auto"), run(ring()))
    assert caplog.text.count("study: runs on the CPU: there is no card") == 1


@pytest.mark.parametrize("made", ["cpu", "gpu"])
def test_verify_compares_a_card_with_the_cpu(made, card, here):
    run(ring(measure={"local": True}), device=made, out="r.nc")
    assert main(["verify", "r.nc", "--all", "--device", {"cpu": "gpu", "gpu": "cpu"}[made]]) == 0
    assert bool(card.batches)


@pytest.mark.parametrize(("brain", "differ"), [("minimalistic", TRIALS), ("sure", 0)])
def test_only_brains_with_exp_may_round_otherwise(brain, differ, monkeypatch):
    put(monkeypatch, Rounding())
    study = ring(brain=brain)
    assert len(verifying.verify(run(study), sample=1, device="gpu").differences) == differ
    on_card = run(study, device="gpu")
    assert len(verifying.verify(on_card, sample=1).differences) == differ
    on_card["final_estimate"][0, 0, 0] += 1e-9
    assert len(verifying.verify(on_card, sample=1).differences) == max(differ, 1)


def test_where_brains_may_round_otherwise_a_hundredth_of_times_may_differ(card):
    data = run(study_of("sure", robots=4, rounds=5, trials=50), device="gpu")
    data["convergence_round"][0, :2, 0] -= 1
    assert not verifying.verify(data, sample=1).differences  # 2 of 200
    data["convergence_round"][0, 2, 0] -= 1
    assert len(verifying.verify(data, sample=1).differences) == 3


@pytest.fixture
def files(here):
    """A study, a mission and results, as files."""
    source = brains.load("minimalistic").source
    (here / "mine.py").write_text(source.replace("MEMORY =", 'PARAMETERS = {"c": 0.5}\nMEMORY ='))
    (here / "s.toml").write_text(SMALL.replace("swarm = {", 'swarm = {brain = "mine.py", '))
    (here / "m.toml").write_text(MISSION)
    run(ring(), out="r.nc")


COMMANDS = {
    "run": "run s.toml", "reproduce": "reproduce --only fig2 --trials 1", "leaderboard": "leaderboard --trials 1",
    "plan": "plan m.toml", "verify": "verify r.nc", "tune": "tune s.toml --parameter c=0:1 --budget 13 --trials 2",
}  # fmt: skip


@pytest.mark.long(only=["leaderboard", "reproduce"])
@pytest.mark.parametrize("command", COMMANDS)
def test_commands_refuse_a_card_that_is_not_there(command, no_card, files, refused):
    said = "swarmcensus: --device gpu: this machine has no NVIDIA card"
    assert refused(*COMMANDS[command].split(), "--device", "gpu") == said


@pytest.mark.long(but=["plan"])
@pytest.mark.parametrize("command", ["plan", "tune"])
def test_searches_find_the_same_on_a_card(command, card, files, accepted):
    words = COMMANDS[command].split()
    on_card = accepted(*words, "--device", "gpu", "--quiet").out
    assert {setting.body for setting, *_ in card.batches} == {None}
    assert accepted(*words, "--quiet", *["--fresh"] * (command == "tune")).out == on_card


def test_a_plan_of_moving_robots_says_once_that_they_run_on_the_cpu(card, caplog, here):
    caplog.set_level(logging.INFO)
    swarm, world = {"robots": 3, "accuracy": 0.8}, {"side": 1.0, "fill_ratio": 0.55}
    sc.plan({"trials": 40, "swarm": swarm, "world": world, "wanted": {"error": 0.2}}, device="gpu")
    assert caplog.text.count("all settings run on the CPU: robots move") == 1
    assert not card.batches


def test_unknown_devices_are_refused(refused, here):
    (here / "s.toml").write_text(SMALL)
    said = refused("run", "s.toml", "--device", "cup")
    assert said == "swarmcensus run: --device cup: did you mean 'cpu'? should be cpu, gpu or auto"
    for given in ({"device": "tpu"}, {"device": None}, {"jobs": 2.5}, {"jobs": "2"}, {"cluster": 5}):
        ((name, value),) = given.items()
        with pytest.raises(InputError, match=rf"^{name}={value!r}: (did you mean 'gpu'\? )?should be (cpu|1 to|the)"):
            run(ring(), **given)


def test_merged_files_name_the_cards_of_all(card, here):
    shares = [run(ring(), device=device, share=(k, 2)) for k, device in ((1, "gpu"), (2, "cpu"))]
    assert sc.merge(shares).attrs["device"] == "gpu (Fake 1)"
    assert same(sc.merge(shares).drop_attrs(), run(ring()).drop_attrs())


def test_rules_run_on_a_card_in_stages(card):
    rule = {"until": "final_estimate mean +- 4e-3", "at_least": 8, "at_most": 200}
    study = study_of(robots=4, rounds=20, trials=rule)
    assert np.array_equal(run(study, device="gpu")["half_width"], run(study)["half_width"])
    assert card.batches
