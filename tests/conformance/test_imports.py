"""Which modules a program finds as ``rclpy.something`` that imported nothing but ``rclpy``."""

import importlib
import os
import subprocess
import sys

import pytest
import rclpy
from rclpy.context import Context
from rclpy.event_handler import (
    IncompatibleTypeInfo,
    SubscriptionEventCallbacks,
    UnsupportedEventTypeError,
)
from rclpy.parameter import Parameter
from rclpy.task import Future
from rclpy.utilities import get_available_rmw_implementations

AT_ONCE = (
    "constants",
    "context",
    "exceptions",
    "guard_condition",
    "impl",
    "parameter",
    "signals",
    "task",
)
WITH_A_NODE = (
    "callback_groups",
    "client",
    "clock",
    "duration",
    "event_handler",
    "executors",
    "expand_topic_name",
    "logging",
    "logging_service",
    "node",
    "parameter_service",
    "publisher",
    "qos",
    "qos_overriding_options",
    "service",
    "subscription",
    "time",
    "timer",
    "topic_endpoint_info",
    "validate_full_topic_name",
    "validate_topic_name",
)


@pytest.mark.parametrize(
    ("before", "names"),
    [("", AT_ONCE), ("rclpy.init(args=[]); rclpy.create_node('importing')", WITH_A_NODE)],
    ids=["at once", "with a node"],
)
def test_a_program_finds_modules_that_it_did_not_import(before, names):
    program = f"""
import rclpy
{before}
print([name for name in {names!r} if type(getattr(rclpy, name, None)) is not type(rclpy)])
"""
    done = subprocess.run(
        [sys.executable, "-c", program],
        check=True,
        capture_output=True,
        text=True,
        timeout=60,
        env=os.environ,
    )
    assert done.stdout == "[]\n"


def test_some_classes_are_names_of_rclpy_itself():
    assert rclpy.Context is Context
    assert rclpy.Future is Future
    assert rclpy.Parameter is Parameter
    with pytest.raises(AttributeError, match="module 'rclpy' has no attribute 'Executor'"):
        rclpy.Executor  # noqa: B018


@pytest.mark.parametrize(
    ("module", "names"),
    [
        (
            "rclpy.node",
            """
            CallbackGroup Client Clock Context Executor GuardCondition InvalidHandle
            MutuallyExclusiveCallbackGroup NodeNameNonExistentError NotInitializedException
            PARAMETER_SEPARATOR_STRING Parameter ParameterDescriptor ParameterMsg
            ParameterNotDeclaredException Publisher QoSOverridingOptions QoSProfile ROSClock
            Rate ReentrantCallbackGroup S_TO_NS Service SetParametersResult Subscription
            TimeSource Timer TopicEndpointInfo check_is_valid_msg_type expand_topic_name
            get_default_context get_logger qos_profile_services_default validate_topic_name
            """,
        ),
        ("rclpy.executors", "Client ClockType GuardCondition Task Timer timeout_sec_to_nsec"),
        ("rclpy.qos", "Duration QoSPolicyEnum"),
        ("rclpy.time", "ClockType Duration S_TO_NS"),
        ("rclpy.qos_overriding_options", "QosCallbackResult"),
    ],
)
def test_names_that_a_module_only_uses_are_found_there_too(module, names):
    place = importlib.import_module(module)
    assert [name for name in names.split() if not hasattr(place, name)] == []


def test_the_former_name_of_a_module_warns():
    sys.modules.pop("rclpy.qos_event", None)
    with pytest.warns(UserWarning, match="importing 'qos_event' is deprecated"):
        former = importlib.import_module("rclpy.qos_event")
    assert former.SubscriptionEventCallbacks is SubscriptionEventCallbacks


def test_what_only_other_middleware_uses_is_there():
    assert issubclass(UnsupportedEventTypeError, RuntimeError)
    assert isinstance(IncompatibleTypeInfo, type)
    assert rclpy.get_rmw_implementation_identifier() in get_available_rmw_implementations()
