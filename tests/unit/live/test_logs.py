"""The live page of a day that robots lived: what it shows is what their logs have."""

import base64
import itertools
import json
import shutil
import warnings
import zlib

import numpy as np
import pytest

from swarmcensus import brains
from swarmcensus.cli.commands import main
from swarmcensus.live.about_trial import scene_of
from swarmcensus.live.choices import offer_of, wanted
from swarmcensus.live.frames import COLUMNS, Show
from swarmcensus.live.robots import robot_of
from swarmcensus.live.sessions import Session
from swarmcensus.robots.logs.clocks import Clock
from swarmcensus.robots.logs.folders import read_recording
from swarmcensus.robots.logs.lives import relive_all
from swarmcensus.robots.logs.traces import Logged
from swarmcensus.simulation import Stepped
from tests.support.relived import SEED, logged, recorded, told
from tests.support.watching import parsed

pytestmark = pytest.mark.interpreted
ROUNDS = 30


def made(folder, brain="commons", **given):
    """A folder of a whole day without restarts, and its setting."""
    study, _ = recorded(folder, brain, robots=4, rounds=ROUNDS, looks=2, **given)
    told(folder, study)
    return study.settings()[0]


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    folder = tmp_path_factory.mktemp("days") / "day"
    made(folder)
    return folder


def show_of(folder):
    offer = offer_of(folder)
    trial = wanted(offer, {})
    return [Show(offer.live(setting, trial.seed, trial.trial), trial.study.measure) for setting in trial.settings]


@pytest.mark.parametrize(("brain", "formats"), [
    ("commons", {"message": "float32"}), ("voter", {"message": "ratio16", "precision": "single"})
])  # fmt: skip
def test_recording_is_shown_like_its_simulation(tmp_path, brain, formats):
    setting = made(tmp_path / "day", brain, **formats)
    [show] = show_of(tmp_path / "day")
    simulated = Show(Stepped(setting, SEED, 0), wanted(offer_of(tmp_path / "day"), {}).study.measure)
    mine, theirs = (parsed(one.frames(list(range(ROUNDS + 1)))) for one in (show, simulated))
    for name in ("layers", "flags", "numbers"):
        np.testing.assert_array_equal(mine[name], theirs[name])
    assert [links.tolist() for links in mine["links"]] == [links.tolist() for links in theirs["links"]]
    for tick, robot in itertools.product((0, 1, 17, ROUNDS), range(4)):
        one, other = robot_of(show, tick, robot), robot_of(simulated, tick, robot)
        assert [heard["from"] for heard in one.pop("heard")] == [heard["from"] for heard in other.pop("heard")]
        one.pop("adds"), other.pop("adds")
        assert one == other


def test_absent_robots_have_no_numbers(tmp_path):
    study, _, swarm = logged(tmp_path / "day", "voter", robots=4, rounds=ROUNDS, more={"saves": 4})
    swarm.run(9)
    swarm.kill(1)
    swarm.run(6)
    swarm.start(1)
    swarm.run(8)
    swarm.close()
    told(tmp_path / "day", study)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        [show] = show_of(tmp_path / "day")
        shown = parsed(show.frames(list(range(show.rounds + 1))))
    known = read_recording(tmp_path / "day")
    trace = Logged(known, relive_all(known), Clock(known.members))
    x = trace.estimates(0, trace.rounds + 1)
    away = np.isnan(x)
    assert away.sum() == 5
    assert ((shown["layers"][:, 0] == 65_535) == away).all()
    np.testing.assert_allclose(shown["layers"][:, 0][~away] / 65_534, x[~away], atol=1 / 65_534)
    column = dict(zip(COLUMNS, shown["numbers"].T, strict=True))
    for name, of in (("mean", np.nanmean), ("deviation", np.nanstd), ("median", np.nanmedian), ("lowest", np.nanmin)):
        np.testing.assert_allclose(column[name], of(x, axis=1), rtol=1e-6)
    assert not np.isnan(column["decided"]).any()
    gone = robot_of(show, 12, 1)
    assert {gone["estimate"], *gone["fields"].values()} == {None}
    assert "looks" not in gone
    json.dumps(gone, allow_nan=False)


def test_fixed_controls_and_frames(recording):
    session = Session(offer_of(recording))
    [begun] = session.answer(json.dumps({"id": 1, "do": "begin", "ask": {"trial": "0", "seed": str(SEED)}}))
    assert begun["form"]["name"] == "day"
    assert {"robots", "accuracy", "seed", "brain"} <= set(begun["form"]["fixed"])
    frames, end = session.answer(json.dumps({"id": 2, "do": "frames", "from": 5, "step": 1, "count": 3}))
    assert (parsed(frames)["ticks"].tolist(), end["frames"]) == ([5, 6, 7], 3)
    [refused] = session.answer(json.dumps({"id": 3, "do": "begin", "ask": {"robots": "9"}}))
    assert refused["error"] == "robots = 9: this recording is as its logs have it: nothing can be chosen"


def test_an_unknown_fill_ratio_is_not_made_up(tmp_path):
    made(folder := tmp_path / "day")
    about = (folder / "swarm.json").read_text()
    (folder / "swarm.json").write_text(about.replace('"fill_ratio": 0.6', '"fill_ratio": null'))
    [show] = show_of(folder)
    assert np.isnan(parsed(show.frames([9]))["numbers"][0, [COLUMNS.index("truth"), COLUMNS.index("right")]]).all()
    assert robot_of(show, 9, 1)["truth"] is None
    assert "f = " not in scene_of(show)["title"]


def test_the_exported_page_holds_the_recording(recording, tmp_path, capsys):
    page = tmp_path / "day.html"
    assert main(["watch", str(recording), "--out", str(page), "--view", "tick=7"]) == 0
    text = page.read_text()
    start = text.index('type="application/json">') + len('type="application/json">')
    held = json.loads(text[start : text.index("</script>", start)])
    assert [scene["brain"] for scene in held["scenes"]] == ["commons"]
    shown = parsed(zlib.decompress(base64.b64decode(held["frames"][0][0])))
    known = read_recording(recording)
    for column, member in enumerate(known.members):
        logs = np.array([tick.estimate for tick in member.log.ticks])
        np.testing.assert_allclose(shown["layers"][1:, 0, column] / 65_534, logs, atol=1 / 65_534)
    assert held["played"] == {"tick": "7"}


@pytest.mark.parametrize(("arguments", "says"), [
    ("BOARDS", "BOARDS: watch needs swarm.json with the study of the recording, as swarmcensus swarm writes it"),
    ("STRANGE", "swarm.json: study: "),
    ("NUMBER", "swarm.json: setting = 7: should be from 0 to 0"),
    ("MOVES", "swarm.json: study: its robots move, and logs do not say where they were"),
    ("FEW", "FEW: a log is of robot 2, and the 2 robots of its study are numbered from 0"),
    ("DAY --set accuracy=0.9", "accuracy = 0.9: "),
    ("DAY --view tick=31", "tick = 31"),
    ("DAY --view beside=voter", "beside = voter: this recording is as its logs have it: nothing can be chosen"),
])  # fmt: skip
def test_what_cannot_be_watched_is_refused_in_a_sentence(recording, here, refused, arguments, says):
    about = {k: v for k, v in json.loads((recording / "swarm.json").read_text()).items() if k != "sha256"}
    moves = about["study"].replace('topology = "ring"', 'topology = "moving"\ndensity = 1.0')
    changes = {
        "STRANGE": {"study": "swarm = 3"}, "NUMBER": {"setting": 7}, "MOVES": {"study": moves},
        "FEW": {"study": about["study"].replace("robots = 4", "robots = 2")}, "BOARDS": {}, "DAY": {},
    }  # fmt: skip
    folder, *options = arguments.split()
    shutil.copytree(recording, folder)
    if folder == "BOARDS":
        (here / folder / "swarm.json").unlink()
    else:
        (here / folder / "swarm.json").write_text(json.dumps(about | changes[folder]))
    assert says in refused("watch", folder, *options, "--out", "page.html")


def test_liars_are_shown_as_they_are_simulated(tmp_path):
    folder, members = tmp_path / "day", [{"robots": 2, "brain": "forger", "honest": False}]
    study, setting, swarm = logged(folder, "commons", robots=6, rounds=ROUNDS, members=members, topology="full")
    swarm.run()
    swarm.close()
    robots = []
    for i, own in enumerate(swarm.brains):
        honest = own.sha256 == setting.brain.sha256
        file = "brain.py" if honest else f"liar-{i}.py"
        (folder / file).write_text(own.source)
        robots.append({"number": i, "log": f"robot-{i}.log", "brain": file, "honest": honest})
    told(folder, study, robots=robots)
    [show] = show_of(folder)
    simulated = Show(Stepped(setting, SEED, 0), study.measure)
    mine, theirs = (parsed(one.frames(list(range(ROUNDS + 1)))) for one in (show, simulated))
    assert (mine["layers"] == theirs["layers"]).all()
    np.testing.assert_array_equal(mine["numbers"], theirs["numbers"])
    for robot in range(6):
        one, other = robot_of(show, 20, robot), robot_of(simulated, 20, robot)
        assert (one["fields"], one["brain"]) == (other["fields"], other["brain"])


def test_own_brain_comes_from_the_folder_of_logs(here):
    mine = here / "mine.py"
    mine.write_text(brains.load("commons").source)
    study, _ = recorded(here / "day", "mine.py", robots=4, rounds=ROUNDS)
    text = study.text.replace("mine.py", "brain.py")  # as swarmcensus swarm writes it
    told(here / "day", study, brain={"file": "brain.py", "name": "mine.py"}, study=text)
    mine.write_text(brains.load("minimalistic").source)
    [show] = show_of(here / "day")
    assert (show.setting.brain.label, show.setting.brain.source) == ("mine.py", brains.load("commons").source)
