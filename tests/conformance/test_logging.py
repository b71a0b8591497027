"""Logging: what is written, where, and when not."""

import re
import subprocess
import sys
from pathlib import Path

import pytest
import rclpy.logging
from rcl_interfaces.msg import Log
from rcl_interfaces.srv import GetLoggerLevels, SetLoggerLevels
from rclpy.clock import Clock, ClockType, ROSClock
from rclpy.context import Context
from rclpy.impl.logging_severity import LoggingSeverity
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.time import Time


@pytest.fixture(autouse=True)
def _fresh_levels():
    yield
    rclpy.logging.clear_config()


@pytest.fixture
def logger():
    return rclpy.logging.get_logger("a.b")


def test_a_line_has_severity_time_and_name(logger, capfd):
    assert logger.info("text")
    assert re.fullmatch(r"\[INFO\] \[\d{10}\.\d{9}\] \[a\.b\]: text\n", capfd.readouterr().err)


def test_levels_are_inherited(logger):
    assert logger.get_effective_level() is LoggingSeverity.INFO
    assert not logger.debug("no")
    rclpy.logging.set_logger_level("a", LoggingSeverity.ERROR)
    assert not logger.warning("no")
    assert logger.error("yes")
    logger.get_child("c").set_level(LoggingSeverity.DEBUG)
    assert rclpy.logging.get_logger("a.b.c").debug("yes")
    assert not logger.is_enabled_for(LoggingSeverity.WARN)


def test_levels_come_from_the_command_line(logger):
    context = Context()
    context.init(args=["--ros-args", "--log-level", "warn", "--log-level", "a:=debug"])
    assert logger.get_effective_level() is LoggingSeverity.DEBUG
    assert rclpy.logging.get_logger("x").get_effective_level() is LoggingSeverity.WARN
    context.shutdown()


def test_filters(logger):
    clock = Clock()
    results = [
        (
            logger.info("once", once=True),
            logger.info("skip", skip_first=True),
            logger.info("slow", throttle_duration_sec=60.0),
            logger.info("clock", throttle_duration_sec=1e-9, throttle_time_source_type=clock),
        )
        for _ in range(3)
    ]
    once, skip, slow, fast = zip(*results, strict=True)
    assert once == (True, False, False)
    assert skip == (False, True, True)
    assert slow == (True, False, False)
    assert fast == (True, True, True)


def test_unknown_options_and_incomplete_filters_are_errors(logger):
    with pytest.raises(TypeError, match="recognized logging options"):
        logger.info("x", wrong=1)
    with pytest.raises(TypeError, match="throttle_duration_sec"):
        logger.info("x", throttle_time_source_type=Clock())
    with pytest.raises(ValueError, match="must not be empty"):
        logger.get_child("")


def test_one_place_logs_with_one_severity(logger):
    def log(severity):
        logger.log("x", severity)

    log(LoggingSeverity.INFO)
    with pytest.raises(ValueError, match="severity cannot be changed"):
        log(LoggingSeverity.WARN)


def test_messages_go_to_rosout_with_their_origin(ros):
    node = ros.node("n")
    received = []
    listener = ros.node("listener")
    profile = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    node.get_logger().get_child("part").error("bad")
    listener.create_subscription(Log, "/rosout", received.append, profile)
    ros.spin_until(lambda: received)
    message = received[0]
    assert (message.name, message.msg, message.level) == ("n.part", "bad", 40)
    assert message.file == __file__
    assert message.function == "test_messages_go_to_rosout_with_their_origin"
    assert message.line > 0


def test_rosout_can_be_off(ros):
    node = Node("n", context=ros.context, enable_rosout=False)
    assert node.count_publishers("/rosout") == 0
    node.destroy_node()


def test_levels_are_a_service_on_request(ros):
    node = Node("n", context=ros.context, enable_logger_service=True)
    ros.nodes.append(node)
    ros.executor.add_node(node)
    setter = node.create_client(SetLoggerLevels, "n/set_logger_levels")
    getter = node.create_client(GetLoggerLevels, "n/get_logger_levels")
    assert setter.wait_for_service(20.0)
    assert getter.wait_for_service(20.0)
    request = SetLoggerLevels.Request()
    request.levels = [rcl_level("n", 10), rcl_level("n", 11)]
    results = ros.result(setter.call_async(request)).results
    assert [result.successful for result in results] == [True, False]
    assert node.get_logger().get_effective_level() is LoggingSeverity.DEBUG
    levels = ros.result(getter.call_async(GetLoggerLevels.Request(names=["n", "x"]))).levels
    assert [level.level for level in levels] == [10, 0]


def rcl_level(name, level):
    from rcl_interfaces.msg import LoggerLevel

    return LoggerLevel(name=name, level=level)


def test_loggers_have_names(node, logger):
    assert logger.name == "a.b"
    assert logger.get_child("c").name == "a.b.c"
    assert node.get_logger().name == "n"
    with pytest.raises(ValueError, match="must not be empty"):
        rclpy.logging.get_logger("")


def test_a_node_in_a_namespace_has_dots_in_its_loggers_name(ros):
    assert ros.node("n", namespace="/far/away").get_logger().name == "far.away.n"


@pytest.mark.parametrize(
    ("method", "severity"),
    [("debug", 10), ("info", 20), ("warning", 30), ("warn", 30), ("error", 40), ("fatal", 50)],
)
def test_methods_log_with_their_severity(logger, capfd, method, severity):
    name = LoggingSeverity(severity).name
    logger.set_level(LoggingSeverity.DEBUG)
    assert getattr(logger, method)("text")
    assert f"[{name}]" in capfd.readouterr().err
    assert logger.log("text", LoggingSeverity(severity))
    assert rclpy.logging.get_logging_severity_from_string(name.lower()) == severity


def test_levels_can_be_asked_for(logger):
    assert rclpy.logging.get_logger_level("a.b") == LoggingSeverity.UNSET
    rclpy.logging.set_logger_level("a.b", LoggingSeverity.ERROR)
    assert rclpy.logging.get_logger_level("a.b") == LoggingSeverity.ERROR
    assert rclpy.logging.get_logger_effective_level("a.b.c") == LoggingSeverity.ERROR
    with pytest.raises(RuntimeError):
        rclpy.logging.get_logging_severity_from_string("loud")


def test_a_throttle_follows_a_simulated_clock(logger):
    clock = ROSClock()
    clock._set_ros_time_is_active(True)
    logged = []
    for seconds in (10, 11, 15, 16):
        clock.set_ros_time_override(Time(seconds=seconds, clock_type=ClockType.ROS_TIME))
        logged.append(logger.info("x", throttle_duration_sec=5.0, throttle_time_source_type=clock))
    assert logged == [True, False, True, False]


def test_places_are_filtered_by_themselves(logger):
    def log():
        return logger.info("x", once=True)

    assert log()
    assert not log()
    assert logger.info("x", once=True)


def test_a_filter_does_not_count_what_the_level_stops(logger):
    def log():
        return logger.debug("x", once=True)

    assert not log()
    logger.set_level(LoggingSeverity.DEBUG)
    assert log()
    assert not log()


def test_a_log_that_cannot_be_written_ends_nobody():
    program = (
        "import rclpy.logging\n"
        "for _ in range(1000): rclpy.logging.get_logger('talker').warning('words ' * 20)\n"
        "print('goes on')"
    )
    command = [sys.executable, "-c", program]
    with Path("/dev/full").open("w", encoding="utf-8") as full:
        done = subprocess.run(
            command, check=False, stdout=subprocess.PIPE, stderr=full, text=True, timeout=60
        )
    assert done.stdout == "goes on\n"
