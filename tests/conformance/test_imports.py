"""Which modules a program finds as ``rclpy.something`` that imported nothing but ``rclpy``."""

import os
import subprocess
import sys

import pytest
import rclpy
from rclpy.context import Context
from rclpy.event_handler import IncompatibleTypeInfo, UnsupportedEventTypeError
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


def test_what_only_other_middleware_uses_is_there():
    assert issubclass(UnsupportedEventTypeError, RuntimeError)
    assert isinstance(IncompatibleTypeInfo, type)
    assert rclpy.get_rmw_implementation_identifier() in get_available_rmw_implementations()
