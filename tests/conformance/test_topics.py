"""Publishers and subscriptions."""

import pytest
from rclpy._rclpy_pybind11 import RCLError
from rclpy.duration import Duration
from rclpy.exceptions import InvalidHandle, InvalidTopicNameException
from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    QoSProfile,
    ReliabilityPolicy,
    qos_profile_sensor_data,
)
from rclpy.serialization import serialize_message
from rclpy.subscription import Subscription
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, Float64, String
from std_srvs.srv import Trigger


def test_a_message_arrives_as_it_was_sent(ros, node):
    received = []
    node.create_subscription(JointState, "state", received.append, 10)
    sent = JointState(name=["a"], position=[1.0])
    node.create_publisher(JointState, "state", 10).publish(sent)
    ros.spin_until(lambda: received)
    assert received == [sent]


def test_messages_keep_their_order(ros, node):
    received = []
    node.create_subscription(Float64, "x", lambda msg: received.append(msg.data), 100)
    publisher = node.create_publisher(Float64, "x", 100)
    for value in range(50):
        publisher.publish(Float64(data=float(value)))
    ros.spin_until(lambda: len(received) == 50)
    assert received == list(range(50))


def test_a_callback_with_two_arguments_gets_timestamps(ros, node):
    received = []
    node.create_subscription(String, "s", lambda msg, info: received.append((msg, info)), 10)
    before = node.get_clock().now().nanoseconds
    node.create_publisher(String, "s", 10).publish(String(data="x"))
    ros.spin_until(lambda: received)
    info = received[0][1]
    assert before <= info["source_timestamp"] <= node.get_clock().now().nanoseconds
    assert info["publication_sequence_number"] is None


def test_bytes_are_sent_and_received_raw(ros, node):
    received = []
    node.create_subscription(String, "s", received.append, 10, raw=True)
    payload = serialize_message(String(data="abc"))
    node.create_publisher(String, "s", 10).publish(payload)
    ros.spin_until(lambda: received)
    assert received[0][: len(payload)] == payload


def test_bytes_that_are_no_message_do_not_end_a_subscription(ros, node):
    received = []
    node.create_subscription(String, "s", received.append, 10)
    publisher = node.create_publisher(String, "s", 10)
    publisher.publish(bytes.fromhex("00010000 ff000000 61620000"))
    publisher.publish(String(data="abc"))
    # Whether the callback gets an empty message for what cannot be read is left open.
    ros.spin_until(lambda: received and received[-1].data == "abc")


def test_a_late_subscription_gets_what_a_transient_local_publisher_keeps(ros, node):
    profile = QoSProfile(depth=3, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    publisher = node.create_publisher(Float64, "kept", profile)
    for value in range(5):
        publisher.publish(Float64(data=float(value)))
    late = ros.node("late")
    received = []
    late.create_subscription(Float64, "kept", lambda msg: received.append(msg.data), profile)
    ros.spin_until(lambda: len(received) == 3)
    assert received == [2.0, 3.0, 4.0]


def test_incompatible_qos_does_not_match(ros, node):
    publisher = node.create_publisher(Float64, "x", qos_profile_sensor_data)
    reliable = node.create_subscription(Float64, "x", print, 10)
    best_effort = node.create_subscription(Float64, "x", print, qos_profile_sensor_data)
    assert best_effort.get_publisher_count() == 1
    assert reliable.get_publisher_count() == 0
    assert publisher.get_subscription_count() == 1


def test_types_must_agree(ros, node):
    publisher = node.create_publisher(Float64, "x", 10)
    node.create_subscription(String, "x", print, 10)
    assert publisher.get_subscription_count() == 0
    with pytest.raises(TypeError, match=r"Expected .*Float64.*, got .*Bool"):
        publisher.publish(Bool())


def test_a_keep_all_publisher_reports_when_all_is_acknowledged(ros, node):
    profile = QoSProfile(history=HistoryPolicy.KEEP_ALL, reliability=ReliabilityPolicy.RELIABLE)
    received = []
    node.create_subscription(Float64, "x", received.append, profile)
    publisher = node.create_publisher(Float64, "x", profile)
    for value in range(20):
        publisher.publish(Float64(data=float(value)))
    assert publisher.wait_for_all_acked()
    ros.spin_until(lambda: len(received) == 20)


@pytest.mark.parametrize(
    ("arguments", "error"),
    [
        ((Float64, "a b", 1), InvalidTopicNameException),
        ((Float64, "x", "1"), TypeError),
        ((Float64, "x", -1), ValueError),
        ((Trigger, "x", 1), RuntimeError),
        ((int, "x", 1), AttributeError),
        ((Float64, "{what}", 1), ValueError),
    ],
)
def test_bad_arguments(node, arguments, error):
    with pytest.raises(error):
        node.create_publisher(*arguments)


def test_a_callback_must_take_one_or_two_arguments(node):
    with pytest.raises(RuntimeError, match="callable with one argument"):
        node.create_subscription(Float64, "x", lambda: None, 1)


def test_a_destroyed_publisher_cannot_be_used(node):
    publisher = node.create_publisher(Float64, "x", 1)
    assert node.destroy_publisher(publisher)
    assert not node.destroy_publisher(publisher)
    with pytest.raises(InvalidHandle):
        publisher.publish(Float64())
    with pytest.raises(InvalidHandle):
        publisher.get_subscription_count()


def test_after_shutdown_nothing_is_published(ros, node):
    publisher = node.create_publisher(Float64, "x", 1)
    ros.context.shutdown()
    with pytest.raises(RCLError, match="publisher's context is invalid"):
        publisher.publish(Float64())
    with pytest.raises(RCLError, match="context is invalid"):
        node.create_publisher(Float64, "x", 1)


def test_endpoints_tell_their_properties(node):
    profile = QoSProfile(depth=3)
    publisher = node.create_publisher(Float64, "x", profile)
    subscription = node.create_subscription(Float64, "x", print, profile)
    for endpoint in (publisher, subscription):
        assert endpoint.msg_type is Float64
        assert endpoint.topic == "x"
        assert endpoint.topic_name == "/x"
        assert endpoint.qos_profile == profile
    assert publisher in list(node.publishers)
    assert list(node.subscriptions) == [subscription]
    assert subscription.callback is print
    assert not subscription.raw


def test_the_callback_can_be_replaced(ros, node):
    first, second = [], []
    subscription = node.create_subscription(Float64, "x", first.append, 10)
    publisher = node.create_publisher(Float64, "x", 10)
    publisher.publish(Float64())
    ros.spin_until(lambda: first)
    subscription.callback = lambda message, info: second.append((message, info))
    publisher.publish(Float64())
    ros.spin_until(lambda: second)
    assert len(first) == 1
    assert Subscription.CallbackType.WithMessageInfo.value == 1


def test_a_method_and_a_coroutine_are_callbacks(ros, node):
    received = []

    class Listener:
        def listen(self, message):
            received.append(message.data)

    async def listen(message):
        received.append(message.data)

    node.create_subscription(Float64, "x", Listener().listen, 10)
    node.create_subscription(Float64, "x", listen, 10)
    node.create_publisher(Float64, "x", 10).publish(Float64(data=2.0))
    ros.spin_until(lambda: len(received) == 2)
    assert received == [2.0, 2.0]


def test_keep_last_keeps_the_last(ros, node):
    received = []
    node.create_subscription(Float64, "x", lambda message: received.append(message.data), 2)
    publisher = node.create_publisher(Float64, "x", 10)
    for value in range(5):
        publisher.publish(Float64(data=float(value)))
    ros.spin_until(lambda: len(received) == 2)
    ros.spin_for(0.02)
    assert received == [3.0, 4.0]


def test_a_volatile_subscription_gets_nothing_old(ros, node):
    publisher = node.create_publisher(Float64, "x", 10)
    publisher.publish(Float64(data=1.0))
    received = []
    node.create_subscription(Float64, "x", lambda message: received.append(message.data), 10)
    publisher.publish(Float64(data=2.0))
    ros.spin_until(lambda: received)
    assert received == [2.0]


def test_every_subscription_gets_every_message(ros, node):
    received = {0: [], 1: [], 2: []}
    for values in received.values():
        node.create_subscription(Float64, "x", values.append, 10)
    publisher = node.create_publisher(Float64, "x", 10)
    assert publisher.get_subscription_count() == 3
    publisher.publish(Float64(data=1.0))
    ros.spin_until(lambda: all(received.values()))
    assert all(values == [Float64(data=1.0)] for values in received.values())


def test_raw_and_information_together(ros, node):
    received = []
    node.create_subscription(
        String, "s", lambda payload, info: received.append((payload, info)), 10, raw=True
    )
    node.create_publisher(String, "s", 10).publish(String(data="x"))
    ros.spin_until(lambda: received)
    payload, info = received[0]
    assert isinstance(payload, bytes)
    assert {"source_timestamp", "received_timestamp"} <= info.keys()


def test_nothing_is_to_be_acknowledged_by_nobody(node):
    publisher = node.create_publisher(Float64, "x", 10)
    publisher.publish(Float64())
    assert publisher.wait_for_all_acked(Duration(seconds=1))
    publisher.assert_liveliness()


def test_a_destroyed_subscription_hears_nothing(ros, node):
    received = []
    subscription = node.create_subscription(Float64, "x", received.append, 10)
    publisher = node.create_publisher(Float64, "x", 10)
    publisher.publish(Float64())
    assert node.destroy_subscription(subscription)
    assert not node.destroy_subscription(subscription)
    ros.spin_for(0.02)
    assert received == []
    assert publisher.get_subscription_count() == 0
    with pytest.raises(InvalidHandle):
        subscription.get_publisher_count()


def test_a_depth_is_a_profile(node):
    profile = node.create_publisher(Float64, "x", 7).qos_profile
    assert profile == QoSProfile(depth=7)
    assert profile.reliability == ReliabilityPolicy.RELIABLE
    assert profile.durability == DurabilityPolicy.VOLATILE
    assert profile.history == HistoryPolicy.KEEP_LAST


@pytest.mark.parametrize("callback", [None, 5, lambda: None, lambda _a, _b, _c: None])
def test_what_no_message_can_be_given_to_is_no_callback(node, callback):
    with pytest.raises(RuntimeError, match="callback should be either be callable"):
        node.create_subscription(Float64, "x", callback, 1)
    assert node.count_subscribers("x") == 0
