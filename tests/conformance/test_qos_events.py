"""Callbacks for what happens to publishers and subscriptions besides messages."""

import pytest
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.duration import Duration
from rclpy.event_handler import (
    PublisherEventCallbacks,
    QoSLivelinessChangedInfo,
    QoSLivelinessLostInfo,
    QoSOfferedDeadlineMissedInfo,
    QoSOfferedIncompatibleQoSInfo,
    QoSPublisherMatchedInfo,
    QoSRequestedDeadlineMissedInfo,
    QoSRequestedIncompatibleQoSInfo,
    QoSSubscriptionMatchedInfo,
    SubscriptionEventCallbacks,
)
from rclpy.qos import (
    DurabilityPolicy,
    LivelinessPolicy,
    QoSPolicyKind,
    QoSProfile,
    ReliabilityPolicy,
)
from std_msgs.msg import Float64

BEST_EFFORT = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
QUICK = QoSProfile(depth=1, deadline=Duration(seconds=0.02))
LIVELY = QoSProfile(
    depth=1,
    liveliness=LivelinessPolicy.MANUAL_BY_TOPIC,
    liveliness_lease_duration=Duration(seconds=0.05),
)

pytestmark = pytest.mark.filterwarnings("ignore:QoSEventHandler:DeprecationWarning")


@pytest.mark.parametrize("publisher_is_first", [True, False])
def test_both_sides_are_told_of_incompatible_qos(ros, node, publisher_is_first):
    offered, requested = [], []

    def publish():
        callbacks = PublisherEventCallbacks(incompatible_qos=offered.append)
        node.create_publisher(Float64, "x", BEST_EFFORT, event_callbacks=callbacks)

    def subscribe():
        callbacks = SubscriptionEventCallbacks(incompatible_qos=requested.append)
        node.create_subscription(Float64, "x", print, 1, event_callbacks=callbacks)

    for create in (publish, subscribe) if publisher_is_first else (subscribe, publish):
        create()
    ros.spin_until(lambda: offered and requested)
    assert isinstance(offered[0], QoSOfferedIncompatibleQoSInfo)
    assert isinstance(requested[0], QoSRequestedIncompatibleQoSInfo)
    for event in (offered[0], requested[0]):
        assert event.total_count == 1
        assert event.total_count_change == 1
        assert event.last_policy_kind == QoSPolicyKind.RELIABILITY


@pytest.mark.parametrize(
    ("requested", "kind"),
    [
        (QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL), "DURABILITY"),
        (QUICK, "DEADLINE"),
        (LIVELY, "LIVELINESS"),
    ],
)
def test_the_policy_is_named(ros, node, requested, kind):
    events = []
    callbacks = SubscriptionEventCallbacks(incompatible_qos=events.append)
    node.create_subscription(Float64, "x", print, requested, event_callbacks=callbacks)
    node.create_publisher(Float64, "x", 1)
    ros.spin_until(lambda: events)
    assert events[0].last_policy_kind == QoSPolicyKind[kind]


def test_events_add_up(ros, node):
    events = []
    callbacks = PublisherEventCallbacks(incompatible_qos=events.append)
    node.create_publisher(Float64, "x", BEST_EFFORT, event_callbacks=callbacks)
    for _ in range(2):
        node.create_subscription(Float64, "x", print, 1)
    ros.spin_until(lambda: events)
    assert (events[0].total_count, events[0].total_count_change) == (2, 2)
    node.create_subscription(Float64, "x", print, 1)
    ros.spin_until(lambda: len(events) == 2)
    assert (events[1].total_count, events[1].total_count_change) == (3, 1)


def test_by_default_incompatible_qos_is_a_warning(ros, node, capfd):
    node.create_publisher(Float64, "x", BEST_EFFORT)
    node.create_subscription(Float64, "x", print, 1)
    errors = ""

    def both_told():
        nonlocal errors
        errors += capfd.readouterr().err
        return errors.count("incompatible QoS") == 2

    ros.spin_until(both_told)
    assert "[WARN]" in errors
    end = "Last incompatible policy: RELIABILITY"
    for text in (
        f"on topic 'x', requesting incompatible QoS. No messages will be sent to it. {end}",
        f"on topic 'x', offering incompatible QoS. No messages will be received from it. {end}",
        "[n]: New subscription discovered",
        "[n]: New publisher discovered",
    ):
        assert text in errors


def test_the_warnings_can_be_switched_off(ros, node, capfd):
    node.create_publisher(
        Float64,
        "x",
        BEST_EFFORT,
        event_callbacks=PublisherEventCallbacks(use_default_callbacks=False),
    )
    node.create_subscription(
        Float64,
        "x",
        print,
        1,
        event_callbacks=SubscriptionEventCallbacks(use_default_callbacks=False),
    )
    ros.spin_for(0.1)
    assert capfd.readouterr().err == ""


def test_both_sides_are_told_of_matches(ros, node):
    published, subscribed = [], []
    node.create_publisher(
        Float64, "x", 1, event_callbacks=PublisherEventCallbacks(matched=published.append)
    )
    subscription = node.create_subscription(
        Float64,
        "x",
        print,
        1,
        event_callbacks=SubscriptionEventCallbacks(matched=subscribed.append),
    )
    ros.spin_until(lambda: published and subscribed)
    assert isinstance(published[0], QoSPublisherMatchedInfo)
    assert isinstance(subscribed[0], QoSSubscriptionMatchedInfo)
    for event in (published[0], subscribed[0]):
        assert (event.total_count, event.total_count_change) == (1, 1)
        assert (event.current_count, event.current_count_change) == (1, 1)
    node.destroy_subscription(subscription)
    ros.spin_until(lambda: len(published) == 2)
    assert (published[1].total_count, published[1].total_count_change) == (1, 0)
    assert (published[1].current_count, published[1].current_count_change) == (0, -1)


def test_both_sides_are_told_of_a_missed_deadline(ros, node):
    offered, requested = [], []
    publisher = node.create_publisher(
        Float64, "x", QUICK, event_callbacks=PublisherEventCallbacks(deadline=offered.append)
    )
    node.create_subscription(
        Float64,
        "x",
        lambda _: None,
        QUICK,
        event_callbacks=SubscriptionEventCallbacks(deadline=requested.append),
    )
    publisher.publish(Float64())
    ros.spin_until(lambda: offered and requested)
    assert isinstance(offered[0], QoSOfferedDeadlineMissedInfo)
    assert isinstance(requested[0], QoSRequestedDeadlineMissedInfo)
    for event in (offered[0], requested[0]):
        assert event.total_count >= 1
        assert event.total_count_change >= 1


def test_both_sides_are_told_of_liveliness(ros, node):
    lost, changed = [], []
    publisher = node.create_publisher(
        Float64, "x", LIVELY, event_callbacks=PublisherEventCallbacks(liveliness=lost.append)
    )
    node.create_subscription(
        Float64,
        "x",
        print,
        LIVELY,
        event_callbacks=SubscriptionEventCallbacks(liveliness=changed.append),
    )
    publisher.assert_liveliness()
    ros.spin_until(lambda: lost and changed and changed[-1].not_alive_count == 1)
    assert isinstance(lost[0], QoSLivelinessLostInfo)
    assert lost[0].total_count >= 1
    assert isinstance(changed[0], QoSLivelinessChangedInfo)
    assert changed[-1].alive_count == 0


def test_events_run_in_the_group_they_are_given(ros, node):
    group = ReentrantCallbackGroup()
    events = []

    async def on_match(event):
        events.append(event)

    node.create_publisher(
        Float64,
        "x",
        1,
        callback_group=group,
        event_callbacks=PublisherEventCallbacks(matched=on_match),
    )
    node.create_subscription(Float64, "x", print, 1)
    ros.spin_until(lambda: events)


def test_a_callback_that_raises_raises_out_of_spin(ros, node):
    def boom(_):
        raise ValueError("boom")

    node.create_publisher(Float64, "x", 1, event_callbacks=PublisherEventCallbacks(matched=boom))
    node.create_subscription(Float64, "x", print, 1)
    with pytest.raises(ValueError, match="boom"):
        ros.spin_until(lambda: False)


def test_callbacks_are_given_by_name():
    with pytest.raises(TypeError):
        PublisherEventCallbacks(print)
    with pytest.raises(TypeError):
        SubscriptionEventCallbacks(nonsense=print)


def test_callbacks_for_incompatible_types_are_taken(node):
    callback = lambda event: None  # noqa: E731
    publisher = PublisherEventCallbacks(incompatible_type=callback)
    subscription = SubscriptionEventCallbacks(incompatible_type=callback)
    assert publisher.incompatible_type is subscription.incompatible_type is callback
    node.create_publisher(Float64, "x", 1, event_callbacks=publisher)
    node.create_subscription(Float64, "x", print, 1, event_callbacks=subscription)
