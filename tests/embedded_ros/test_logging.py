"""Logging: what is written, where, and when not."""

import re

import pytest
import rclpy.logging
from rcl_interfaces.msg import Log
from rcl_interfaces.srv import GetLoggerLevels, SetLoggerLevels
from rclpy.clock import Clock
from rclpy.context import Context
from rclpy.impl.logging_severity import LoggingSeverity
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile


@pytest.fixture(autouse=True)
def _fresh_levels():
    yield
    rclpy.logging.clear_config()


@pytest.fixture
def logger():
    return rclpy.logging.get_logger("a.b")


def test_a_line_has_severity_time_and_name(logger, capsys):
    assert logger.info("text")
    assert re.fullmatch(r"\[INFO\] \[\d{10}\.\d{9}\] \[a\.b\]: text\n", capsys.readouterr().err)


def test_the_format_can_be_chosen(logger, capsys, monkeypatch):
    monkeypatch.setenv("RCUTILS_CONSOLE_OUTPUT_FORMAT", "{name}|{severity}|{message}|{what}")
    logger.fatal("text")
    assert capsys.readouterr().err == "a.b|FATAL|text|{what}\n"


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
    node = ros.create(
        Node,
        "n",
    )
    received = []
    listener = ros.create(Node, "listener")
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
    assert setter.wait_for_service(5)
    assert getter.wait_for_service(5)
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
