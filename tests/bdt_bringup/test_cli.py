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


@pytest.fixture(scope="module")
def without_ros(tmp_path_factory, following_bag):
    """Return a function that gives folder and output of a command, of all that run at once."""
    folder = tmp_path_factory.mktemp("without_ros")
    estimate = ["--estimator", "inverse_filter", "--set", "estimator.window=1.0"]
    commands = {
        "analyze": ["analyze", following_bag, "--output", folder / "analyze"],
        "estimate": ["analyze", following_bag, "--output", folder / "estimate", *estimate],
        "recover": ["recover", following_bag, "--output", folder / "recover"],
        "design": ["design", "--output", folder / "design.png"],
        "bench": ["bench", "control_step"],
    }
    started = {
        name: subprocess.Popen(
            [sys.executable, "-c", WITHOUT_ROS, *map(str, command)],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        for name, command in commands.items()
    }

    def output(name):
        out, err = started[name].communicate(timeout=120)
        assert started[name].returncode == 0, err
        return folder / name, out

    yield output
    for process in started.values():
        process.kill()
        process.communicate()


def test_a_bag_is_analyzed(without_ros):
    folder, _ = without_ros("analyze")
    assert (folder / "report.html").exists()


def test_the_gap_of_a_bag_is_estimated_again(without_ros):
    _, out = without_ros("estimate")
    (line,) = [x for x in out.splitlines() if x.startswith("re-estimated (inverse_filter)")]
    assert "; live: " in line
    assert "  set estimator.window = 1.0" in out


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


def test_a_bag_is_recovered(without_ros):
    folder, _ = without_ros("recover")
    assert (folder / "recover_0.mcap").exists()


@needs_control
def test_the_controller_is_designed(without_ros):
    folder, _ = without_ros("design")
    assert folder.with_suffix(".png").exists()


@needs_control
def test_the_cores_are_measured(without_ros):
    _, out = without_ros("bench")
    assert "control_step" in out


@needs_control
def test_the_paper_can_be_redone():
    program = WITHOUT_ROS.replace(
        "sys.exit(run_command(sys.argv[1:]))", "import bdt_bringup.reproduction.command"
    )
    done = subprocess.run([sys.executable, "-c", program], check=False, capture_output=True)
    assert done.returncode == 0, done.stderr
