"""`swarmcensus deploy --target argos`: its C++ runs in a small world that stands in for ARGoS 3."""

import json
import re
import shutil
import subprocess
from xml.etree import ElementTree

import numpy as np
import pytest

from swarmcensus.cli.commands import main
from swarmcensus.robots.logs.folders import read_recording
from swarmcensus.robots.logs.lives import relive
from tests.support.places import DATA, ROOT

STANDIN = ROOT / "tests" / "support" / "argos"
TICKS = 60
PROGRAMS = ("all.cc", "whole.cpp", "minimalistic.cpp")
NEEDED = ["--target", "argos", "--accuracy", "{black = 0.9, white = 0.8}"]
HOST = pytest.mark.skipif(not shutil.which("g++"), reason="needs g++")
STUDY = """
trials = 3
seed = 11
swarm = {robots = 30, accuracy = {black = 0.9, white = 0.7}}
schedule = {ticks = 1200}
[world]
topology = "moving"
density = [10, 1]
fill_ratio = 0.4
link_success = 0.75
body = {speed = 0.1, radio_range = 0.5, tile = 0.02}
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Two brains in one folder, whose messages begin with the same byte, built into one program with the world."""
    folder = tmp_path_factory.mktemp("argos") / "robots"
    for brain in (str(DATA / "whole.py"), "minimalistic"):
        assert main(["deploy", brain, str(folder), *NEEDED]) == 0
    file = folder / "minimalistic.cpp"
    mark = re.search("define MARK 0x..", (folder / "whole.cpp").read_text())[0]
    file.write_text(re.sub("define MARK 0x..", mark, file.read_text()))
    sources = [path for path in folder.iterdir() if path.suffix in (".cpp", ".h")]
    for include in {name for path in sources for name in re.findall("<(argos3/.*)>", path.read_text())}:
        (folder / "include" / include).parent.mkdir(parents=True, exist_ok=True)
        (folder / "include" / include).write_text('#include "argos.h"\n')
    flags = f"-std=c++17 -Wall -Wextra -Werror -ffp-contract=off -Iinclude -I{STANDIN}".split()
    flags.append(f'-DSWARMCENSUS_BRAINS="{folder}"')
    parts = ["swarmcensus_robot.cpp", "swarmcensus_floor.cpp", STANDIN / "world.cpp"]
    (folder / "all.cc").write_text("".join(f'#include "{part}"\n' for part in parts))
    subprocess.run(["g++", *flags, *PROGRAMS, "-o", "world"], cwd=folder, check=True)
    (folder / "command").write_text(json.dumps(["g++", *flags]))
    return folder


def experiment(folder, name):
    return ElementTree.parse(folder / f"{name}.argos").getroot()


def test_the_library_is_found_wherever_argos_is_started(here):
    """Also in a folder of a strange name."""
    folder = here / 'robots & "co"'
    assert main(["deploy", "minimalistic", str(folder), *NEEDED]) == 0
    made = experiment(folder, "minimalistic")
    named = {each.get("library") for each in made.iter() if "library" in each.attrib}
    assert named == {str(folder / "build" / "libswarmcensus")}


def live(folder, path, *controllers, ticks=TICKS, reset=0, datagram=18, round_ticks=1, program="world"):
    """Run robots in a new folder; returns what went wrong."""
    words = [folder / program, ticks, reset, datagram, round_ticks, *controllers]
    return subprocess.run(list(map(str, words)), cwd=path, capture_output=True, text=True).stderr


def lives(path):
    """The robots of a folder of logs, and what came of running their brains again."""
    return [(member, relive(member)) for member in read_recording(path / "day").members]


@HOST
def test_two_brains_in_one_simulation_are_run_again_to_the_bit(folder, tmp_path, accepted):
    assert live(folder, tmp_path, "whole", "whole", "minimalistic", "minimalistic", "whole") == ""
    found = lives(tmp_path)
    assert [member.number for member, _ in found] == [0, 1, 2, 3, 4]  # of both kinds of robot
    for member, life in found:
        ticks, kin = member.log.ticks, {0, 1, 4} if member.number in (0, 1, 4) else {2, 3}
        assert (life.relived, life.ticks, life.breaks, life.lost) == (TICKS, TICKS, [], [])
        assert {heard.sender for tick in ticks for heard in tick.heard} == kin - {member.number}
    whole = [member.log.ticks for member, _ in found if member.number in (0, 1, 4)]
    assert [sum(tick.looks for tick in ticks) for ticks in whole] == [12, 12, 12]  # until they are done
    assert all(0 < sum(tick.said is None for tick in ticks) < TICKS for ticks in whole)
    assert len({tick.draws for ticks in whole for tick in ticks}) == 3 * TICKS
    said = accepted("relive", tmp_path / "day", "--trace", tmp_path / "trace.csv").out  # in which each brain has a row
    for name, numbers in (("whole.py", {0, 1, 4}), ("minimalistic", {2, 3})):
        last = np.mean([member.log.ticks[-1].estimate for member, _ in found if member.number in numbers])
        assert f"{name} {last:.4f}" in " ".join(said.split())


@HOST
def test_the_result_is_that_of_the_logs(folder, tmp_path):
    live(folder, tmp_path, "minimalistic", "minimalistic", "minimalistic")
    result = json.loads((tmp_path / "result.json").read_text())
    assert result == json.loads((tmp_path / "day" / "swarm.json").read_text())
    assert abs(result["floor"] - 0.55) < 4 * (0.55 * 0.45 / 100**2) ** 0.5
    assert result["ticks"] == result["rounds"] == TICKS
    for robot, (member, _) in zip(result["robots"], lives(tmp_path), strict=True):
        ticks = member.log.ticks
        assert (robot["number"], robot["id"]) == (member.number, f"minimalistic{member.number}")
        assert robot["estimate"] == ticks[-1].estimate
        assert robot["read"] == sum(tick.looks for tick in ticks) < TICKS  # none while it avoids the walls
        assert robot["heard"] == sum(len(tick.heard) for tick in ticks) > 0
    said = live(folder, tmp_path, "minimalistic")
    assert re.search(r'logs="day": it holds "robot-[012]\.log" of another run: should be a new folder', said)


@HOST
def test_a_round_of_several_ticks_sums_up_their_readings(folder, tmp_path):
    live(folder, tmp_path, "whole", "whole", round_ticks=5)
    for member, life in lives(tmp_path):
        assert (life.relived, life.ticks) == (TICKS // 5, TICKS // 5)
        assert max(tick.looks for tick in member.log.ticks) > 1
        assert member.log.states[0].period == 500


@HOST
def test_a_reset_begins_a_new_recording(folder, tmp_path):
    live(folder, tmp_path, "whole", "whole", reset=20)
    for member, life in lives(tmp_path):
        assert [tick.tick for tick in member.log.ticks] == list(range(1, TICKS - 19))
        assert life.relived == TICKS - 20


@HOST
def test_messages_that_do_not_fit_are_refused(folder, tmp_path):
    said = live(folder, tmp_path, "whole", datagram=17)
    assert 'robot "whole0": rab_data_size is 17, and the brain' in said
    assert "needs 18 bytes" in said


@HOST
@pytest.mark.long
def test_two_libraries_with_one_name_are_refused(folder, tmp_path):
    text = (folder / "minimalistic.cpp").read_text()
    for own in ("first", "second"):
        named = re.sub(r"minimalistic_\w{8}\b", own, text.replace('"minimalistic"', '"twice"'))
        (folder / f"{own}.cpp").write_text(named)
    command = json.loads((folder / "command").read_text())
    subprocess.run([*command, "all.cc", "first.cpp", "second.cpp", "-o", "twice"], cwd=folder, check=True)
    assert "two libraries have a controller" in live(folder, tmp_path, "twice", program="twice")


@HOST
def test_robots_hear_no_more_messages_than_a_log_holds(folder, tmp_path):
    live(folder, tmp_path, *["minimalistic"] * 260, ticks=2)
    member = read_recording(tmp_path / "day").members[0]
    assert [len(tick.heard) for tick in member.log.ticks] == [0, 255]
    assert (relive(member).relived, relive(member).breaks) == (2, [])


@HOST
def test_a_result_that_cannot_be_written_is_known_before_the_run(folder, tmp_path):
    (tmp_path / "result.json").mkdir()
    assert live(folder, tmp_path, "whole") == "cannot write result.json\n"
    assert not (tmp_path / "day").exists()


def test_no_file_of_a_folder_is_replaced(tmp_path, refused):
    """Other files, and other brains, may be there; a brain whose name in C is the same may not."""
    robots = tmp_path / "robots"
    (robots / "day").mkdir(parents=True)
    for brain in ("commons", "minimalistic", "commons"):
        assert main(["deploy", brain, str(robots), *NEEDED]) == 0
    (robots / "commons.argos").write_text("mine")
    said = refused("deploy", "commons", str(robots), *NEEDED)
    assert f"the folder {robots} holds another 'commons.argos': delete it, or name a new folder" in said
    (first, second) = (tmp_path / "a-b.py", tmp_path / "a_b.py")
    for file in (first, second):
        file.write_text((DATA / "whole.py").read_text())
    assert main(["deploy", str(first), str(robots), *NEEDED]) == 0
    assert "holds another 'a_b.cpp'" in refused("deploy", str(second), str(robots), *NEEDED)


@pytest.mark.skipif(not shutil.which("cmake"), reason="needs cmake")
def test_a_wrong_place_of_argos_is_named(tmp_path):
    assert main(["deploy", "commons", str(tmp_path / "robots"), *NEEDED]) == 0
    words = ["cmake", "-B", "build", f"-DARGOS={tmp_path}"]
    done = subprocess.run(words, cwd=tmp_path / "robots", capture_output=True, text=True)
    assert done.returncode != 0
    assert f"{tmp_path}/include/argos3 is not there" in " ".join(done.stderr.split())


def test_an_experiment_has_the_papers_arena(tmp_path):
    assert main(["deploy", "covariance-intersection", str(tmp_path / "robots"), *NEEDED]) == 0
    made = experiment(tmp_path / "robots", "covariance_intersection")
    controller = made.find("controllers/covariance_intersection")
    params = {key: controller.find("params").get(key) for key in ("b", "w", "true_b", "true_w", "speed", "round_ticks")}
    assert params == {"b": "0.9", "w": "0.8", "true_b": "0.9", "true_w": "0.8", "speed": "14", "round_ticks": "1"}
    floor, entity = made.find("loop_functions"), made.find(".//distribute/entity")
    assert (entity.get("quantity"), floor.get("fill_ratio"), floor.get("tile")) == ("25", "0.55", "0.01")
    assert float(floor.get("side")) == pytest.approx(6.2036, abs=1e-4)
    assert made.find("framework/experiment").get("length") == "1000"
    north = [float(x) for x in made.find(".//box[@id='north']/body").get("position").split(",")]
    assert north[1] - 0.05 == pytest.approx(float(floor.get("side")) / 2.0)


def test_an_experiment_has_a_studys_first_setting(tmp_path):
    (tmp_path / "study.toml").write_text(STUDY)
    words = ["--target", "argos", "--study", str(tmp_path / "study.toml"), "--accuracy", "0.75"]
    assert main(["deploy", "commons", str(tmp_path / "robots"), *words]) == 0
    made = experiment(tmp_path / "robots", "commons")
    controller, floor, entity = (made.find(f".//{name}") for name in ("commons", "loop_functions", "entity"))
    params = controller.find("params")
    assert [params.get(key) for key in ("b", "w", "true_b", "true_w", "speed")] == ["0.75", "0.75", "0.9", "0.7", "10"]
    assert controller.find("sensors/range_and_bearing").get("packet_drop_prob") == "0.25"
    assert (entity.get("quantity"), entity.find("foot-bot").get("rab_range")) == ("30", "0.5")
    assert (floor.get("fill_ratio"), floor.get("tile")) == ("0.4", "0.02")
    assert float(floor.get("side")) == pytest.approx(np.sqrt(30 * np.pi * 0.25 / 10))
    experiments = made.find("framework/experiment").attrib
    assert experiments == {"length": "120", "ticks_per_second": "10", "random_seed": "11"}


def test_a_brain_has_its_parameters_and_formats_of_the_study(tmp_path, refused):
    brain = 'brain = ["voter", {file = "tracking", memory = 50, z = 2}], precision = "single"'
    text = STUDY.replace("swarm = {", f"swarm = {{{brain}, ") + 'message = "ratio16"\nfeedback = false'
    (tmp_path / "study.toml").write_text(text)
    words = ["--target", "argos", "--study", str(tmp_path / "study.toml")]

    def logged(folder, *more):
        assert main(["deploy", "tracking", str(tmp_path / folder), *words, *more]) == 0
        text = (tmp_path / folder / "tracking_logged.h").read_text()
        return dict(re.findall(r"#define ROBOT_LOG_(FORM|FLAGS|PARAMETERS) (\S.*?)  //", text))

    assert logged("as-it-is") == {"FORM": "3", "FLAGS": "4", "PARAMETERS": "{50.0f, 2.0f, 0}"}
    given = logged("given", "--parameter", "z=3", "--precision", "double", "--message", "float32")
    assert given == {"FORM": "1", "FLAGS": "0", "PARAMETERS": "{50.0, 3.0, 0}"}
    said = refused("deploy", "commons", "robots", *words)
    assert f"study file {words[-1]}: swarm.brain = voter, tracking: should have the brain" in said


@pytest.mark.parametrize(("old", "new", "says"), [
    ('topology = "moving"\ndensity = [10, 1]', 'topology = "ring"', "world.topology = 'ring'"),
    ("accuracy = {black = 0.9, white = 0.7}", 'accuracy = "U(0.6, 0.9)"', "swarm.accuracy = U(0.6,0.9)"),
    ("fill_ratio = 0.4", "fill_ratio = 0.4\nfloor = {clusters = 0.2}", "world.floor = clusters(0.2)"),
    ("speed = 0.1", "message_delay = 2", "world.body.message_delay = 2"),
    ("speed = 0.1", "radius = 0.08", "world.body.radius = 0.08"),
    ("speed = 0.1", "tick = 0.3", "world.body.tick = 0.3"),
])  # fmt: skip
def test_what_the_experiment_lacks_is_named(tmp_path, refused, old, new, says):
    assert old in STUDY
    text = STUDY.replace(old, new)
    if "ring" in new:
        text = text.partition("body")[0].replace("ticks = 1200", "rounds = 10, observations_per_round = 1")
    file = tmp_path / "study.toml"
    file.write_text(text)
    said = refused("deploy", "commons", "robots", "--target", "argos", "--study", str(file))
    assert f"study file {file}: {says}: for ARGoS it should be " in said
