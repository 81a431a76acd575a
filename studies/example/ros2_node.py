"""A robot as a node of ROS 2: its messages on one topic of all, its floor sensor and its estimate on topics of its own.

Put it into the folder that `swarmcensus deploy BRAIN robot --target udp --log BYTES ...` writes, and start a node for
each robot there: `python ros2_node.py --ros-args -p number:=3`. Only `RobotNode` and `main` know ROS.

/swarm/messages     std_msgs/UInt8MultiArray  datagrams of all robots
/robot_3/floor      std_msgs/Bool             what its sensor reads, True for black
/robot_3/estimate   std_msgs/Float32          the fill ratio that it believes in, after each tick

number  of this robot, 0 to 65535, another one for each
depth   datagrams that may wait until they are read, at least one of each robot
folder  where the robot keeps its memory, its boot count and its log: `swarmcensus relive` reads these logs
"""

import os
from collections import deque

import rclpy
import settings
from main import clock, made
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy, qos_profile_sensor_data
from std_msgs.msg import Bool, Float32, UInt8MultiArray


class Sensor:
    """The newest readings that have come on a topic, each of them once; older ones are of another place."""

    def __init__(self):
        self.readings = deque(maxlen=settings.READINGS)

    def start(self):
        pass

    def read(self):
        return self.readings.popleft() if self.readings else None


class Radio:
    """Datagrams that have come on a topic; `publish` broadcasts one."""

    def __init__(self, publish, depth):
        self.send = publish
        self.datagrams = deque(maxlen=depth)

    def receive(self):
        return self.datagrams.popleft() if self.datagrams else None


class RobotNode(Node):
    """Joins a robot to its topics; a timer asks four times a tick whether it is time for one."""

    def __init__(self, clock=clock, **given):
        super().__init__("robot", **given)
        number, depth, folder = self.number(), self.parameter("depth", 200), self.parameter("folder", ".")
        talk = QoSProfile(depth=depth, reliability=ReliabilityPolicy.BEST_EFFORT)
        self.messages = self.create_publisher(UInt8MultiArray, "/swarm/messages", talk)
        self.estimates = self.create_publisher(Float32, f"/robot_{number}/estimate", 10)
        self.sensor, self.radio = Sensor(), Radio(self.publish, depth)
        os.makedirs(folder, exist_ok=True)
        base = os.path.join(folder, f"robot-{number}")
        self.robot = made(self.sensor, self.radio, number, clock, f"{base}.memory", f"{base}.log")
        self.robot.most = 255  # messages a tick
        self.create_subscription(UInt8MultiArray, "/swarm/messages", self.hear, talk)
        self.create_subscription(Bool, f"/robot_{number}/floor", self.see, qos_profile_sensor_data)
        self.create_timer(settings.PERIOD / 4000, self.poll)

    def parameter(self, name, usual):
        self.declare_parameter(name, usual)
        return self.get_parameter(name).value

    def number(self):
        number = self.parameter("number", -1)
        if not 0 <= number <= 0xFFFF:
            raise SystemExit("number should be this robot's, 0 to 65535, such as --ros-args -p number:=3")
        return number

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

    def destroy_node(self):
        if self.robot.log:
            self.robot.log.close()
        super().destroy_node()


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
