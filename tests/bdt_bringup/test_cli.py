"""The command ``bdt``: what needs no ROS works where there is none."""

import subprocess
import sys
from importlib.util import find_spec

import pytest

from bdt_bringup.cli import run_command
from bdt_msgs_py.exit_codes import BAD_INPUT
from bdt_msgs_py.topics import REFERENCE

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


def test_the_gap_of_a_bag_is_estimated_again(tmp_path, following_bag):
    options = ["--estimator", "inverse_filter", "--set", "estimator.window=1.0"]
    done = run_without_ros("analyze", following_bag, "--output", tmp_path, *options)
    assert done.returncode == 0, done.stderr
    (line,) = [x for x in done.stdout.splitlines() if x.startswith("re-estimated (inverse_filter)")]
    assert "; live: " in line
    assert "  set estimator.window = 1.0" in done.stdout


def test_loop_and_topics_of_a_bag_can_be_chosen(small_loop, tmp_path, capsys):
    both = small_loop.without()
    for name, *message in small_loop.without(REFERENCE).items:
        both.items.append((f"/a{name}", *message))
        if name == "/telemetry":
            both.items.append(("/b/samples", *message))
    bag, out = str(both.write(tmp_path / "bag")), str(tmp_path / "out")
    assert run_command(["analyze", bag, "--output", out]) == BAD_INPUT
    assert "holds 2 loops, in the namespaces / and /a: choose one" in capsys.readouterr().err
    assert run_command(["analyze", bag, "--output", out, "--namespace", "a"]) == 0
    assert "note: no reference: no step is judged" in capsys.readouterr().out
    chosen = ["--namespace", "a", "--topic", "telemetry:=/b/samples"]
    assert run_command(["analyze", bag, "--output", out, *chosen]) == 0
    assert run_command(["analyze", bag, "--topic", "telemetry"]) == BAD_INPUT
    assert capsys.readouterr().err.startswith("error: topic 'telemetry': must be TOPIC=NAME")


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
