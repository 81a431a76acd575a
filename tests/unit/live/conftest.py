"""What tests of the live page share."""

import pytest

from swarmcensus.live.choices import offer_of
from swarmcensus.live.server import listen, serving
from tests.conftest import opened
from tests.support.growing import ROUNDS, Recording
from tests.support.relived import logged, told
from tests.support.watching import PAGE_STUDY

browser = pytest.fixture(scope="package", name="browser")(opened)  # one for the pages of all files


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("watch")
    (made / "study.toml").write_text(PAGE_STUDY)
    return made


@pytest.fixture(scope="module")
def served(folder):
    made = listen(offer_of(folder / "study.toml"))
    with serving(made):
        yield made


@pytest.fixture
def page(browser):
    """A page that must not complain."""
    context = browser.new_context(viewport={"width": 1280, "height": 900}, permissions=["clipboard-write"])
    made = context.new_page()
    complaints = []
    made.on("console", lambda said: said.type in ("error", "warning") and complaints.append(said.text))
    made.on("pageerror", lambda error: complaints.append(str(error)))
    yield made
    context.close()
    assert complaints == []


@pytest.fixture
def recording(whole, tmp_path):
    """The day as its logs grow."""
    return Recording(whole, tmp_path / "day")


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A day in which a robot was killed in the middle of a block and started again, and another one started late."""
    folder = tmp_path_factory.mktemp("whole") / "day"
    study, _, swarm = logged(folder, robots=4, rounds=ROUNDS, more={"saves": 4})
    swarm.kill(3)
    (folder / "robot-3.log").unlink()
    swarm.run(9)
    swarm.kill(1)
    with (folder / "robot-1.log").open("r+b") as log:
        log.truncate(log.seek(0, 2) - 3)
    swarm.run(6)
    swarm.start(1)
    swarm.start(3)
    swarm.run(8)
    swarm.close()
    told(folder, study, ended=1, result={"estimates": [0.5] * 4})
    return folder
