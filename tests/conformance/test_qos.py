"""Profiles of quality of service."""

import pytest
from rclpy.duration import Duration
from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    InvalidQoSProfileException,
    LivelinessPolicy,
    QoSCompatibility,
    QoSDurabilityPolicy,
    QoSHistoryPolicy,
    QoSLivelinessPolicy,
    QoSPolicyKind,
    QoSPresetProfiles,
    QoSProfile,
    QoSReliabilityPolicy,
    ReliabilityPolicy,
    qos_check_compatible,
    qos_policy_name_from_kind,
    qos_profile_best_available,
    qos_profile_default,
    qos_profile_parameter_events,
    qos_profile_parameters,
    qos_profile_sensor_data,
    qos_profile_services_default,
    qos_profile_system_default,
    qos_profile_unknown,
)
from std_msgs.msg import Float64


def test_a_profile_has_defaults():
    profile = QoSProfile(depth=5)
    assert profile.history == HistoryPolicy.KEEP_LAST
    assert profile.depth == 5
    assert profile.reliability == ReliabilityPolicy.RELIABLE
    assert profile.durability == DurabilityPolicy.VOLATILE
    assert profile.liveliness == LivelinessPolicy.SYSTEM_DEFAULT
    assert profile.deadline == Duration()
    assert profile.lifespan == Duration()
    assert profile.liveliness_lease_duration == Duration()
    assert profile.avoid_ros_namespace_conventions is False


def test_the_policies_have_two_names():
    assert QoSHistoryPolicy is HistoryPolicy
    assert QoSReliabilityPolicy is ReliabilityPolicy
    assert QoSDurabilityPolicy is DurabilityPolicy
    assert QoSLivelinessPolicy is LivelinessPolicy


def test_history_or_depth_must_be_given():
    with pytest.raises(InvalidQoSProfileException, match="History and/or depth"):
        QoSProfile()
    with pytest.raises(InvalidQoSProfileException, match="without a depth"):
        QoSProfile(history=HistoryPolicy.KEEP_LAST)
    assert QoSProfile(history=HistoryPolicy.KEEP_ALL).history == HistoryPolicy.KEEP_ALL


def test_keep_last_of_nothing_is_warned_of():
    with pytest.warns(UserWarning, match="zero depth with KEEP_LAST"):
        QoSProfile(depth=0)


@pytest.mark.parametrize(
    "wrong",
    [
        {"nonsense": 1},
        {"depth": "1"},
        {"depth": 1, "lifespan": 1.0},
        {"depth": 1, "deadline": 5},
        {"depth": 1, "liveliness_lease_duration": None},
        {"depth": 1, "avoid_ros_namespace_conventions": 1},
        {"depth": 1, "reliability": "RELIABLE"},
    ],
)
def test_arguments_are_checked(wrong):
    with pytest.raises(AssertionError):
        QoSProfile(**wrong)


def test_a_policy_may_be_a_number():
    assert QoSProfile(depth=1, reliability=2).reliability is ReliabilityPolicy.BEST_EFFORT
    with pytest.raises(ValueError, match="is not a valid"):
        QoSProfile(depth=1, reliability=99)


def test_profiles_compare_by_value():
    first, second = QoSProfile(depth=1), QoSProfile(depth=1)
    assert first == second
    second.deadline = Duration(seconds=1)
    assert first != second
    assert first != 1
    with pytest.raises(TypeError, match="unhashable"):
        hash(first)


def test_a_profile_is_printed_with_all_policies():
    text = str(QoSProfile(depth=1))
    assert text.startswith("QoSProfile(history=")
    assert "depth=1, reliability=" in text
    assert text.endswith("avoid_ros_namespace_conventions=False)")


def test_presets():
    assert qos_profile_default == QoSProfile(depth=10)
    assert qos_profile_services_default == QoSProfile(depth=10)
    assert qos_profile_sensor_data == QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
    assert qos_profile_parameters == QoSProfile(depth=1000)
    assert qos_profile_parameter_events == QoSProfile(depth=1000)
    assert qos_profile_system_default.reliability == ReliabilityPolicy.SYSTEM_DEFAULT
    assert qos_profile_unknown.history == HistoryPolicy.UNKNOWN
    assert qos_profile_best_available.durability == DurabilityPolicy.BEST_AVAILABLE


def test_presets_and_policies_have_short_keys():
    assert QoSPresetProfiles.SENSOR_DATA.value == qos_profile_sensor_data
    assert QoSPresetProfiles.get_from_short_key("sensor_data") == qos_profile_sensor_data
    assert "services_default" in QoSPresetProfiles.short_keys()
    assert ReliabilityPolicy.get_from_short_key("best_effort") == ReliabilityPolicy.BEST_EFFORT
    assert DurabilityPolicy.TRANSIENT_LOCAL.short_key == "transient_local"
    assert "keep_all" in HistoryPolicy.short_keys()
    assert qos_policy_name_from_kind(QoSPolicyKind.DURABILITY) == "DURABILITY"
    assert qos_policy_name_from_kind(16) == "RELIABILITY"


BEST_EFFORT = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
RELIABLE = QoSProfile(depth=1)
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
IN_TIME = QoSProfile(depth=1, deadline=Duration(seconds=1))
LATE = QoSProfile(depth=1, deadline=Duration(seconds=2))
MANUAL = QoSProfile(depth=1, liveliness=LivelinessPolicy.MANUAL_BY_TOPIC)
AUTOMATIC = QoSProfile(depth=1, liveliness=LivelinessPolicy.AUTOMATIC)


@pytest.mark.parametrize(
    ("offered", "requested", "reason"),
    [
        (RELIABLE, BEST_EFFORT, ""),
        (BEST_EFFORT, RELIABLE, "Best effort publisher and reliable subscription"),
        (LATCHED, RELIABLE, ""),
        (RELIABLE, LATCHED, "Volatile publisher and transient local subscription"),
        (IN_TIME, LATE, ""),
        (LATE, IN_TIME, "Subscription deadline is less than publisher deadline"),
        (RELIABLE, IN_TIME, "Subscription has a deadline, but publisher does not"),
        (AUTOMATIC, MANUAL, "liveliness is automatic and subscription's is manual"),
    ],
)
def test_compatibility(node, offered, requested, reason):
    compatibility, text = qos_check_compatible(offered, requested)
    # Liveliness is left to the system in most of these profiles, which is a warning.
    assert (compatibility == QoSCompatibility.ERROR) == bool(reason)
    assert reason in text
    publisher = node.create_publisher(Float64, "x", offered)
    node.create_subscription(Float64, "x", print, requested)
    assert publisher.get_subscription_count() == (0 if reason else 1)


def test_compatible_profiles_have_no_reason():
    assert qos_check_compatible(AUTOMATIC, AUTOMATIC) == (QoSCompatibility.OK, "")


def test_what_is_not_known_yet_is_a_warning():
    compatibility, text = qos_check_compatible(qos_profile_system_default, RELIABLE)
    assert compatibility == QoSCompatibility.WARNING
    assert text


def test_best_available_fits_what_there_is(ros, node):
    node.create_publisher(Float64, "latched", LATCHED)
    node.create_publisher(Float64, "weak", BEST_EFFORT)
    for topic in ("latched", "weak"):
        ros.wait_until(lambda topic=topic: node.get_publishers_info_by_topic(topic))
    for topic, reliability, durability in (
        ("latched", ReliabilityPolicy.RELIABLE, DurabilityPolicy.TRANSIENT_LOCAL),
        ("weak", ReliabilityPolicy.BEST_EFFORT, DurabilityPolicy.VOLATILE),
    ):
        subscription = node.create_subscription(Float64, topic, print, qos_profile_best_available)
        assert subscription.get_publisher_count() == 1
        ros.wait_until(lambda topic=topic: node.get_subscriptions_info_by_topic(topic))
        (info,) = node.get_subscriptions_info_by_topic(topic)
        assert info.qos_profile.reliability == reliability
        assert info.qos_profile.durability == durability


def test_a_best_available_publisher_offers_the_most(ros, node):
    node.create_subscription(Float64, "x", print, LATCHED)
    node.create_subscription(Float64, "x", print, IN_TIME)
    ros.wait_until(lambda: len(node.get_subscriptions_info_by_topic("x")) == 2)
    publisher = node.create_publisher(Float64, "x", qos_profile_best_available)
    assert publisher.get_subscription_count() == 2
    ros.wait_until(lambda: node.get_publishers_info_by_topic("x"))
    (info,) = node.get_publishers_info_by_topic("x")
    assert info.qos_profile.reliability == ReliabilityPolicy.RELIABLE
    assert info.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL
    assert info.qos_profile.deadline == Duration(seconds=1)
