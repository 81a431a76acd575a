"""What tests share."""

import gc
import importlib
import os
import signal
import sys
import threading

import hypothesis
import numba
import pytest
from numba.core import event

import swarmcensus as sc
from swarmcensus.cli.commands import main
from swarmcensus.support import fork
from swarmcensus.support.readers import AS_TERMINAL
from swarmcensus.support.terminal import UNFOLDED
from tests.support import interpreted
from tests.support.costs import Costs
from tests.support.long import Long
from tests.support.places import ROOT

for told in ("COLUMNS", "LINES", "FORCE_COLOR", "NO_COLOR", "TTY_COMPATIBLE"):
    os.environ.pop(told, None)  # what is printed should depend on no setting, here and in processes begun here
os.environ[AS_TERMINAL] = str(UNFOLDED)  # tests read tables as people do; of pipes is tests/cli/test_piping.py

# containers often switch bytecode off: then each worker and each process that a test starts would compile all again
sys.dont_write_bytecode = False
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
gc.set_threshold(50_000)
os.fsync = lambda _: None  # no power cut is tried, and a disk takes 10 ms to say that a file is on it

# how long a draw takes is the machine's business
hypothesis.settings.register_profile("here", suppress_health_check=[hypothesis.HealthCheck.too_slow], deadline=None)
hypothesis.settings.load_profile("here")


def pytest_configure(config):
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # a shell has what it starts in the background ignore Ctrl-C
        signal.signal(signal.SIGINT, signal.default_int_handler)  # here, in xdist's workers and in what tests start
    interpreted.register(config)
    config.pluginmanager.register(Long())
    config.pluginmanager.register(Costs(number_of(config) is not None))


def compile_networks():
    from swarmcensus.simulation.living import Stepped

    swarm = TINY["swarm"] | {"brain": ["minimalistic", "commons", "steadfast", "sure"]}  # of many tests
    world, schedule = {"topology": "ring", "fill_ratio": 0.5}, TINY["schedule"]
    study = sc.Study(trials=1, seed=1, swarm=swarm, world=world, schedule=schedule)
    sc.run(study, jobs=1, cautions=False)
    Stepped(study.settings()[0], 1, 0).at(0)


def compile_moving():
    brains = {"brain": ["minimalistic", "leaver"]}  # one that does not steer, and one that does
    world = {"topology": "moving", "density": 5, "fill_ratio": 0.5}
    sc.run(sc.Study(trials=1, seed=1, swarm=TINY["swarm"] | brains, world=world, schedule={"ticks": 2}), jobs=1)


TINY = {"swarm": {"robots": 4, "accuracy": 0.7}, "schedule": {"rounds": 2, "observations_per_round": 1}}


def number_of(config):
    """Which of several workers that run the whole suite this process is: 0, 1, ...; None if it is none."""
    worker = getattr(config, "workerinput", {}).get("workerid", "")
    whole = config.args_source is config.ArgsSource.TESTPATHS and not config.option.keyword
    return int(worker.removeprefix("gw")) if worker and whole and not numba.config.DISABLE_JIT else None


@pytest.hookimpl(tryfirst=True)
def pytest_collection(session):
    """Workers compile the engine's loops, some each, before one would wait for those of the other: the second one now.

    So it finds the bytecode of all tests, with their assertions rewritten, which the first one makes meanwhile.
    """
    if number_of(session.config) == 1:
        compile_moving()


def pytest_collection_finish(session):
    """The first one when it has collected. Whoever only shares tests out to workers does not, and imports little."""
    from swarmcensus.results import netcdf

    # results are read here: a copy of a process as large as this one takes 25 ms, and is for files that end a process
    netcdf.in_background = lambda work, **_: work
    gc.freeze()  # what was collected stays: no need to look for circles there again and again
    if number_of(session.config) == 0:
        compile_networks()


class Untraced(event.Listener):
    """While Numba compiles, no coverage is measured: it would take a third longer, and nothing of ours is run."""

    def __init__(self):
        self.here = threading.local()

    def on_start(self, _):
        self.here.traces = [*getattr(self.here, "traces", ()), sys.gettrace()]
        sys.settrace(None)

    def on_end(self, _):
        sys.settrace(self.here.traces.pop())


event.register("numba:compile", Untraced())


@pytest.fixture
def copies(monkeypatch):
    """Results are read in a copy of this process, as users read them: for files with damage in any place."""
    monkeypatch.setattr("swarmcensus.results.netcdf.in_background", fork.in_background)


@pytest.fixture
def untraced_processes(monkeypatch):
    """No coverage is measured in processes begun here: for what goes ways of other tests again and again."""
    for told in ("COVERAGE_PROCESS_CONFIG", "COVERAGE_PROCESS_START"):
        monkeypatch.delenv(told, raising=False)


@pytest.fixture
def untraced(untraced_processes):
    """The same here too: of a loop in Python it makes a dozen times as much."""
    trace = sys.gettrace()
    sys.settrace(None)
    yield
    sys.settrace(trace)


@pytest.fixture(autouse=True)
def own_ctrl_c():
    """What a test makes of Ctrl-C ends with it."""
    before = signal.getsignal(signal.SIGINT)
    yield
    if signal.getsignal(signal.SIGINT) is not before:
        signal.signal(signal.SIGINT, before)


@pytest.fixture
def no_ctrl_c():
    """Ctrl-C is ignored here, as in what a shell begins in the background."""
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture
def here(tmp_path, monkeypatch):
    """An empty folder, which is the working folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def refused(here, capsys):
    """Runs a command that must fail, and changes no file: the one line of its error, which comes last on stderr."""

    def refused(*command):
        capsys.readouterr()
        before = {path: path.is_file() and path.read_bytes() for path in here.rglob("*")}
        assert main([str(word) for word in command]) == 2
        *progress, error = capsys.readouterr().err.splitlines()
        assert error.startswith("swarmcensus")
        assert not any(line.startswith(("swarmcensus", "Traceback")) for line in progress)
        assert {path: path.is_file() and path.read_bytes() for path in here.rglob("*")} == before
        return error

    return refused


@pytest.fixture
def accepted(capsys):
    """Runs a command that must end well: what it alone prints, with `out` and `err`."""

    def accepted(*command):
        capsys.readouterr()
        assert main([str(word) for word in command]) == 0
        return capsys.readouterr()

    return accepted


@pytest.fixture
def benchmark(monkeypatch):
    """A file of benchmarks/ as a module, by its name."""
    monkeypatch.syspath_prepend(ROOT / "benchmarks")
    return importlib.import_module


def opened():
    from tests.support.browsing import BROWSER, playwright  # skips what asks for it where there is none

    with playwright.sync_playwright() as running:
        browser = running.chromium.launch(executable_path=BROWSER, args=["--no-sandbox"])
        yield browser
        browser.close()


browser = pytest.fixture(scope="module", name="browser")(opened)


@pytest.fixture(scope="session")
def small_study():
    from tests.support.small import SMALL

    return sc.Study.parse(SMALL)


@pytest.fixture(scope="session")
def small_results(small_study):
    return sc.run(small_study, jobs=2)


@pytest.fixture(scope="session")
def small_file(small_results, tmp_path_factory):
    path = tmp_path_factory.mktemp("results") / "small.nc"
    sc.save(small_results, path)
    return path
