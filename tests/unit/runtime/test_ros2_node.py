"""The example of a node of ROS 2, with a stand-in for rclpy: nodes that talk through it agree on the fill ratio."""

import importlib.util
import os
import random
import sys
import types
from contextlib import closing

import pytest

from swarmcensus.brains import load
from swarmcensus.cli.commands import main as cli
from swarmcensus.robots.logs.logs import read_log
from swarmcensus.robots.swarm.fleet import Fleet, Reporting
from swarmcensus.robots.swarm.links import Network
from swarmcensus.runtime.reports import STOP
from tests.support.places import DATA, EXAMPLE

NODE = EXAMPLE / "ros2_node.py"
ROBOTS, FILL_RATIO = 5, 0.3


class Middleware:
    """Topics of one process: what is published comes to all who subscribe; timers run when asked to, at `ms`."""

    ms = 1_000_000

    def __init__(self):
        self.subscribers, self.timers, self.published, self.stopped, self.depths, self.nodes = {}, [], {}, None, {}, []

    def publish(self, topic, message):
        self.published.setdefault(topic, []).append(message)
        for callback in self.subscribers.get(topic, []):
            callback(message)


def modules(middleware):
    """What the example imports of ROS."""

    class Message:
        def __init__(self, data):
            self.data = data

    class UInt8MultiArray(Message):
        def __init__(self, data):
            assert all(type(x) is int and 0 <= x < 256 for x in data)
            super().__init__(data)

    class Float32(Message):
        def __init__(self, data):
            assert isinstance(data, float)
            super().__init__(data)

    class Node:
        def __init__(self, name, parameter_overrides=()):
            self.name, self.parameters, self.topics, self.timers = name, dict(parameter_overrides), [], []
            middleware.nodes.append(self)

        def declare_parameter(self, name, default):
            self.parameters.setdefault(name, default)

        def get_parameter(self, name):
            return types.SimpleNamespace(value=self.parameters[name])

        def get_clock(self):
            return types.SimpleNamespace(now=lambda: types.SimpleNamespace(nanoseconds=middleware.ms * 1_000_000))

        def create_publisher(self, kind, topic, qos):
            assert not topic.startswith("/")  # so that a namespace separates swarms
            middleware.depths[topic] = qos if isinstance(qos, int) else qos.depth

            def publish(message):
                assert isinstance(message, kind)
                middleware.publish(topic, message)

            return types.SimpleNamespace(publish=publish)

        def create_subscription(self, kind, topic, callback, qos):
            middleware.subscribers.setdefault(topic, []).append(callback)
            self.topics.append((topic, callback))

        def create_timer(self, seconds, callback):
            middleware.timers.append((seconds, callback))
            self.timers.append((seconds, callback))

        def destroy_node(self):
            middleware.destroyed = True
            for topic, callback in self.topics:
                middleware.subscribers[topic].remove(callback)
            for timer in self.timers:
                middleware.timers.remove(timer)

    class Stopped(Exception):
        pass

    def spin(node):
        raise middleware.stopped or Stopped

    rclpy = types.ModuleType("rclpy")
    rclpy.init, rclpy.spin, rclpy.try_shutdown = lambda: None, spin, lambda: None
    std = {"Bool": Message, "Float32": Float32, "UInt8MultiArray": UInt8MultiArray}
    space = types.SimpleNamespace
    best = {"qos_profile_sensor_data": space(depth=5), "ReliabilityPolicy": space(BEST_EFFORT=2)}
    return {
        "rclpy": rclpy, "rclpy.executors": space(ExternalShutdownException=Stopped), "rclpy.node": space(Node=Node),
        "rclpy.qos": space(QoSProfile=space, **best),
        "std_msgs": types.ModuleType("std_msgs"), "std_msgs.msg": space(**std),
    }  # fmt: skip


@pytest.fixture
def ros(request, tmp_path, monkeypatch):
    """The example in a deployed folder, and what carries its messages."""
    folder = tmp_path / "robot"
    brain = getattr(request, "param", "commons")
    words = f"deploy {brain} {folder} --target udp --message ratio16 --log 10000000"
    assert cli([*words.split(), "--accuracy", "{black = 0.9, white = 0.8}"]) == 0
    middleware = Middleware()
    for name, module in modules(middleware).items():
        monkeypatch.setitem(sys.modules, name, module)
    deployed = ("brain", "codec", "runtime", "settings", "main", "log", "reports")
    for name in deployed:
        monkeypatch.delitem(sys.modules, name, raising=False)
    monkeypatch.syspath_prepend(folder)
    monkeypatch.chdir(folder)
    monkeypatch.setattr(sys, "dont_write_bytecode", True)  # the folder of examples is one that users see
    spec = importlib.util.spec_from_file_location("ros2_node", NODE)
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    yield example, middleware
    for node in middleware.nodes:
        if hasattr(node, "robot"):
            node.robot.log.close()
    for name in deployed:
        sys.modules.pop(name, None)


class World:
    """Nodes, their floor and their time."""

    def __init__(self, ros):
        self.example, self.middleware = ros
        self.chance = random.Random(1)

    def node(self, number, **parameters):
        return self.example.RobotNode(parameter_overrides=list({"number": number, **parameters}.items()))

    def run(self, ticks):
        for _ in range(4 * ticks):
            self.middleware.ms += 25
            for number in range(ROBOTS) if self.middleware.ms % 100 == 0 else ():
                black = self.chance.random() < FILL_RATIO
                right = self.chance.random() < (0.9 if black else 0.8)
                self.see(number, black == right)
            for _, callback in list(self.middleware.timers):
                callback()

    def see(self, number, black):
        self.middleware.publish(f"robot_{number}/floor", sys.modules["std_msgs.msg"].Bool(data=black))


def test_nodes_that_talk_agree_on_the_fill_ratio(ros):
    world = World(ros)
    nodes = [world.node(number) for number in range(ROBOTS)]
    assert {seconds for seconds, _ in world.middleware.timers} == {0.025}
    world.run(300)
    assert {node.robot.ticks for node in nodes} <= {300, 301}
    assert all(node.robot.heard > 1000 for node in nodes)
    assert all(node.robot.refused == node.robot.undone == node.robot.radio_faults == 0 for node in nodes)
    published = world.middleware.published
    believed = [published[f"robot_{number}/estimate"][-1].data for number in range(ROBOTS)]
    assert believed == [node.robot.estimate for node in nodes]
    assert max(believed) - min(believed) < 0.01
    assert abs(sum(believed) / ROBOTS - FILL_RATIO) < 0.04
    assert len(published["robot_0/estimate"]) == nodes[0].robot.ticks


def test_a_node_that_starts_again_is_heard_at_once_and_its_run_is_lived_again(ros, tmp_path, accepted):
    """Robot 1 is killed without a word, robot 2 is stopped; both go on from their memory with another boot count."""
    world = World(ros)
    sys.modules["settings"].SAVE_EVERY = 20
    nodes = [world.node(number) for number in range(ROBOTS)]
    world.run(110)
    nodes[1].robot.log.held.clear()
    for number in (1, 2):
        nodes[number].destroy_node()
        nodes[number] = world.node(number)
    before = nodes[0].robot.heard
    world.run(10)
    assert nodes[0].robot.heard - before >= 4 * 9
    assert [node.robot.boot for node in nodes] == [0, 1, 1, 0, 0]
    assert nodes[1].robot.ticks >= 110
    for node in nodes:
        node.destroy_node()
    assert "5 of 5 robots lived again to the bit" in accepted("relive", tmp_path / "robot").out
    starts = [state for state in read_log(tmp_path / "robot" / "robot-1.log").states if state.starts]
    assert [(state.boot, state.tick) for state in starts] == [(0, 0), (1, 100)]


@pytest.mark.parametrize("ros", [DATA / "whole.py"], indirect=True)
def test_nodes_and_boots_draw_numbers_of_their_own(ros, monkeypatch):
    """Also where nothing makes noise."""
    monkeypatch.delattr(os, "urandom")
    draws = []
    for number in (1, 1, 2):
        random.seed(7)
        node = World(ros).node(number)
        draws.append(node.robot.draws())
        node.destroy_node()
    assert len(set(draws)) == 3


@pytest.mark.parametrize("topics", [False, True])
@pytest.mark.parametrize("ros", ["commons --report 127.0.0.1"], indirect=True)
def test_nodes_are_started_watched_and_stopped(ros, tmp_path, topics):
    """Over UDP, as boards are, or over topics and a gateway."""
    world = World(ros)
    with closing(Network(("127.0.0.1", 0))) as link:
        sys.modules["settings"].REPORT = link.socket.getsockname()
        nodes = [world.node(number, topics=topics) for number in range(ROBOTS)]
        gateway = ros[0].Gateway() if topics else None
        fleet = Fleet(tmp_path, load("commons"), [link], {number: Reporting() for number in range(ROBOTS)})
        world.run(9)
        fleet.listen()
        assert all(robot.waits for robot in fleet.robots.values())
        fleet.start([*fleet.robots])
        for _ in range(30):
            world.run(1)
            fleet.listen()
        for number, node in enumerate(nodes):
            robot = fleet.robots[number]
            assert (robot.ticks, robot.lost, robot.estimate) == (node.robot.ticks, 0, node.robot.estimate)
            fleet.tell(number, STOP)
        assert {node.robot.ticks for node in nodes} <= {30, 31}
        world.run(9)
        assert {node.robot.ticks for node in nodes} <= {30, 31}
        for one in [gateway.link] if gateway else [node.reports.link for node in nodes]:
            one.socket.close()


def test_ticks_follow_the_clock_of_ros(ros):
    """No wall time passes; a simulator has no time before its first message, and may be set back."""
    world, clock = World(ros), ros[1]
    clock.ms = 0
    node = world.node(0)
    for callback in [callback for _, callback in clock.timers] * 9:
        callback()
    assert node.robot.ticks == 0
    ticks = []
    for begin in (7_200_000, 3_600_000, 3_600_100):  # its first time, it is set back, it goes on
        clock.ms = begin
        world.run(50)
        ticks.append(node.robot.ticks)
    assert (ticks, node.robot.missed) == ([50, 100, 150], 0)


def test_a_node_reads_the_newest_reading(ros):
    world = World(ros)
    node = world.node(0)
    for black in [True] * 50 + [False]:
        world.see(0, black)
    assert (node.sensor.read(), node.sensor.read()) == (False, None)


def test_datagrams_of_all_robots_wait_for_a_tick(ros):
    world = World(ros)
    node = world.node(0, depth=40, folder="kept")
    assert world.middleware.depths["swarm/messages"] == 40
    for number in range(1, 61):
        node.radio.hear(sys.modules["std_msgs.msg"].UInt8MultiArray(data=[number]))
    world.run(1)
    assert node.robot.refused == 39  # and its own


@pytest.mark.parametrize(("given", "says"), [
    *(({"number": number}, "number should be a whole number from 0 to 65535") for number in (-1, 65536, "three")),
    *(({"number": 3, "depth": depth}, "depth should be a whole number from 1") for depth in (0, -1, "many", 2.5)),
    ({}, "number should be a whole number from 0 to 65535"),
])  # fmt: skip
def test_a_node_without_a_number_is_refused(ros, given, says):
    with pytest.raises(SystemExit, match=says):
        ros[0].RobotNode(parameter_overrides=[*given.items()])


def test_each_robot_has_one_node(ros):
    """Each with a name of its own; a second one with its number would write into the same files."""
    world = World(ros)
    nodes = [world.node(number) for number in (3, 4)]
    assert [node.name for node in nodes] == ["robot_3", "robot_4"]
    with pytest.raises(SystemExit, match="robot 3 runs already in the folder"):
        world.node(3)
    nodes[0].destroy_node()
    world.node(3).destroy_node()


@pytest.mark.parametrize("stopped", [KeyboardInterrupt, None])
def test_ctrl_c_ends_a_node(ros, monkeypatch, stopped):
    example, middleware = ros
    middleware.stopped = stopped
    monkeypatch.setattr(example, "own_number", lambda: 3)
    example.main()
    assert middleware.destroyed
