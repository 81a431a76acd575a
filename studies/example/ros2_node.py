"""A robot as a node of ROS 2: its messages on one topic of all, its floor sensor and its estimate on topics of its own.

Put it into the folder that `swarmcensus deploy BRAIN robot --target udp ...` writes, in place of main.py, and start
a node for each robot: `python ros2_node.py --ros-args -p number:=3`. Only `RobotNode` and `main` know ROS.

/swarm/messages     std_msgs/UInt8MultiArray  datagrams of all robots
/robot_3/floor      std_msgs/Bool             what its sensor reads, True for black
/robot_3/estimate   std_msgs/Float32          the fill ratio that it believes in, after each tick
"""

import random
import time
from collections import deque

import brain
import rclpy
import settings
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from runtime import WRAP, Messages, Robot
from std_msgs.msg import Bool, Float32, UInt8MultiArray

WAITING = 1000  # datagrams and readings at most, so that memory stays bounded


class Sensor:
    """Readings that have come on a topic, each of them once."""

    def __init__(self):
        self.readings = deque(maxlen=WAITING)

    def start(self):
        pass

    def read(self):
        return self.readings.popleft() if self.readings else None


class Radio:
    """Datagrams that have come on a topic; `publish` broadcasts one."""

    def __init__(self, publish):
        self.send = publish
        self.datagrams = deque(maxlen=WAITING)

    def receive(self):
        return self.datagrams.popleft() if self.datagrams else None


def clock():
    return int(time.monotonic() * 1000) & WRAP


def robot_of(number, sensor, radio, clock):
    """The robot that settings.py describes, with this number."""
    s = settings
    return Robot(
        brain, Messages(s.LENGTHS, s.PLAN, s.MARK, s.CHECKED), sensor, radio, clock, s.B, s.W, number, s.PERIOD,
        s.READINGS, s.PARAMETERS, random.random if s.LUCK else None,
    )  # fmt: skip


class RobotNode(Node):
    """Joins a robot to its topics; a timer asks four times a tick whether it is time for one."""

    def __init__(self, clock=clock, **given):
        super().__init__("robot", **given)
        self.declare_parameter("number", 0)
        number = self.get_parameter("number").value
        self.messages = self.create_publisher(UInt8MultiArray, "/swarm/messages", qos_profile_sensor_data)
        self.estimates = self.create_publisher(Float32, f"/robot_{number}/estimate", 10)
        self.sensor, self.radio = Sensor(), Radio(self.publish)
        self.robot = robot_of(number, self.sensor, self.radio, clock)
        self.create_subscription(UInt8MultiArray, "/swarm/messages", self.hear, qos_profile_sensor_data)
        self.create_subscription(Bool, f"/robot_{number}/floor", self.see, qos_profile_sensor_data)
        self.create_timer(settings.PERIOD / 4000, self.poll)

    def publish(self, datagram):
        self.messages.publish(UInt8MultiArray(data=list(datagram)))

    def hear(self, message):
        self.radio.datagrams.append(bytes(message.data))

    def see(self, message):
        self.sensor.readings.append(message.data)

    def poll(self):
        before = self.robot.ticks
        self.robot.poll()
        if self.robot.ticks != before:
            self.estimates.publish(Float32(data=self.robot.estimate))


def main():
    rclpy.init()
    node = RobotNode()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
