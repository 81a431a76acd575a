"""The example of a node of ROS 2, with a stand-in for rclpy: nodes that talk through it agree on the fill ratio."""

import importlib.util
import random
import sys
import types

import pytest

from swarmcensus.cli.commands import main
from tests.support.places import EXAMPLE

NODE = EXAMPLE / "ros2_node.py"
ROBOTS, FILL_RATIO = 5, 0.3


class Middleware:
    """Topics of one process: what is published comes to all who subscribe; timers run when told."""

    def __init__(self):
        self.subscribers, self.timers, self.published, self.stopped = {}, [], {}, None

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
            self.name, self.parameters = name, dict(parameter_overrides)

        def declare_parameter(self, name, default):
            self.parameters.setdefault(name, default)

        def get_parameter(self, name):
            return types.SimpleNamespace(value=self.parameters[name])

        def create_publisher(self, kind, topic, qos):
            def publish(message):
                assert isinstance(message, kind)
                middleware.publish(topic, message)

            return types.SimpleNamespace(publish=publish)

        def create_subscription(self, kind, topic, callback, qos):
            middleware.subscribers.setdefault(topic, []).append(callback)

        def create_timer(self, seconds, callback):
            middleware.timers.append((seconds, callback))

        def destroy_node(self):
            middleware.destroyed = True

    class Stopped(Exception):
        pass

    def spin(node):
        raise middleware.stopped or Stopped

    rclpy = types.ModuleType("rclpy")
    rclpy.init, rclpy.spin, rclpy.try_shutdown = lambda: None, spin, lambda: None
    std = {"Bool": Message, "Float32": Float32, "UInt8MultiArray": UInt8MultiArray}
    return {
        "rclpy": rclpy,
        "rclpy.executors": types.SimpleNamespace(ExternalShutdownException=Stopped),
        "rclpy.node": types.SimpleNamespace(Node=Node),
        "rclpy.qos": types.SimpleNamespace(qos_profile_sensor_data=object()),
        "std_msgs": types.ModuleType("std_msgs"),
        "std_msgs.msg": types.SimpleNamespace(**std),
    }


@pytest.fixture
def ros(tmp_path, monkeypatch):
    """The example in a deployed folder, and what carries its messages."""
    folder = tmp_path / "robot"
    words = f"deploy commons {folder} --target udp --b 0.9 --w 0.8 --message ratio16 --robot 0"
    assert main(words.split()) == 0
    middleware = Middleware()
    for name, module in modules(middleware).items():
        monkeypatch.setitem(sys.modules, name, module)
    for name in ("brain", "codec", "runtime", "settings"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    monkeypatch.syspath_prepend(folder)
    monkeypatch.setattr(sys, "dont_write_bytecode", True)  # the folder of examples is one that users see
    spec = importlib.util.spec_from_file_location("ros2_node", NODE)
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    yield example, middleware
    for name in ("brain", "codec", "runtime", "settings"):
        sys.modules.pop(name, None)


def test_nodes_that_talk_agree_on_the_fill_ratio(ros):
    example, middleware = ros
    now = types.SimpleNamespace(ms=0)
    nodes = [
        example.RobotNode(clock=lambda: now.ms, parameter_overrides=[("number", number)]) for number in range(ROBOTS)
    ]
    assert {seconds for seconds, _ in middleware.timers} == {0.025}
    chance = random.Random(1)
    for _ in range(1200):  # of 25 ms
        now.ms += 25
        for number in range(ROBOTS) if now.ms % 100 == 0 else ():
            black = chance.random() < FILL_RATIO
            right = chance.random() < (0.9 if black else 0.8)
            floor = sys.modules["std_msgs.msg"].Bool(data=black == right)
            middleware.publish(f"/robot_{number}/floor", floor)
        for _, callback in middleware.timers:
            callback()
    ticks = {node.robot.ticks for node in nodes}
    assert ticks <= {300, 301}
    assert all(node.robot.heard > 1000 for node in nodes)
    assert all(node.robot.refused == node.robot.undone == node.robot.radio_faults == 0 for node in nodes)
    believed = [middleware.published[f"/robot_{number}/estimate"][-1].data for number in range(ROBOTS)]
    assert believed == [node.robot.estimate for node in nodes]
    assert max(believed) - min(believed) < 0.01
    assert abs(sum(believed) / ROBOTS - FILL_RATIO) < 0.04
    assert len(middleware.published["/robot_0/estimate"]) == nodes[0].robot.ticks


@pytest.mark.parametrize("stopped", [KeyboardInterrupt, None])
def test_ctrl_c_ends_a_node(ros, stopped):
    example, middleware = ros
    middleware.stopped = stopped
    example.main()
    assert middleware.destroyed
