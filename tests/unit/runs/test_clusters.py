"""A study on a cluster ends with the bits that threads give, whatever happens to the workers meanwhile."""

import json
import os
import platform
import shutil
import signal
import subprocess
import sys
from pathlib import Path
from unittest.mock import Mock

import dask
import distributed
import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus.cli.commands import main
from swarmcensus.gpu import CardError
from swarmcensus.runs import clusters, devices
from swarmcensus.runs.running import run
from swarmcensus.support.errors import InputError
from tests.support.fake_card import Fuller
from tests.support.places import EXAMPLE
from tests.support.results import same

pytestmark = pytest.mark.usefixtures("untraced_processes")

LONG = """
name = "long"
seed = 9
trials = 200
swarm = {robots = 100, accuracy = [0.6, 0.7]}
world = {topology = ["ring", "line"], fill_ratio = 0.55}
schedule = {rounds = 1000}
"""


def study(text):
    return sc.Study.parse(text, context={"base": Path.cwd()})


class Once:
    """A progress callback that does something once, when some trials are done and others are not."""

    def __init__(self, act):
        self.act, self.done = act, False

    def __call__(self, progress):
        if not self.done and 0 < progress.done < progress.total:
            self.done = True
            self.act()


FIXED = """
name = "sent"
seed = 7
trials = 6
swarm = {brain = ["minimalistic", "mine.py"], robots = 12, accuracy = [0.7, "U(0.525, 0.975)"]}
world = {topology = ["ring", "scale-free", "links.csv"], fill_ratio = 0.55}
schedule = {rounds = 60}
measure = {local = true}
"""
MOVING = """
trials   = 3
swarm    = {robots = [3, 9], accuracy = 0.8}
world    = {topology = "moving", density = 1, fill_ratio = 0.55, floor = ["tiles", {image = "leaves.png"}]}
schedule = {ticks = 150}
faults   = [{at = 50, robots = 1, stop = "moving"}]
"""


@pytest.fixture(scope="module")
def scheduler():
    """The address of a running scheduler with a worker process, on loopback."""
    with processes(1) as cluster:
        yield cluster.scheduler_address


@pytest.fixture(scope="module")
def near():
    """The same with a worker in this process, which imports nothing again."""
    with processes(1, processes=False, protocol="tcp") as cluster:
        yield cluster.scheduler_address


def processes(count, **more):
    words = {"threads_per_worker": 1, "host": "127.0.0.1", "dashboard_address": "127.0.0.1:0"}
    return distributed.LocalCluster(n_workers=count, silence_logs="CRITICAL", **words, **more)


@pytest.fixture(scope="module")
def threads():
    """What threads give of the long study."""
    return sc.run(sc.Study.parse(LONG), jobs=2)


@pytest.fixture
def here(here):
    """A folder with what the studies name: a brain file (a shipped brain's source), an edge list, an image."""
    for name in ("links.csv", "leaves.png"):
        shutil.copy(EXAMPLE / name, here)
    (here / "mine.py").write_text(sc.brains.load("legacy").source)
    return here


def test_finished_work_starts_no_cluster(here):
    Path("s.toml").write_text(FIXED.replace(', "mine.py"', ""))
    assert main(["run", "s.toml"]) == 0
    before = sc.load("s.nc")
    assert main(["run", "s.toml", "--cluster", "tcp://127.0.0.1:1"]) == 0  # where nobody answers
    assert same(sc.load("s.nc"), before)


@pytest.mark.long
def test_a_worker_that_is_killed_costs_nothing(here):
    some = study(LONG).with_(trials=80)
    with processes(2) as cluster, distributed.Client(cluster, set_as_default=False) as client:
        victims = sorted(client.run(os.getpid).values())
        kill = Once(lambda: [os.kill(pid, signal.SIGKILL) for pid in victims])  # all that hold anything
        killed = run(some, cluster=cluster.scheduler_address, progress=kill, out="s.nc")
        assert kill.done
        client.wait_for_workers(2, timeout=30)
        assert not set(client.run(os.getpid).values()) & set(victims)
    assert "failed" not in killed.attrs
    assert same(killed, sc.run(some, jobs=2))


@pytest.fixture
def with_cards(monkeypatch):
    """Puts a card into each worker, or an error in place of it."""
    real = clusters.run_remotely
    monkeypatch.setattr(devices, "the_card", devices.the_card)

    def put(card):
        def run_there(key, bundle, device="cpu"):
            error = card if isinstance(card, Exception) else None
            devices.the_card = Mock(return_value=card, side_effect=error)
            return real(key, bundle, device)

        monkeypatch.setattr(clusters, "run_remotely", run_there)

    return put


def test_workers_use_their_cards(here, near, with_cards):
    with_cards(Fuller())
    on_cards = run(study(FIXED), cluster=near, device="gpu")
    assert same(on_cards, sc.run(study(FIXED), jobs=2))
    assert on_cards.attrs["device"] == "gpu"


def test_workers_without_a_card_are_named_or_use_their_cpu(here, near, with_cards, monkeypatch):
    with_cards(CardError("this machine has no NVIDIA card"))
    with pytest.raises(CardError, match=f"^the worker on {platform.node()}: this machine has no NVIDIA card$"):
        run(study(FIXED), cluster=near, device="gpu", out="s.nc")
    assert not Path("s.nc").exists()
    monkeypatch.setattr("swarmcensus.gpu.choosing.WORTH", 0.0)
    assert same(run(study(FIXED), cluster=near, device="auto", out="s.nc"), sc.run(study(FIXED), jobs=2))


@pytest.mark.long
def test_deadly_bundle_fails_alone(here, monkeypatch):
    real = clusters.run_remotely

    def deadly(key, bundle):
        if any(task.settings == (1,) and task.first == 0 for task in bundle):
            os._exit(1)
        return real(key, bundle)

    monkeypatch.setattr(clusters, "run_remotely", deadly)
    some = study(LONG).with_(trials=100)
    with (
        dask.config.set({"distributed.scheduler.allowed-failures": 1}),
        pytest.warns(UserWarning, match=r"its worker died again and again \(out of memory\?\)"),
        processes(2) as cluster,
    ):
        data = run(some, cluster=cluster.scheduler_address, out="s.nc")
    failed = {(one["setting"], one["trial"]) for one in json.loads(data.attrs["failed"])}
    done = data["convergence_round"].values[:, :, 0] >= 0
    assert (1, 0) in failed
    assert failed == {tuple(place) for place in np.argwhere(~done).tolist()}
    assert done.mean() > 0.25
    assert same(run(some, jobs=2, out="s.nc"), sc.run(some, jobs=2))


@pytest.mark.long
def test_what_is_done_is_kept_when_the_scheduler_goes(here, threads):
    with processes(1) as cluster, pytest.raises(InputError, match="the cluster is gone"):
        run(study(LONG), cluster=cluster.scheduler_address, progress=Once(cluster.close), out="s.nc")
    assert list(Path("s.nc.parts").glob("*.npz"))
    assert same(run(study(LONG), jobs=2, out="s.nc"), threads)


@pytest.mark.parametrize(("options", "said"), [
    (["--cluster", "host:8786"], "tcp://host:8786"),
    (["--cluster", "tcp://127.0.0.1:1"], "no Dask scheduler answers at tcp://127.0.0.1:1"),
    (["--cluster", "tcp://host:8786", "--jobs", "3"], "--jobs 3"),
])  # fmt: skip
def test_a_cluster_that_is_not_there_is_one_sentence(here, refused, monkeypatch, options, said):
    monkeypatch.setattr(clusters, "CONNECT", "0.5s")
    Path("s.toml").write_text(FIXED)
    assert said in refused("run", "s.toml", *options)


@pytest.mark.parametrize(("known", "said"), [
    (["ca-file", "client.cert", "client.key"], "[Errno 2] No such file or directory"),
    ([], "needs certificates, which Dask's configuration should name (distributed.comm.tls)"),
])  # fmt: skip
def test_certificates_that_are_missing_are_found_first(here, refused, monkeypatch, known, said):
    monkeypatch.setattr(clusters, "CONNECT", "3s")
    Path("s.toml").write_text(FIXED)
    with dask.config.set({f"distributed.comm.tls.{key}": "gone.pem" for key in known}):
        assert said in refused("run", "s.toml", "--cluster", "tls://127.0.0.1:1")


def test_without_dask_it_is_said_what_to_install(here, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(InputError, match=r"pip install 'swarmcensus\[cluster\]'"):
        run(study(FIXED), cluster="tcp://127.0.0.1:1")


def test_workers_with_other_versions_are_refused(here, near, monkeypatch):
    sent = clusters.payload_of
    monkeypatch.setattr(clusters, "payload_of", lambda one: sent(one) | {"versions": {"swarmcensus": "99.0"}})
    with pytest.raises(InputError, match=rf"swarmcensus {sc.__version__} there, 99\.0 here"):
        run(study(FIXED), cluster=near)


@pytest.mark.long
def test_another_edge_list_is_another_study(here, scheduler):
    """Though its text is the same, and the workers know it."""
    text = FIXED.replace('"ring", "scale-free", ', "").replace(', "mine.py"', "")
    first = run(study(text), cluster=scheduler)
    Path("links.csv").write_text("i,j\n" + "".join(f"{i},{i + 1}\n" for i in range(11)))
    second = run(study(text), cluster=scheduler)
    assert not np.array_equal(first["final_estimate"], second["final_estimate"])
    assert same(second, sc.run(study(text), jobs=2))


@pytest.mark.long
def test_a_rule_for_trials_holds_on_a_cluster(here, scheduler):
    rule = 'trials = {until = "convergence_error median +- 0.02", at_least = 10, at_most = 20}'
    ruled = study(MOVING.replace("trials   = 3", rule))
    assert same(run(ruled, cluster=scheduler), sc.run(ruled, jobs=2))


@pytest.mark.long
def test_a_plain_run_does_without_dask(here):
    Path("s.toml").write_text(FIXED.replace(', "mine.py"', ""))
    code = "import sys; sys.modules |= {'dask': None, 'distributed': None}; from swarmcensus.cli.commands import main; "
    code += "assert main(['run', 's.toml']) == 0; assert 'swarmcensus.runs.clusters' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)
