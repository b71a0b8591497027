"""The command ``bdt``: what needs no ROS works where there is none."""

import subprocess
import sys
from importlib.util import find_spec

import pytest

needs_control = pytest.mark.skipif(find_spec("control") is None, reason="needs python-control")

WITHOUT_ROS = """
import sys

class Nowhere:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in ("rclpy", "rcl_interfaces", "std_msgs", "sensor_msgs"):
            raise ModuleNotFoundError(name)

sys.meta_path.insert(0, Nowhere())
from bdt_bringup.cli import run_command
sys.exit(run_command(sys.argv[1:]))
"""


def run_without_ros(*arguments):
    return subprocess.run(
        [sys.executable, "-c", WITHOUT_ROS, *map(str, arguments)],
        check=False,
        capture_output=True,
        text=True,
        timeout=120,
    )


def test_a_bag_is_analyzed(tmp_path, following_bag):
    done = run_without_ros("analyze", following_bag, "--output", tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "report.html").exists()


def test_a_bag_is_recovered(tmp_path, following_bag):
    done = run_without_ros("recover", following_bag, "--output", tmp_path / "whole")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "whole" / "whole_0.mcap").exists()


@needs_control
def test_the_controller_is_designed(tmp_path):
    done = run_without_ros("design", "--output", tmp_path / "design.png")
    assert done.returncode == 0, done.stderr


@needs_control
def test_the_cores_are_measured():
    done = run_without_ros("bench", "control_step")
    assert done.returncode == 0, done.stderr


@needs_control
def test_the_paper_can_be_redone():
    program = WITHOUT_ROS.replace(
        "sys.exit(run_command(sys.argv[1:]))", "import bdt_bringup.reproduction.command"
    )
    done = subprocess.run([sys.executable, "-c", program], check=False, capture_output=True)
    assert done.returncode == 0, done.stderr
