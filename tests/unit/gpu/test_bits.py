"""Kernels give the bits of the CPU's engine; g++ compiles them here, with a loop over the threads of a block."""

import shutil
from unittest.mock import DEFAULT, Mock

import numpy as np
import pytest

from swarmcensus.brains.brain import shipped
from swarmcensus.gpu import Card, CardError, CardFull, cards, why_not
from swarmcensus.runs.tasks import metrics_of
from swarmcensus.simulation import run_batch
from swarmcensus.support.errors import InputError
from tests.support.emulator import Emulator
from tests.support.random_studies import BRAINS, GO_ON, differences, random_study
from tests.support.second import changed
from tests.support.small import study_of

pytestmark = pytest.mark.skipif(shutil.which("g++") is None, reason="g++, which compiles the kernels, is not here")
FEW = (8, 18, 44, 72, 73)  # random studies that have all that a study may have between them
BRAIN = changed(
    ('"n": 0.0', '"n": 0.0, "v": (0.0, 0.0, 0.0)'),
    ("def estimate", "def item(items, k):\n    return items[k]\n\n\ndef estimate"),
)


@pytest.fixture
def card():
    return Card(Emulator())


@pytest.fixture(params=["in a block", "round by round"])
def way(request, monkeypatch):
    """How kernels run a swarm: a small one as a whole in a block of threads, a large one round by round."""
    if request.param != "in a block":
        monkeypatch.setattr(cards, "SHARED", 0)
        monkeypatch.setattr(cards, "PIECE", 3)
        monkeypatch.setattr(cards, "CHUNK", 8)


def networks(brain, rounds=20, trials=3, **world):
    """A small study of networks."""
    more = {"fill_ratio": 0.3, "measure": {"checkpoints": [1, rounds]}} | world
    return study_of(str(brain), 6, 0.8, rounds, looks=4, trials=trials, seed=4, **more)


def run(card, study, trials=3):
    """All trials of a study's first setting."""
    return card.run_batch(study.settings()[0], study.seed, 0, trials, metrics_of(study), GO_ON)


@pytest.mark.long(but=["in a block-44", "round by round-18"])
@pytest.mark.interpreted
@pytest.mark.parametrize("number", [*FEW, *range(100, 112)])
def test_same_bits(card, way, number):
    assert differences(card, random_study(number)) == []


@pytest.mark.long(but=["in a block-2", "round by round-0"])
@pytest.mark.interpreted
@pytest.mark.parametrize("delay", [0, 2])
def test_same_sums_in_full_networks_of_several_blocks(card, way, delay):
    study = networks("commons", 3, topology="full", message_delay=delay)
    study = study.with_(swarm={"brain": "commons", "robots": [256, 257, 520], "accuracy": 0.7})
    assert differences(card, study, trials=2) == []


@pytest.mark.long
@pytest.mark.interpreted
@pytest.mark.parametrize("brain", [*shipped(), *(brain for brain in BRAINS if brain.endswith(".py"))])
def test_same_bits_of_all_brains(card, monkeypatch, brain):
    for number, shared in ((29, cards.SHARED), (50, 0), (8, cards.SHARED)):
        monkeypatch.setattr(cards, "SHARED", shared)
        assert differences(card, random_study(number, [brain])) == []


def test_same_bits_of_rows_that_several_blocks_read():
    """Robots of the three trials agree to 0.0219 never, never and in the last chunk of rounds, before its end."""
    study = networks("commons", 70, measure={"checkpoints": [1, 70], "delta": 0.0219})
    study = study.with_(swarm={"brain": "commons", "robots": cards.PIECE + 616, "accuracy": 0.8})
    assert differences(Card(Emulator(level="-O1")), study, first=0) == []


@pytest.mark.long(but_every=2)
@pytest.mark.interpreted
@pytest.mark.parametrize(("broken", "why"), [
    (("pass", "me.t = me.t / (0.0 if me.n > 20.0 else 1.0)"), "ZeroDivisionError"),
    (("pass", "me.n = math.sqrt(20.0 - me.n) + me.n"), "ValueError"),
    (("pass", "me.t = 1.0 * int(me.t * 10.0 ** (me.n * 20.0))"), "OverflowError"),
    (("pass", "me.t = 1.0 * int(me.t * 1e18)"), "OverflowError"),
    (("pass", "me.t += item(me.v, int(me.n))"), "IndexError"),
    (("return me.n / me.t", "return 1.5 if me.n > 20.0 else me.n / me.t"), "estimate gives 1.5"),
])  # fmt: skip
def test_brain_that_fails_is_blamed_as_on_the_cpu(card, tmp_path, broken, why):
    """Python's errors are noticed on a card, though it goes on."""
    file = tmp_path / "failing.py"
    file.write_text("import math\n\n" + BRAIN.replace(*broken))
    study = networks(file)
    with pytest.raises(InputError, match="a brain fails in one of trials 0 to 2"):
        run(card, study)
    with pytest.raises(InputError, match=why):
        run(card, study, 1)


@pytest.mark.interpreted
def test_numbers_of_brains_are_theirs(card, tmp_path):
    """A literal that a helper function has too, and names with a type of C in them."""
    file = tmp_path / "odd.py"
    text = BRAIN.replace("pass", "me.n += me.t / 2147483648.0", 1).replace('"v"', '"v_int32_t"')
    file.write_text(
        f"PARAMETERS = {{'größe': 1.0}}\nbrain = 3.0\n{text.replace('else 0.5', 'else brain / 6.0 * me.größe')}"
    )
    assert differences(card, networks(file)) == []


@pytest.mark.interpreted
def test_a_full_card_gives_up_what_earlier_batches_left(card, monkeypatch):
    small, large = networks("minimalistic", 20), networks("minimalistic", 300)
    run(card, large)
    upload = Mock(wraps=card.driver.upload, side_effect=[CardFull("full"), DEFAULT])
    monkeypatch.setattr(card.driver, "upload", upload)
    assert run(card, small) is not None
    assert upload.call_count == 2


@pytest.mark.interpreted
def test_programs_are_for_all_parameters(card, monkeypatch):
    sources = []
    build = Emulator.build
    monkeypatch.setattr(Emulator, "build", lambda self, source: sources.append(source) or build(self, source))
    for memory in (20.0, 50.0):
        swarm = {"brain": {"file": "tracking", "memory": memory}, "robots": 6, "accuracy": 0.8}
        study = networks("tracking").with_(swarm=swarm)
        card.compile_for([(study.settings()[0], False)], study.seed)
        assert differences(card, study) == []
    assert len(set(sources)) == 2  # of the rounds, and of what is measured
    assert set(sources) == card.driver.compiled


def test_batches_fit_the_memory():
    study = networks("minimalistic", 1000)
    setting, metrics = study.settings()[0], metrics_of(study)
    few, many = (Card(Emulator(memory)).most_trials(setting, metrics) for memory in (1 << 20, 1 << 24))
    assert 1 <= few < many / 10
    with pytest.raises(CardFull, match=r"the card Emulator has 0 MB of free memory, and one trial of .* takes"):
        Card(Emulator(1000)).most_trials(setting, metrics)


@pytest.mark.long(only=["1500"])
@pytest.mark.interpreted
@pytest.mark.parametrize("robots", [6, 1500])
def test_a_card_that_computes_nothing_is_not_believed(card, monkeypatch, robots):
    """Each program is compared once with the CPU, a large swarm's by a smaller one."""
    study = networks("minimalistic", 4).with_(swarm={"brain": "minimalistic", "robots": robots, "accuracy": 0.8})
    compared = []
    monkeypatch.setattr(cards, "kept", lambda mark: None)
    monkeypatch.setattr(cards, "run_batch", lambda one, *given: compared.append(one.robots) or run_batch(one, *given))
    for _ in range(2):
        run(card, study)
    assert compared == [min(robots, cards.MOST_COMPARED)]
    monkeypatch.setattr(Emulator, "launch", lambda *given: None)
    with pytest.raises(CardError, match=r"^Emulator computes wrongly: .*final.* are not those of the CPU: run it on"):
        run(Card(Emulator()), study)


@pytest.mark.interpreted
def test_stopped_batch_gives_nothing(card, way):
    study = networks("minimalistic", 100)
    assert card.run_batch(study.settings()[0], 0, 0, 2, metrics_of(study), np.ones(1, np.uint8)) is None


def test_moving_robots_and_metrics_of_files_are_for_the_cpu():
    moving = study_of("commons", ticks=10)
    assert why_not(moving.settings()[0], metrics_of(moving)) == "robots move"
    assert why_not(networks("commons").settings()[0], metrics_of(networks("commons"))) is None
    drawn = networks("commons", fill_ratio="U(0.3, 0.7)")
    assert why_not(drawn.settings()[0], metrics_of(drawn)) == "each trial draws its fill ratio"
