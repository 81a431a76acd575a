"""What a page may ask for, what it is shown, and how it is answered: without a browser and without a server."""

import base64
import itertools
import json
import random
import string
from pathlib import Path

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus import brains
from swarmcensus.figures import colours_of_brains, places_of_robots
from swarmcensus.live.choices import KEYS, first_view, offer_of, wanted
from swarmcensus.live.exporting import export
from swarmcensus.live.frames import COLUMNS, Show
from swarmcensus.live.robots import robot_of
from swarmcensus.live.sessions import MOST_TEXT, Session, form_of, spoken
from swarmcensus.simulation import Stepped
from swarmcensus.support.errors import InputError
from tests.support.small import study_of
from tests.support.watching import parsed

STUDY = """
trials = 3
seed = 4
swarm = {robots = [6, 9], accuracy = "U(0.6, 0.9)", brain = ["minimalistic", "sure"]}
world = {topology = ["ring", "moving"], density = 4.0, fill_ratio = 0.6}
schedule = {rounds = 60, ticks = 60}
"""


@pytest.fixture(scope="module")
def offer():
    return offer_of(sc.Study.parse(STUDY))


def show_of(asked, offer=None):
    """What is shown of a trial that a page asks for."""
    found = wanted(offer or offer_of(None), asked)
    return Show(Stepped(found.settings[0], found.seed, found.trial), found.study.measure)


@pytest.mark.interpreted
def test_settings_are_those_of_the_study_or_its_results(offer, tmp_path):
    study = sc.Study.parse(STUDY)
    short = study.with_(schedule={"rounds": 2, "ticks": 2})
    sc.save(sc.run(short, jobs=1), tmp_path / "r.nc")
    for known, one in ((offer, study), (offer_of(tmp_path / "r.nc"), short)):
        for number, setting in enumerate(one.settings()):
            found = wanted(known, {"setting": str(number), "trial": "1"})
            assert (found.settings, found.seed, found.trial) == ((setting,), 4, 1)


@pytest.mark.parametrize(("asked", "line"), [
    ({"brain": "commons", "robots": "50"}, "ring, N = 50, accuracy U(0.6,0.9), f = 0.6, C = 60, R = 10"),
    ({"topology": "moving"}, "moving, N = 6, D = 4, accuracy U(0.6,0.9), f = 0.6, 60 ticks"),
    ({"setting": "2", "topology": "line"}, "line, N = 6, accuracy U(0.6,0.9), f = 0.6, C = 60, R = 10"),
    ({"setting": "2", "floor": "half", "density": "2"}, "D = 2, accuracy U(0.6,0.9), f = 0.6, floor half, 60 t"),
    ({"link_success": "0.5", "fill_ratio": "0.25"}, "f = 0.25, link success 0.5"),
    ({"members": '[{robots = 0.5, brain = "jammer", honest = false}]'}, "f = 0.6, 50 % of robots jammer"),
    ({"members": "[]"}, "ring, N = 6, accuracy U(0.6,0.9), f = 0.6, C = 60, R = 10"),
    ({"rounds": "7"}, "C = 7"),
    ({"setting": "2", "world.side": "3", "robots": "8"}, "N = 8, L = 3 m"),
    ({"setting": "2", "floor": "{clusters = 0.3}"}, "floor clusters(0.3)"),
    ({"missing_links": "0.1", "world.message_delay": "2", "precision": "single"}, "delay 2, single precision"),
    ({"world.message": "float16", "assumed_accuracy": "{error = 0.1}"}, "assumed accuracy error=0.1, f = 0.6"),
    ({"brain": "{file = 'census', z = 2}", "brain.momentum": "0.5"}, "momentum = 0.5, memory = 100.0, z = 2.0"),
    ({"accuracy": "{black = 0.9, white = 0.6}"}, "accuracy black=0.9 white=0.6"),
])  # fmt: skip
def test_values_are_changed(offer, asked, line):
    assert line in str(wanted(offer, asked).settings[0])


@pytest.mark.parametrize(("asked", "said"), [
    ({"brian": "commons"}, "unknown key brian: did you mean 'brain'?"),
    ({"beside": "comons"}, 'beside = "comons": did you mean'),
    ({"robots": "1e3"}, "swarm.robots = 1000.0: should be"),
    ({"robots": "٣"}, 'swarm.robots = "٣"'),
    ({"setting": "99"}, "setting = 99: there are 0 to 7"),
    ({"of": "00000000"}, "of = 00000000"),
    ({"topology": "office.csv"}, 'world.topology = "office.csv": these edges are not stored here'),
    ({"setting": "2", "density": "0"}, "density = 0: should be greater than 0"),
    ({"topology": "moving", "density": "1e-8"}, "tiles wide"),
    ({"setting": "2", "floor": "/etc/passwd"}, 'world.floor = "/etc/passwd"'),
    ({"accuracy": "[0.6"}, "[0.6: not a value of TOML"),
    ({"members": "[{robots = 1.0, brain = 'always-black', honest = false}]"}, "none is honest"),
    ({"members": "[{robots = 0.3, brain = 'no-lie'}]"}, "this brain's source is not stored here"),
    ({"topology": "full", "brain": "voter", "robots": "9000"}, "at most 2,000 fully connected ones can be watched"),
    ({"topology": "{networkx='complete_graph'}", "robots": "9000"}, "at most 2,000 robots on a network of"),
    ({"robots": "20001"}, "robots = 20001: at most 20,000 robots can be watched"),
    ({"robots": "[3, 4]"}, "these values make 2 settings: should be one of each key"),
    ({"robots": "3", "swarm.robots": "4"}, "robots and swarm.robots are one key: give it once"),
    ({"density": "2"}, "world.density is of robots that move"),
    ({"rounds": "5", "faults": "[{at = 9, stop = ['talking'], robots = 1}]"}, "comes after the last round, 5"),
    ({"faults": "[{at = 9, do = 'stop', robots = 1}]"}, "this happens to processes"),
])  # fmt: skip
def test_wrong_input_is_refused(offer, asked, said):
    with pytest.raises(InputError) as told:
        wanted(offer, asked)
    assert said in str(told.value)


def test_values_concern_what_is_measured_too(offer):
    found = wanted(offer, {"bins": "5", "measure.delta": "0.2", "trials": "7", "seed": "9"})
    assert (found.study.measure.bins, found.study.measure.delta, found.study.trials, found.seed) == (5, 0.2, 7, 9)
    assert found.settings == wanted(offer, {}).settings


@pytest.mark.parametrize(("key", "value"), [
    ("brain", "evil.py"), ("beside", "./evil.py"), ("members", "[{robots = 2, brain = 'evil.py'}]"),
    ("topology", "evil.py"), ("topology", "{file = 'evil.py'}"), ("topology", "edges.csv"),
    ("floor", "evil.py"), ("floor", "{image = 'leaves.png'}"), ("accuracy", "evil.py(0.5)"),
    ("assumed_accuracy", "{error = 'evil.py(0.5)'}"), ("metrics", "evil.py"), ("swarm.brain", "{file = 'evil.py'}"),
    ("world", "{topology = 'edges.csv', fill_ratio = 0.5}"), ("case", "[{brain = 'evil.py'}]"),
])  # fmt: skip
def test_no_file_is_opened_that_a_page_names(offer, here, key, value):
    Path("evil.py").write_text("raise SystemExit('it ran')\n")
    Path("edges.csv").write_text("0,1\n1,2\n2,3\n3,4\n4,5\n")
    Path("leaves.png").write_bytes(b"")
    with pytest.raises(InputError, match=r"not stored here|no file is opened here|is of robots that move"):
        wanted(offer, {"setting": "2" if key == "floor" else "0", key: value})


def test_files_that_were_named_first_are_read_and_no_others(here):
    Path("edges.csv").write_text("source,target\n0,1\n1,2\n2,3\n")
    Path("other.csv").write_text("source,target\n0,1\n1,2\n2,3\n")
    Path("mine.py").write_text(brains.load("commons").source)
    asked = {"topology": "edges.csv", "robots": "4", "brain": "mine.py", "beside": "mine.py", "tick": "3"}
    known, query, play = first_view(None, asked)
    assert (query, play) == ({key: text for key, text in asked.items() if key != "tick"}, {"tick": "3"})
    Path("edges.csv").unlink()
    found = wanted(known, query)
    assert (str(found.settings[0].topology), found.settings[0].brain.name) == ("edges", "mine.py")
    assert form_of(known, found)["choices"]["topology"]["edges.csv"] == "edges"
    with pytest.raises(InputError, match="no file is opened here"):
        wanted(known, query | {"topology": "other.csv"})
    for link in ({"topology": "other.csv", "robots": "4"}, {"beside": "mine.py"}):  # which may be somebody else's
        with pytest.raises(InputError, match="no file is opened here"):
            first_view(None, {}, link=link)
    _, query, _ = first_view(None, {"brain": "mine.py"}, link={"topology": "ring", "beside": "mine.py", "tick": "2"})
    assert query == {"topology": "ring", "beside": "mine.py", "brain": "mine.py"}


def test_controls_show_the_values_of_a_setting(offer):
    form = form_of(offer, wanted(offer, {"setting": "2"}))
    now = {"robots": "6", "accuracy": "U(0.6,0.9)", "fill_ratio": "0.6", "density": "4", "floor": "tiles"}
    assert form["now"].items() >= (now | {"ticks": "60"}).items()
    assert all(form["now"][key] in found for key, found in form["choices"].items())
    assert "rounds" not in form["now"]
    lying = '[{robots = 0.5, brain = "jammer", honest = false}, {robots = 1, accuracy = 0.9}]'
    asked = {"robots": "12", "members": lying, "topology": "{name = 'torus', columns = 4}"}
    form = form_of(offer, wanted(offer, asked))
    assert (form["now"]["liars"], form["now"]["adversary"]) == ("0.5", "jammer")
    assert form["honest"] == ["{robots = 1, accuracy = 0.9, honest = true}"]
    assert form["choices"]["topology"][form["now"]["topology"]] == '{name = "torus", columns = 4}'


@pytest.mark.parametrize("number", [0, 2])
def test_frames_and_robots_are_those_of_the_replay(offer, number):
    show = show_of({"setting": str(number), "trial": "2"}, offer)
    study = sc.Study.parse(STUDY.replace(', "sure"', ""))
    trace = sc.replay(sc.run(study, jobs=1), study.settings().index(show.setting), 2)
    ticks = [0, 1, 2, 30, 60]
    shown = parsed(show.frames(ticks))
    x = trace["estimate"].values[ticks]
    assert shown["ticks"].tolist() == ticks
    np.testing.assert_allclose(shown["layers"][:, 0] / 65_534, x, atol=1 / 65_534)
    column = dict(zip(COLUMNS, shown["numbers"].T, strict=True))
    np.testing.assert_allclose(column["mean"], x.mean(axis=1), rtol=1e-6)
    np.testing.assert_allclose(column["median"], np.median(x, axis=1), rtol=1e-6)
    np.testing.assert_allclose(column["low"], np.quantile(x, 0.25, axis=1), rtol=1e-6)
    if number == 2:
        half = trace.attrs["side"] / 2
        place = (trace["position"].values[ticks] + half) / (2 * half)
        np.testing.assert_allclose(shown["layers"][:, 1:].transpose(0, 2, 1) / 65_535, place, atol=1 / 65_535)
        looked = ~np.isnan(trace["reading"].values[ticks])
        assert ((shown["flags"][:, 0] & 1) == looked).all()
        heard = [np.bincount(links, minlength=6).tolist() for links in shown["links"]]
        assert heard[1:] == trace["neighbours"].values[ticks[1:]].tolist()
    for tick, robot in itertools.product(ticks, range(6)):
        told = robot_of(show, tick, robot)
        if number != 2 and tick:
            assert (told["blacks"], told["looks"]) == (trace["blacks"].values[tick, robot], 10)
        for name in show.setting.brain.memory:
            assert told["fields"][name] == trace[name].values[tick, robot].tolist()
        assert told["estimate"] == trace["estimate"].values[tick, robot]
    json.dumps(robot_of(show, 60, 0), allow_nan=False)


@pytest.mark.interpreted
def test_robots_without_an_estimate_are_marked(tmp_path):
    mine = tmp_path / "none.py"
    text = brains.load("minimalistic").source
    mine.write_text(text.replace("    return me.x\n", "    return me.x + 1e999 - 1e999\n"))
    show = show_of({"brain": str(mine), "topology": "ring", "robots": "5"}, offer_of(None, (mine,)))
    assert (parsed(show.frames([3, 4]))["layers"][:, 0] == 65_535).all()
    assert robot_of(show, 4, 2)["estimate"] is None


@pytest.mark.long(but=["voter"])
@pytest.mark.interpreted
@pytest.mark.parametrize("brain", ["voter", "sure"])
def test_decided_and_done_robots_in_every_stretch(brain, monkeypatch):
    monkeypatch.setattr("swarmcensus.simulation.living.MOST_ROUNDS", 7)
    who = {"file": "sure", "within": 0.05} if brain == "sure" else brain
    study = study_of(who, 6, 0.9, rounds=150, trials=2, seed=2, topology="full", fill_ratio=0.9)
    trace = sc.replay(sc.run(study, jobs=1), 0, 1)
    show = Show(Stepped(study.settings()[0], 2, 1), study.measure)
    flags = parsed(show.frames(list(range(151))))["flags"][:, 0]
    assert ((flags >> 4).astype(int) - 1 == trace["decided"].values if brain == "voter" else flags >> 4 == 0).all()
    assert ((flags & 8 > 0) == (trace["is_done"].values == 1 if brain == "sure" else False)).all()
    if brain == "sure":
        assert 0 < (flags & 8 > 0).sum() < flags.size
        for tick in (0, 1, 7, 8, 100):
            told = robot_of(show, tick, 2)["fields"]
            for name in ("interval_low", "interval_high", "is_done"):
                assert told[name] == trace[name].values[tick, 2]
        for tick in (1, 7, 8, 100, 150):  # who is done reads nothing any more
            for robot in range(6):
                assert robot_of(show, tick, robot)["blacks"] == trace["blacks"].values[tick, robot]


def test_what_cannot_be_watched_is_refused(small_results):
    for chosen in ([], 2):
        with pytest.raises(InputError, match="no setting"):
            offer_of(small_results.isel(setting=chosen))


def test_what_a_robot_heard_is_what_its_neighbours_said():
    """Of the paper's brain on a ring: the sums of what was heard make its new social estimate."""
    told = robot_of(show_of({"brain": "minimalistic", "topology": "ring", "robots": "7"}), 12, 3)
    assert (told["heard_at"], [one["from"] for one in told["heard"]]) == (12, [2, 4])
    beta = sum(one["said"]["heard_alpha"] for one in told["heard"])
    assert told["fields"]["beta"] == pytest.approx(beta, rel=1e-12)
    assert told["fields"]["x_bar"] == pytest.approx(sum(o["said"]["heard_x"] for o in told["heard"]) / beta, rel=1e-12)


def test_lost_messages_are_not_shown():
    show = show_of({"topology": "ring", "robots": "40", "link_success": "0.3"})
    shown = parsed(show.frames(list(range(1, 101))))
    carried = np.array([links.sum() for links in shown["links"]])
    assert carried.tolist() == np.diff(shown["numbers"][:, COLUMNS.index("heard")], prepend=0).tolist()
    assert carried.mean() == pytest.approx(0.3 * 80, rel=0.1)  # 8,000 messages: six standard deviations are a tenth


def test_a_session_answers(offer):
    session = Session(offer)
    [begun] = session.answer(json.dumps({"id": 1, "do": "begin", "ask": {"beside": "commons"}}))
    assert [scene["brain"] for scene in begun["scenes"]] == ["minimalistic", "commons"]
    assert begun["form"]["now"]["robots"] == "6"
    assert begun["form"]["colours"] == colours_of_brains(["minimalistic", "commons"])
    asked, end = json.dumps({"id": 2, "do": "frames", "from": 10, "step": 5, "count": 4}), {"going": True}
    while end.get("going"):
        *frames, end = session.answer(asked)
    assert [parsed(part)["ticks"].tolist() for part in frames] == [[10, 15, 20, 25]] * 2
    assert [parsed(part)["side"] for part in frames] == [0, 1]
    [told] = session.answer(json.dumps({"id": 3, "do": "robot", "side": 1, "robot": 2, "tick": 10}))
    [refused] = session.answer(json.dumps({"id": 4, "do": "memory", "side": 1, "robot": 2, "name": "tt", "from": 0}))
    assert (refused["key"], "name = tt" in refused["error"]) == ("name", True)
    assert told["told"]["brain"] == "commons"


@pytest.mark.parametrize("other", ["commons", "minimalistic", "minimalistic a=2", "/tmp/mine.py"])
def test_two_brains_differ_in_colour(other):
    first, second = colours_of_brains(["minimalistic", other])
    assert first == colours_of_brains(["minimalistic"])[0] != second


@pytest.mark.parametrize("ratio", ["0", "0.05", "0.95", "1"])
def test_the_lowest_and_the_highest_fill_ratios_are_shown(ratio, tmp_path):
    """Their bins have no end on one side, and JSON has no infinity."""
    session = Session(offer_of(None))
    asked = {"topology": "ring", "fill_ratio": ratio, "accuracy": "1", "rounds": "100", "robots": "5"}
    [begun] = spoken(session.answer(json.dumps({"do": "begin", "ask": asked})))
    assert json.loads(begun)["form"]["now"]["fill_ratio"] == ratio
    [frame, _] = session.answer(json.dumps({"do": "frames", "from": 100, "count": 1}))
    shown = parsed(frame)
    np.testing.assert_allclose(shown["layers"][0, 0] / 65_534, float(ratio), atol=0.04)
    assert shown["numbers"][0, COLUMNS.index("right")] == 1.0
    assert export(offer_of(None), asked | {"rounds": "10"}, tmp_path / "run.html") > 100_000


@pytest.mark.parametrize(("said", "error"), [
    ("{", "a request should be JSON"),
    ("[]", "a request should be a JSON object"),
    (b"\x00\x01", "a request should be JSON of at most"),
    ("x" * (MOST_TEXT + 1), "a request should be JSON of at most"),
    ("[" * 10_000, "should be JSON"),
    ('{"do": {"a": 1}}', "should be one of begin, frames, robot"),
    ('{"do": "run"}', "do = 'run'"),
    ('{"do": "begin", "ask": {"robots": 5}}', "ask: should be names and texts"),
    ('{"do": "begin", "ask": {}, "view": {"colour": "red"}}', "colour = red: should be one of off, belief, error"),
    ('{"do": "begin", "ask": {}, "view": {"tick": 5}}', "view: should be names and texts"),
    ('{"do": "frames"}', "no trial yet"),
    ('{"do": "begin", "id": 1e400, "ask": {}}', "id: should be a whole number"),
    ('{"do": "begin", "ask": {"accuracy": "0.5\\nx = 1"}}', "not a value of TOML"),
])  # fmt: skip
def test_nonsense_is_answered_in_a_sentence(offer, said, error):
    [answer] = Session(offer).answer(said)
    assert error in answer["error"]


@pytest.mark.parametrize("key", ["brain", "topology", "floor", "beside", "accuracy", "robots", "trial", "x" * 5000])
@pytest.mark.parametrize("value", ["x" * 9000, "[" * 9000])
def test_what_is_long_is_not_said_again_in_full(offer, key, value):
    asked = {"setting": "2", key: value}
    [answer] = Session(offer).answer(json.dumps({"do": "begin", "ask": asked}))
    assert key[:40] in answer["error"] or "not a value of TOML" in answer["error"]
    assert "internal error" not in answer["error"]
    assert len(answer["error"]) < 500


def test_random_words_are_answered(offer):
    chance = random.Random(3)
    session = Session(offer)
    session.answer('{"do": "begin", "ask": {}}')
    numbers = [0, 1, -1, 5, 61, 2**31, 2**70, 1.5, True, None, "7", [], {}, float("nan")]
    for _ in range(3_000):
        kind = chance.random()
        if kind < 0.2:
            said = chance.randbytes(chance.randrange(40))
        elif kind < 0.4:
            said = "".join(chance.choices(string.printable + '{}[]":,\\\u2028\ud800', k=chance.randrange(60)))
        else:
            keys = chance.choices(["id", "do", "from", "step", "count", "tick", "robot", "side", "ask", "x"], k=5)
            words = {key: chance.choice(numbers) for key in keys}
            words["do"] = chance.choice(["frames", "robot", "begin", 3])
            if chance.random() < 0.05:
                key = chance.choice((*KEYS, "robots", "topology", "members", "body"))
                words["ask"] = {key: chance.choice(["", "-", "1", "9" * 30, "ring", "é", "../x"])}
            said = json.dumps(words)
        for answer in session.answer(said):
            if isinstance(answer, bytes):
                parsed(answer)
            else:
                json.dumps(answer, allow_nan=False)
    assert session.answer('{"id": 7, "do": "begin", "ask": {}}')[0]["scenes"]


@pytest.mark.parametrize(("asked", "crowd"), [
    ({"topology": "ring"}, 0), ({"topology": "scale-free", "robots": "30"}, 0),
    ({"topology": "full", "robots": "12"}, 0), ({"topology": "line", "robots": "410"}, 21),
    ({"topology": "torus", "robots": "12"}, 0),
])  # fmt: skip
def test_robots_of_a_network_stand_apart_within_the_picture(asked, crowd):
    [begun] = Session(offer_of(None)).answer(json.dumps({"do": "begin", "ask": asked}))
    [scene] = begun["scenes"]
    places = np.frombuffer(base64.b64decode(scene["places"]), "<f4").reshape(-1, 2)
    assert len(np.unique(places.round(4), axis=0)) == scene["robots"]
    assert places.min() > 0.0
    assert places.max() < 1.0
    assert (scene["crowd"], scene["wraps"]) == (crowd, asked["topology"] == "torus")
    apart = np.linalg.norm(places[:, np.newaxis] - places, axis=2) + 9.0 * np.eye(len(places))
    assert crowd or scene["room"] == pytest.approx(np.median(apart.min(axis=1)), abs=1e-5)


def test_a_grid_is_drawn_in_its_rows_and_columns():
    show = show_of({"topology": "{name = 'grid', columns = 3}", "robots": "12"})
    places = places_of_robots(show.setting, show.trace.given.links)
    apart = np.linalg.norm(places[show.edges[:, 0]] - places[show.edges[:, 1]], axis=1)
    np.testing.assert_allclose(apart, 1 / 4)  # of four rows
