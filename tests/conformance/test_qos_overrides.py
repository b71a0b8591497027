"""QoS that parameters override."""

import pytest
from rcl_interfaces.msg import SetParametersResult
from rclpy.duration import Duration
from rclpy.exceptions import InvalidParameterTypeException
from rclpy.parameter import Parameter
from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    QoSPolicyKind,
    QoSProfile,
    ReliabilityPolicy,
    qos_profile_unknown,
)
from rclpy.qos_overriding_options import (
    InvalidQosOverridesError,
    QosCallbackResult,
    QoSOverridingOptions,
)
from std_msgs.msg import Float64

DEFAULTS = QoSOverridingOptions.with_default_policies()


@pytest.fixture
def node(ros):
    values = {
        "qos_overrides./x.publisher.depth": 7,
        "qos_overrides./x.publisher.reliability": "best_effort",
        "qos_overrides./x.publisher_two.deadline": 10**9,
        "qos_overrides./x.subscription.durability": "transient_local",
        "qos_overrides./bad.publisher.reliability": "perfect",
    }
    return ros.node("n", parameter_overrides=[Parameter(n, value=v) for n, v in values.items()])


def test_parameters_override_the_default_policies(node):
    publisher = node.create_publisher(
        Float64, "x", QoSProfile(depth=1), qos_overriding_options=DEFAULTS
    )
    assert publisher.qos_profile.depth == 7
    assert publisher.qos_profile.reliability == ReliabilityPolicy.BEST_EFFORT
    assert publisher.qos_profile.history == HistoryPolicy.KEEP_LAST
    history = "qos_overrides./x.publisher.history"
    assert node.get_parameter(history).value == "keep_last"
    assert node.describe_parameter(history).read_only
    assert not node.has_parameter("qos_overrides./x.publisher.durability")


def test_policies_are_chosen_and_named(node):
    options = QoSOverridingOptions([QoSPolicyKind.DEADLINE], entity_id="two")
    assert list(options.policy_kinds) == [QoSPolicyKind.DEADLINE]
    assert options.entity_id == "two"
    assert options.callback is None
    publisher = node.create_publisher(Float64, "x", 1, qos_overriding_options=options)
    assert publisher.qos_profile.deadline == Duration(seconds=1)


def test_subscriptions_have_no_lifespan(node):
    options = QoSOverridingOptions([QoSPolicyKind.LIFESPAN, QoSPolicyKind.DURABILITY])
    subscription = node.create_subscription(Float64, "x", print, 1, qos_overriding_options=options)
    assert subscription.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL
    assert not node.has_parameter("qos_overrides./x.subscription.lifespan")


def test_a_second_endpoint_takes_the_same_parameters(node):
    first, second = (
        node.create_publisher(Float64, "x", QoSProfile(depth=1), qos_overriding_options=DEFAULTS)
        for _ in range(2)
    )
    assert first.qos_profile == second.qos_profile


def test_without_options_nothing_is_declared(node):
    assert node.create_publisher(Float64, "x", 1).qos_profile.depth == 1
    assert not node.has_parameter("qos_overrides./x.publisher.depth")


def test_values_that_are_no_policies_are_errors(node):
    with pytest.raises(RuntimeError, match="Unexpected QoS override for policy `reliability`"):
        node.create_publisher(Float64, "bad", 1, qos_overriding_options=DEFAULTS)


def test_a_callback_decides(node):
    def at_most_five(profile):
        return SetParametersResult(successful=profile.depth <= 5, reason="too deep")

    options = QoSOverridingOptions([QoSPolicyKind.DEPTH], callback=at_most_five)
    with pytest.raises(InvalidQosOverridesError, match="too deep"):
        node.create_publisher(Float64, "x", 1, qos_overriding_options=options)
    node.create_publisher(Float64, "y", 1, qos_overriding_options=options)


def test_policies_are_read_in_any_case_and_described(ros):
    name = "qos_overrides./x.publisher_one.reliability"
    node = ros.node("n", parameter_overrides=[Parameter(name, value="BEST_EFFORT")])
    options = QoSOverridingOptions([QoSPolicyKind.RELIABILITY], entity_id="one")
    publisher = node.create_publisher(Float64, "x", 1, qos_overriding_options=options)
    assert publisher.qos_profile.reliability == ReliabilityPolicy.BEST_EFFORT
    description = node.describe_parameter(name).description
    assert description == "reliability for publisher `/x` with id `one`"


def test_a_policy_that_nobody_knows_is_no_default(node):
    options = QoSOverridingOptions([QoSPolicyKind.HISTORY])
    with pytest.raises(ValueError, match="QoS profile is invalid"):
        node.create_publisher(Float64, "y", qos_profile_unknown, qos_overriding_options=options)


def test_an_override_of_another_type_is_an_error(ros):
    overrides = [Parameter("qos_overrides./x.publisher.depth", value="deep")]
    node = ros.node("n", parameter_overrides=overrides)
    with pytest.raises(InvalidParameterTypeException):
        node.create_publisher(Float64, "x", 1, qos_overriding_options=DEFAULTS)


def test_options_stay_as_they_are():
    with pytest.raises(AttributeError):
        DEFAULTS.entity_id = "two"
    assert QosCallbackResult is SetParametersResult
