"""The sets of packages that a robot, the twin's computer and a desk install work as they are.

Each is installed into an empty environment. Without a ROS 2 that needs ``embedded_ros`` and what
*it* requires: Cyclone DDS, numpy, PyYAML, and rosbags with lz4, zstd, ruamel.yaml and apsw.
"""

import re

import pytest
from rclpy.node import Node
from rclpy.parameter_client import AsyncParameterClient
from sensor_msgs.msg import JointState
from separate_environment import SeparateEnvironment

from bdt_msgs_py.command_errors import BAD_INPUT
from bdt_msgs_py.qos import qos_profile
from bdt_msgs_py.reading import read_voltage
from bdt_msgs_py.topics import COMMAND, MEASUREMENT
from bdt_msgs_py.writing import platform_position
from checks.required_distributions import required_distributions

# A module of it: in a checkout the folder of that name counts as a package.
pytest.importorskip(
    "embedded_ros.session", reason="beside a ROS 2, rosdep chooses what is installed"
)

ROBOT = ("bdt_msgs_py", "bdt_controller", "bdt_driver", "bdt_serial_drive", "bdt_bringup")
TWIN = ("bdt_msgs_py", "bdt_plant", "bdt_controller", "bdt_twin")

NOT_FOR_A_ROBOT = ("control", "jinja2", "matplotlib", "mcap", "numba", "plotly", "rich", "scipy")
NOT_FOR_THE_TWIN = ("control", "jinja2", "matplotlib", "mcap", "plotly", "rich", "scipy")

IMPORT_ALL = """
import sys
from importlib import import_module
from pkgutil import walk_packages
for name in sys.argv[1:]:
    for module in walk_packages(import_module(name).__path__, f"{name}."):
        import_module(module.name)
"""

FIND = """
import sys
from importlib.util import find_spec
print(*(name for name in sys.argv[1:] if find_spec(name)))
"""


def environment(folder, names):
    # Cyclone DDS has a command line of its own, which is all that it needs rich for.
    return SeparateEnvironment(folder, [*names, "embedded_ros"], without={"rich-click"})


@pytest.fixture(scope="module")
def robot(tmp_path_factory):
    return environment(tmp_path_factory.mktemp("robot"), ROBOT)


@pytest.fixture(scope="module")
def twin(tmp_path_factory):
    return environment(tmp_path_factory.mktemp("twin"), TWIN)


def succeeded(done):
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize(
    ("packages", "others"),
    [
        (ROBOT, {"numpy", "pyserial", "pyyaml"}),
        (TWIN, {"numpy", "numba", "llvmlite", "pyyaml"}),
    ],
)
def test_a_set_requires_no_more_than_it_says(packages, others):
    ours = {name.replace("_", "-") for name in packages}
    assert set(required_distributions(packages)) == ours | others


def test_a_robot_has_nothing_that_simulates_or_draws(robot):
    assert succeeded(robot.run("python", "-c", FIND, *NOT_FOR_A_ROBOT)).split() == []


def test_the_twin_s_computer_has_nothing_that_draws(twin):
    assert succeeded(twin.run("python", "-c", FIND, *NOT_FOR_THE_TWIN)).split() == []


def test_every_module_of_a_set_can_be_imported(robot, twin):
    succeeded(robot.run("python", "-c", IMPORT_ALL, *ROBOT))
    succeeded(twin.run("python", "-c", IMPORT_ALL, *TWIN))


def test_a_robot_s_controller_answers_a_measurement(ros, robot):
    node = ros.create(Node, "bench")
    commands = []
    node.create_subscription(JointState, COMMAND.name, commands.append, qos_profile(COMMAND))
    measurement = node.create_publisher(JointState, MEASUREMENT.name, qos_profile(MEASUREMENT))
    with robot.running("controller_node") as controller:
        ros.spin_until(lambda: node.count_publishers(COMMAND.name) == 1)
        ros.spin_until(lambda: measurement.get_subscription_count() == 1)
        measurement.publish(platform_position(2_000_000, 0.0))
        ros.spin_until(lambda: commands)
        answer = robot.run("ros2", "param", "get", "/controller", "dead_zone_tolerance")
    stamp, voltage = read_voltage(commands[0])
    assert stamp == 2_000_000
    assert voltage != 0.0
    assert succeeded(answer) == "Double value is: 0.0\n"
    assert controller.returncode == 0


def test_the_twin_starts(ros, twin):
    node = ros.create(Node, "bench")
    client = AsyncParameterClient(node, "twin")
    with twin.running("twin_node") as process:
        ros.spin_until(client.services_are_ready)
        (controller,) = ros.result(client.get_parameters(["controller_node"])).values
    assert controller.string_value == "controller"
    assert process.returncode == 0


def test_a_robot_s_bdt_lists_what_is_there(robot):
    said = succeeded(robot.run("bdt", "--help"))
    # The name of a command is indented by four blanks, what wraps of its description by more.
    assert re.findall(r"^ {4}([\w-]+)", said, re.MULTILINE) == [
        "run",
        "status",
        "twins",
        "config",
        "hardware-check",
    ]


def test_a_robot_s_bdt_says_which_package_has_the_others(robot):
    done = robot.run("bdt", "analyze", "bag")
    assert done.returncode == BAD_INPUT
    assert done.stderr.endswith("analyze: is a command of the package bdt_analysis, install it\n")


def test_a_robot_s_bdt_run_says_what_a_whole_loop_needs(robot):
    done = robot.run("bdt", "run", "--config", "paper")
    assert done.returncode == BAD_INPUT
    assert done.stderr.startswith("error: ")
    assert "install it" in done.stderr
    assert done.stderr.count("\n") == 1


def test_with_the_bags_a_robot_can_record_and_recover(tmp_path):
    recording = environment(tmp_path / "recording", (*ROBOT, "bdt_bags"))
    succeeded(recording.run("python", "-c", IMPORT_ALL, "bdt_bags"))
    said = succeeded(recording.run("bdt", "--help"))
    assert "record" in said
    assert "recover" in said
    assert "analyze" not in said
