"""A topic that is heard for a moment now and then."""

from rclpy.node import Node
from sensor_msgs.msg import JointState

from bdt_bags.recorder.topic_choice import project_topics
from bdt_live.short_looks import ENOUGH, PAUSE, ShortLooks
from bdt_msgs_py.qos import publisher_profile
from bdt_msgs_py.topics import MEASUREMENT


def test_a_look_hears_enough_and_the_next_one_begins_after_a_pause(ros):
    machine, listener = ros.create(Node, "machine"), ros.create(Node, "listener")
    publisher = machine.create_publisher(
        JointState, MEASUREMENT.name, publisher_profile(MEASUREMENT)
    )
    (chosen,), _ = project_topics(listener, MEASUREMENT.name)
    heard = []
    looks = ShortLooks(listener, chosen, lambda data, info: heard.append(info))
    for begin in (100.0, 100.0 + PAUSE):
        looks.look(begin)
        ros.spin_until(lambda: publisher.get_subscription_count() == 1)
        heard.clear()
        for _ in range(ENOUGH - 1):
            publisher.publish(JointState())
        ros.spin_until(lambda: len(heard) == ENOUGH - 1)
        looks.look(begin + 1.0)
        assert publisher.get_subscription_count() == 1
        publisher.publish(JointState())
        ros.spin_until(lambda: len(heard) == ENOUGH)
        assert all(info["source_timestamp"] for info in heard)
        looks.look(begin + 2.0)
        ros.spin_until(lambda: publisher.get_subscription_count() == 0)
        looks.look(begin + 0.99 * PAUSE)
        assert publisher.get_subscription_count() == 0
