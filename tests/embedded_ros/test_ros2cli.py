"""The ``ros2`` command; its output has the shape of Jazzy's."""

import os
import signal
import subprocess
import sys
import threading

import pytest
import yaml
from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from ros2cli.cli import main
from std_msgs.msg import Float64MultiArray, String
from std_srvs.srv import SetBool


@pytest.fixture
def robot(ros):
    """Yield a node that another thread spins while commands ask for it."""
    node = ros.create(Node, "robot")
    limits = FloatingPointRange(from_value=0.0, to_value=10.0)
    node.declare_parameter(
        "gain", 1.5, ParameterDescriptor(description="how much", floating_point_range=[limits])
    )
    node.declare_parameter("group.names", ["a", "b"])
    publisher = node.create_publisher(Float64MultiArray, "data", 10)
    node.create_timer(0.02, lambda: publisher.publish(Float64MultiArray(data=[1.0, 2.5])))
    node.heard = []
    node.create_subscription(String, "words", lambda msg: node.heard.append(msg.data), 10)

    def flip(request, response):
        response.success = not request.data
        return response

    node.create_service(SetBool, "flip", flip)

    def spin():
        try:
            ros.executor.spin()
        except ExternalShutdownException:
            return

    spinner = threading.Thread(target=spin)
    spinner.start()
    yield node
    ros.executor.shutdown()
    spinner.join(5)


@pytest.fixture
def ros2(capsys):
    """Run a command; its output, and its errors and exit code."""

    def run(*words):
        code = main(words)
        captured = capsys.readouterr()
        return captured.out, captured.err, code

    return run


def test_nodes(robot, ros2):
    assert ros2("node", "list") == ("/robot\n", "", 0)
    out = ros2("node", "info", "/robot")[0]
    assert "  Publishers:\n    /data: std_msgs/msg/Float64MultiArray\n" in out
    assert "    /flip: std_srvs/srv/SetBool\n" in out
    assert ros2("node", "info", "/nobody")[1:] == ("Unable to find node '/nobody'\n", 1)


def test_topics(robot, ros2):
    assert "/data [std_msgs/msg/Float64MultiArray]\n" in ros2("topic", "list", "-t")[0]
    out = ros2("topic", "info", "-v", "/data")[0]
    assert out.startswith("Type: std_msgs/msg/Float64MultiArray\n\nPublisher count: 1\n")
    assert "Node name: robot\n" in out
    assert ros2("topic", "info", "/nothing")[2] == 1


def test_echo(robot, ros2):
    assert ros2("topic", "echo", "--once", "/data")[0] == (
        "layout:\n  dim: []\n  data_offset: 0\ndata:\n- 1.0\n- 2.5\n---\n"
    )


def test_pub(robot, ros2):
    out, _, code = ros2("topic", "pub", "--once", "/words", "std_msgs/msg/String", "{data: hello}")
    assert code == 0
    assert "publishing #1: std_msgs.msg.String(data='hello')" in out
    for _ in range(100):
        if robot.heard:
            break
        threading.Event().wait(0.01)
    assert robot.heard == ["hello"]
    assert "no field" in ros2("topic", "pub", "-1", "/w", "std_msgs/msg/String", "{x: 1}")[1]
    assert "invalid" in ros2("topic", "pub", "-1", "/w", "std_msgs/msg/Nothing")[1]


def test_parameters(robot, ros2):
    assert ros2("param", "list", "/robot")[0] == (
        "  gain\n  group.names\n  start_type_description_service\n  use_sim_time\n"
    )
    assert ros2("param", "get", "/robot", "gain")[0] == "Double value is: 1.5\n"
    assert ros2("param", "get", "/robot", "group.names")[0] == "String values are: ['a', 'b']\n"
    assert ros2("param", "set", "/robot", "gain", "2.5")[0] == "Set parameter successful\n"
    assert ros2("param", "set", "/robot", "gain", "99.0") == (
        "",
        "Setting parameter failed: Parameter gain out of range Min: 0.0, Max: 10.0, value: 99.0\n",
        1,
    )
    assert ros2("param", "describe", "/robot", "gain")[0] == (
        "Parameter name: gain\n  Type: double\n  Description: how much\n  Constraints:\n"
        "    Min value: 0.0\n    Max value: 10.0\n"
    )


def test_parameters_are_dumped_and_loaded(robot, ros2, tmp_path):
    out = ros2("param", "dump", "/robot")[0]
    content = yaml.safe_load(out)["/robot"]["ros__parameters"]
    assert content["group"] == {"names": ["a", "b"]}
    path = tmp_path / "p.yaml"
    path.write_text("/robot: {ros__parameters: {gain: 7.5}}")
    assert ros2("param", "load", "/robot", str(path))[2] == 0
    assert robot.get_parameter("gain").value == 7.5


def test_services(robot, ros2):
    assert "/flip [std_srvs/srv/SetBool]\n" in ros2("service", "list", "-t")[0]
    out = ros2("service", "call", "/flip", "std_srvs/srv/SetBool", "{data: true}")[0]
    assert out.endswith("response:\nstd_srvs.srv.SetBool_Response(success=False, message='')\n\n")


def test_packages(ros2):
    assert "embedded_ros ros2\n" in ros2("pkg", "executables")[0]
    assert ros2("pkg", "executables", "embedded_ros")[0] == "embedded_ros ros2\n"
    assert ros2("run", "nothing", "at_all")[1:] == ("Package 'nothing' not found\n", 1)
    assert ros2("run", "embedded_ros", "nothing")[1:] == ("No executable found\n", 1)


def ros2_process(*words):
    return subprocess.Popen(
        [sys.executable, "-c", "from ros2cli.cli import main; raise SystemExit(main())", *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONUNBUFFERED": "1"},
    )


def test_run_passes_arguments_and_the_exit_code():
    with ros2_process("run", "embedded_ros", "ros2", "run", "nothing", "x") as process:
        assert process.communicate(timeout=20) == ("", "Package 'nothing' not found\n")
    assert process.returncode == 1


def test_ctrl_c_ends_echo(robot):
    with ros2_process("topic", "echo", "/data") as process:
        assert process.stdout.readline() == "layout:\n"
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=10)
    assert errors == ""
    assert process.returncode == 130
