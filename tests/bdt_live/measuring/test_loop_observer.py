"""The node that tells how long a loop takes from a measurement to its command."""

from rclpy.node import Node
from sensor_msgs.msg import JointState

from bdt_live.measuring.loop_observer import LoopObserver
from bdt_msgs_py.qos import publisher_profile
from bdt_msgs_py.topics import COMMAND, MEASUREMENT
from bdt_msgs_py.writing import motor_voltage, platform_position

DELAY = 0.05


def test_the_time_to_the_command_that_answers_a_measurement_is_told(ros, capsys):
    ros.create(LoopObserver)
    loop = ros.create(Node, "loop")
    measurement, command = (
        loop.create_publisher(JointState, topic.name, publisher_profile(topic))
        for topic in (MEASUREMENT, COMMAND)
    )
    ros.spin_until(
        lambda: measurement.get_subscription_count() == command.get_subscription_count() == 1
    )
    measurement.publish(platform_position(7, 0.0))
    ros.spin_for(DELAY)
    command.publish(motor_voltage(7, 1.0))
    command.publish(motor_voltage(8, 1.0))  # answers nothing
    told = []
    ros.spin_until(lambda: told.append(capsys.readouterr().out) or any(told))
    assert DELAY < float(told[-1]) < 10 * DELAY
