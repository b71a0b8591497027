"""``ros2 topic`` as a process: its output and exit codes have the shape of Jazzy's."""

import os
import re
import signal
import subprocess

import pytest
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from ros2_commands import COMMAND, TIMEOUT_S, failure, ros2_all
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray, String

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
BEST_EFFORT = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)


def start(*words):
    return subprocess.Popen(
        [*COMMAND, "topic", *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONUNBUFFERED": "1"},
    )


def topic_all(*commands):
    """Run verbs of ``ros2 topic`` in this process; output, errors and exit code of each."""
    return ros2_all(*(("topic", *words) for words in commands))


@pytest.fixture
def robot(ros, spin_in_thread):
    """Return a node that publishes and listens in a thread."""
    node = ros.create(Node, "robot")
    data = node.create_publisher(Float64MultiArray, "data", 10)
    joints = node.create_publisher(JointState, "joints", BEST_EFFORT)
    latched = node.create_publisher(String, "latched", LATCHED)
    node.create_publisher(String, "mixed", 10)
    node.create_publisher(String, "mixed", BEST_EFFORT)
    latched.publish(String(data="kept: äöü"))
    message = JointState(name=["a", "b"], position=[0.5, 1.0])
    message.header.frame_id = "base"

    def publish():
        data.publish(Float64MultiArray(data=[1.0, 2.5, 3.0, 4.0]))
        joints.publish(message)

    node.create_timer(0.02, publish)
    node.heard = []
    node.create_subscription(String, "words", lambda msg: node.heard.append(msg.data), 10)

    spin_in_thread()
    return node


def test_topics_are_listed(robot):
    names, count, verbose, found, found_count, none, typed, unknown = topic_all(
        ("list", "-t", "--no-daemon"),
        ("list", "-c"),
        ("list", "-v"),
        ("find", "sensor_msgs/msg/JointState"),
        ("find", "-c", "std_msgs/msg/String"),
        ("find", "-c", "std_msgs/msg/Bool"),
        ("type", "/data"),
        ("type", "/nothing"),
    )
    assert names[0] == (
        "/data [std_msgs/msg/Float64MultiArray]\n/joints [sensor_msgs/msg/JointState]\n"
        "/latched [std_msgs/msg/String]\n/mixed [std_msgs/msg/String]\n"
        "/parameter_events [rcl_interfaces/msg/ParameterEvent]\n"
        "/rosout [rcl_interfaces/msg/Log]\n/words [std_msgs/msg/String]\n"
    )
    assert count == ("7\n", "", 0)
    assert verbose[0].startswith(
        "Published topics:\n * /data [std_msgs/msg/Float64MultiArray] 1 publisher\n"
    )
    assert " * /mixed [std_msgs/msg/String] 2 publishers\n" in verbose[0]
    assert verbose[0].endswith(
        "\n\nSubscribed topics:\n * /words [std_msgs/msg/String] 1 subscriber\n\n"
    )
    assert found == ("/joints\n", "", 0)
    assert found_count == ("3\n", "", 0)
    assert none == ("0\n", "", 0)
    assert typed == ("std_msgs/msg/Float64MultiArray\n", "", 0)
    assert unknown == ("", "", 1)


def test_information(robot):
    plain, verbose, unknown = topic_all(
        ("info", "/words"), ("info", "-v", "/joints"), ("info", "/nothing")
    )
    assert plain[0] == "Type: std_msgs/msg/String\nPublisher count: 0\nSubscription count: 1\n"
    assert re.fullmatch(
        r"Type: sensor_msgs/msg/JointState\n\nPublisher count: 1\n\n"
        r"Node name: robot\nNode namespace: /\nTopic type: sensor_msgs/msg/JointState\n"
        r"Topic type hash: RIHS01_[0-9a-f]{64}\nEndpoint type: PUBLISHER\n"
        r"GID: ([0-9a-f]{2}\.){15}[0-9a-f]{2}\nQoS profile:\n  Reliability: BEST_EFFORT\n"
        r"  History \(Depth\): KEEP_LAST \(5\)\n  Durability: VOLATILE\n  Lifespan: Infinite\n"
        r"  Deadline: Infinite\n  Liveliness: AUTOMATIC\n  Liveliness lease duration: Infinite\n\n"
        r"Subscription count: 0\n\n",
        verbose[0],
    )
    assert unknown == failure("Unknown topic '/nothing'")


def test_echo_asks_for_what_publishers_offer(robot):
    reliable, best_effort, latched, mixed = topic_all(
        ("echo", "--once", "/data"),
        ("echo", "--once", "joints"),
        ("echo", "--once", "/latched", "std_msgs/msg/String"),
        ("echo", "--timeout", "0.1", "/mixed"),
    )
    assert reliable[0] == (
        "layout:\n  dim: []\n  data_offset: 0\ndata:\n- 1.0\n- 2.5\n- 3.0\n- 4.0\n---\n"
    )
    assert "name:\n- a\n- b\nposition:\n- 0.5\n- 1.0\nvelocity: []\n" in best_effort[0]
    assert latched == ("data: 'kept: äöü'\n---\n", "", 0)
    # Not where the messages go: they may be read by a program.
    assert mixed == (
        "",
        "WARNING: /mixed is published reliably and best effort: messages may get lost\n",
        0,
    )


def test_echo_writes_a_message_in_many_ways(robot):
    # Like Jazzy's, CSV has no comma for the empty `layout.dim` at the beginning.
    cases = {
        ("/data", "--csv"): "0,1.0,2.5,3.0,4.0\n",
        ("/data", "--csv", "-l", "2"): "0,1.0,2.5,...\n",
        ("/data", "--field", "data"): "array('d', [1.0, 2.5, 3.0, 4.0])\n---\n",
        ("/data", "--flow-style", "-l", "1"): (
            "layout:\n  dim: []\n  data_offset: 0\ndata: [1.0, '...']\n---\n"
        ),
        ("/data", "--no-arr"): (
            "layout:\n  dim: '<sequence type: std_msgs/msg/MultiArrayDimension, length: 0>'\n"
            "  data_offset: 0\ndata: '<sequence type: double, length: 4>'\n---\n"
        ),
        ("/joints", "--field", "header.frame_id"): "base\n---\n",
        ("/joints", "--field", "header", "--no-str"): (
            "stamp:\n  sec: 0\n  nanosec: 0\nframe_id: '<string length: <4>>'\n---\n"
        ),
        ("/latched", "--raw"): (
            r"b'\x00\x01\x00\x00\r\x00\x00\x00kept: \xc3\xa4\xc3\xb6\xc3\xbc\x00\x00\x00\x00'"
            "\n---\n"
        ),
        ("/latched", "--filter", "'kept' in m.data"): "data: 'kept: äöü'\n---\n",
        ("/data", "--filter", "not m.data", "--timeout", "0.1"): "",
    }
    results = topic_all(*(("echo", "--once", *words) for words in cases))
    for (words, expected), result in zip(cases.items(), results, strict=True):
        assert result == (expected, "", 0), words


def test_echo_of_what_is_not_there(robot):
    unpublished, no_type, no_name, no_field, no_filter, failing_filter = topic_all(
        ("echo", "/nothing"),
        ("echo", "/nothing", "std_msgs/msg/Nothing"),
        ("echo", "no name"),
        ("echo", "/data", "--field", "layout.x"),
        ("echo", "/data", "--filter", "m."),
        ("echo", "/data", "--filter", "m.x > 1"),
    )
    assert unpublished == (
        "WARNING: topic [/nothing] does not appear to be published yet\n",
        "Nobody uses '/nothing', which would tell its type\n",
        1,
    )
    assert no_type == failure("Unknown message type 'std_msgs/msg/Nothing'")
    assert "topic name must not contain characters other than alphanumerics" in no_name[1]
    assert no_name[1].count("\n") == no_name[2] == 1
    assert no_field == failure("--field 'layout.x': MultiArrayLayout has no 'x'")
    assert no_filter[1].startswith("--filter 'm.' is no Python expression: invalid syntax")
    assert no_filter[1].count("\n") == no_filter[2] == 1
    assert failing_filter == failure(
        "--filter 'm.x > 1' fails: 'Float64MultiArray' object has no attribute 'x'"
    )


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_echo(robot, number):
    with start("echo", "/data") as process:
        assert process.stdout.readline() == "layout:\n"
        process.send_signal(number)
        _, errors = process.communicate(timeout=TIMEOUT_S)
    assert (errors, process.returncode) == ("", number)


def test_rate(robot):
    with start("hz", "-w", "20", "/data") as process:
        lines = [process.stdout.readline() for _ in range(2)]
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=TIMEOUT_S)
    rate = re.fullmatch(r"average rate: (\d+\.\d{3})\n", lines[0])
    assert 5 < float(rate[1]) < 200  # 50 Hz, on a busy machine less
    assert re.fullmatch(
        r"\tmin: \d\.\d{3}s max: \d\.\d{3}s std dev: \d\.\d{5}s window: 20\n", lines[1]
    )
    assert (errors, process.returncode) == ("", signal.SIGINT)


def test_rate_of_nothing():
    with start("hz", "/nothing") as process:
        line = process.stdout.readline()
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=TIMEOUT_S)
    assert line == "WARNING: topic [/nothing] does not appear to be published yet\n"


def test_publishing(robot):
    once, often, stamped, nobody = topic_all(
        ("pub", "--once", "/words", "std_msgs/msg/String", "{data: hello}"),
        ("pub", "-t", "3", "-r", "50", "-p", "2", "/words", "std_msgs/String", "data: 7"),
        (
            *("pub", "-1", "-w", "0", "/j", "sensor_msgs/msg/JointState"),
            "{header: auto, name: [a], position: [1, 2.5]}",
        ),
        ("pub", "-1", "--max-wait-time-secs", "0.1", "/nobody", "std_msgs/msg/Empty"),
    )
    message = "publishing #{}: std_msgs.msg.String(data={!r})\n\n"
    assert once[0].endswith("publisher: beginning loop\n" + message.format(1, "hello"))
    assert often[0].endswith("publisher: beginning loop\n" + message.format(2, "7"))
    assert sorted(robot.heard) == ["7", "7", "7", "hello"]
    assert re.search(r"stamp=builtin_interfaces\.msg\.Time\(sec=[1-9]", stamped[0])
    assert "name=['a'], position=[1.0, 2.5]" in stamped[0]
    assert nobody == (
        "Waiting for at least 1 matching subscription(s)...\n",
        "Only 0 of 1 subscriptions came in 0.1 s\n",
        1,
    )


def test_publishing_what_is_no_message():
    message = ("std_msgs/msg/String", "{x: 1}")
    cases = {
        ("/w", "std_msgs/msg/Sting"): (
            "Unknown message type 'std_msgs/msg/Sting'; did you mean 'std_msgs/msg/String'?"
        ),
        ("/w", "std_srvs/srv/Empty"): "'std_srvs/srv/Empty' is a service, not a message",
        ("/w", *message): "String has no field 'x', but data",
        ("/w", "std_msgs/msg/Float64", "{data: x}"): (
            "Float64.data is double and cannot be 'x': could not convert string to float: 'x'"
        ),
        ("/w", "std_msgs/msg/Bool", "{data: 'no'}"): (
            "Bool.data is boolean and cannot be 'no': true or false is needed"
        ),
        ("/w", "std_msgs/msg/Header", "{stamp: {sec: 1.5}}"): (
            "Time.sec is int32 and cannot be 1.5: an integer is needed"
        ),
        ("/w", "std_msgs/msg/Header", "{stamp: 1}"): "Time needs '{field: value}', not 1",
        ("/w", "std_msgs/msg/Float64MultiArray", "{data: '12'}"): (
            "Float64MultiArray.data is sequence<double> and cannot be '12': a list is needed"
        ),
        # What a field cannot hold, whoever finds out.
        ("/w", "std_msgs/msg/UInt8", "{data: 300}"): "",
        ("/w", "std_msgs/msg/String", "data"): ("'data' names no fields: write '{field: value}'"),
        ("/w", "std_msgs/msg/String", "{data: ["): "'{data: [' is not valid YAML: ",
        ("/w", "std_msgs/msg/Empty", "-w", "0", "-n", "a b"): "Invalid node name: ",
        ("/w", "std_msgs/msg/Empty", "-w", "0", "--max-wait-time-secs", "1"): (
            "--max-wait-time-secs: nothing is waited for"
        ),
    }
    results = topic_all(*(("pub", "-1", *words) for words in cases))
    for (words, complaint), (out, errors, code) in zip(cases.items(), results, strict=True):
        assert (out, errors.count("\n"), code) == ("", 1, 1), (words, errors)
        assert errors.startswith(complaint), words
