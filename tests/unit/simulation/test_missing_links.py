"""Links that are missing for a whole trial: `missing_links`."""

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus.simulation import sampling
from swarmcensus.simulation.trials import Metrics, run_batch
from swarmcensus.studies import addresses
from swarmcensus.studies.coordinates import coordinates_of
from tests.support.small import GO, MOVING, RING, SEED, settings_of, study_of

WHOLE = {
    "ring": "ring",
    "full": "full",
    "tree": "scale-free",
    "directed": {"name": "loop", "edges": [[i, (i + step) % 12] for i in range(12) for step in (1, 5)],
                 "directed": True},
}  # fmt: skip


def pairs_in(setting, trial):
    """The links of a trial, as pairs of receiver and sender."""
    links = sampling.links(setting, SEED, trial, 1)
    return set(zip(links.receivers.tolist(), links.senders.tolist(), strict=True))


def test_without_missing_links_all_is_as_before():
    """To the bit, and to the fingerprint by which finished trials are found."""
    (plain,), (said,), (some,) = settings_of(), settings_of(missing_links=0.0), settings_of(missing_links=0.25)
    assert plain == said
    assert addresses.fingerprint(plain, 1) == addresses.fingerprint(said, 1) != addresses.fingerprint(some, 1)
    assert "missing_links" not in coordinates_of(plain)
    assert coordinates_of(some) == coordinates_of(plain) | {"missing_links": 0.25}
    for key in ("readings_key", "losses_key"):
        assert (getattr(addresses, key)(plain, SEED) == getattr(addresses, key)(some, SEED)).all()


@pytest.mark.parametrize("topology", WHOLE)
def test_both_directions_of_a_link_are_missing_together(topology):
    whole, few, many, all_of_them = settings_of(12, topology=WHOLE[topology], missing_links=[0.0, 0.2, 0.6, 1.0])
    everyone = {(i, j) for i in range(12) for j in range(12) if i != j}
    for trial in (0, 2):
        there = everyone if topology == "full" else pairs_in(whole, trial)
        assert pairs_in(many, trial) <= pairs_in(few, trial) <= there
        assert not pairs_in(all_of_them, trial)
        kept = pairs_in(many, trial)
        assert all(((j, i) in kept) == ((i, j) in kept) for i, j in there if (j, i) in there)
    assert pairs_in(many, 0) != pairs_in(many, 2)
    batch = sampling.links(many, SEED, 0, 3)
    second = slice(*batch.starts[1:3])
    pairs = zip(batch.receivers[second].tolist(), batch.senders[second].tolist(), strict=True)
    assert set(pairs) == pairs_in(many, 1)
    assert (np.diff(batch.receivers[second].astype(int)) >= 0).all()


def test_the_share_of_missing_links_is_the_one_that_is_given():
    """With another seed a correct simulator fails with a chance of 6e-5: four standard errors."""
    (setting,) = settings_of(80, topology="full", missing_links=0.3)
    share = np.mean([1.0 - len(pairs_in(setting, trial)) / (80 * 79) for trial in range(5)])
    assert abs(share - 0.3) < 4.0 * (0.3 * 0.7 / (5 * 80 * 79 / 2)) ** 0.5


@pytest.mark.parametrize("topology", WHOLE)
@pytest.mark.parametrize("brain", ["minimalistic", "commons"])
@pytest.mark.parametrize("delay", [0, 2])
def test_a_trial_is_that_of_the_network_without_these_links(topology, brain, delay):
    world = {"message_delay": delay, "rounds": 20, "looks": 3}
    (setting,) = settings_of(12, brain, topology=WHOLE[topology], missing_links=0.4, **world)
    for trial in (0, 2):
        edges = [[sender, receiver] for receiver, sender in sorted(pairs_in(setting, trial))]
        (same,) = settings_of(12, brain, topology={"name": "rest", "edges": edges, "directed": True}, **world)
        found, expected = (run_batch(one, SEED, trial, 1, Metrics(0.01, 10, (5,)), GO) for one in (setting, same))
        assert (found.final == expected.final).all()
        assert (found.counts == expected.counts).all()
    batch = run_batch(setting, SEED, 0, 3, Metrics(0.01, 10, (5,)), GO)
    assert (batch.final[2] == found.final[0]).all()


def test_results_say_how_many_links_are_missing():
    data = sc.run(study_of("commons", robots=8, rounds=40, trials=6, missing_links=[0, 0.5, 1]), jobs=1)
    assert data["missing_links"].values.tolist() == [0.0, 0.5, 1.0]
    heard = data["messages_heard"].values[:3].mean(axis=(1, 2))
    assert heard[0] == 80 > heard[1] > heard[2] == 0
    variances = [sc.explain(data, setting).theory["mixed"].variance[-1] for setting in range(3)]
    assert variances == sorted(variances)  # theory knows each trial's links
    trace = sc.replay(data, 1, 2)
    assert "0.5 of links missing" in trace.attrs["title"]


@pytest.mark.parametrize(
    ("world", "said"),
    [
        (RING | {"missing_links": 1.5}, "world.missing_links = 1.5"),
        (RING | {"missing_links": [0.5, 0.5]}, "a value is twice"),
        (MOVING | {"missing_links": 0.5}, "world.missing_links"),
    ],
)
def test_wrong_values_are_refused(world, said):
    with pytest.raises(sc.InputError, match=said):
        sc.Study(trials=1, swarm={"robots": 5, "accuracy": 0.7}, world=world)


def test_a_full_network_that_is_too_large_is_refused():
    with pytest.raises(sc.InputError, match=r"world.missing_links = 0.5: a full network has 2,000 robots at the most"):
        settings_of(2001, topology="full", missing_links=0.5)
