"""The command ``bdt``: its help is light, and what needs no ROS works where there is none."""

import os
import signal
import subprocess
import sys
from importlib.util import find_spec

import pytest

from bdt_bringup.cli import main, run_command
from bdt_msgs_py.command_errors import BAD_INPUT
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


HEAVY = {"numpy", "scipy", "numba", "matplotlib", "rclpy", "rosbags", "yaml", "rich", "control"}

IMPORTS_OF_HELP = """
import sys
from bdt_bringup.cli import run_command
try:
    run_command(sys.argv[1:])
finally:
    print("imported:", *{name.partition(".")[0] for name in sys.modules}, file=sys.stderr)
"""


@pytest.mark.parametrize("arguments", [["--help"], ["run", "--help"], ["record", "--help"]])
def test_help_imports_nothing_that_computes_or_talks(arguments):
    done = subprocess.run(
        [sys.executable, "-c", IMPORTS_OF_HELP, *arguments],
        check=True,
        capture_output=True,
        text=True,
    )
    assert "usage: bdt" in done.stdout
    imported = done.stderr.split()
    assert "bdt_bringup" in imported
    assert HEAVY.isdisjoint(imported)


@pytest.mark.parametrize(("before", "then"), [(None, "1"), ("4", "4")])
def test_linear_algebra_gets_one_thread_unless_somebody_wants_more(monkeypatch, before, then):
    monkeypatch.setattr(os, "environ", {} if before is None else {"OPENBLAS_NUM_THREADS": before})
    with pytest.raises(SystemExit):
        main(["--help"])
    assert os.environ == {"OPENBLAS_NUM_THREADS": then}


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
        "sys.exit(run_command(sys.argv[1:]))", "import bdt_study.reproduction.reproduce"
    )
    done = subprocess.run([sys.executable, "-c", program], check=False, capture_output=True)
    assert done.returncode == 0, done.stderr


def with_closed_pipe(*arguments, buffered=True, error_output=subprocess.PIPE):
    """Run a command that writes into a pipe of which nobody reads; return it when it has ended."""
    read, write = os.pipe()
    os.close(read)
    try:
        command = [sys.executable, "-m", "bdt_bringup.cli", *map(str, arguments)]
        outputs = {"stdout": write, "stderr": write if error_output is None else error_output}
        # Without a buffer every print meets the pipe, with one only the flush at the end.
        unbuffered = {"PYTHONUNBUFFERED": "" if buffered else "1"}
        return subprocess.run(
            command, check=False, timeout=120, text=True, env=os.environ | unbuffered, **outputs
        )
    finally:
        os.close(write)


QUIET = 128 + signal.SIGPIPE


@pytest.mark.parametrize(
    ("buffered", "arguments"),
    [
        (True, ["bench", "control_step"]),
        (False, ["bench", "control_step"]),
        (True, ["analyze", "BAG", "--output", "OUTPUT", "--json"]),
        (False, ["analyze", "BAG", "--output", "OUTPUT"]),
        (True, ["compare", "BAG", "BAG", "--output", "OUTPUT"]),
        (False, ["recover", "BAG", "--output", "OUTPUT"]),
    ],
)
def test_a_command_whose_reader_is_gone_ends_quietly_as_any_other_tool(
    small_loop, tmp_path, arguments, buffered
):
    """``bdt ... | head``."""
    if "bench" in arguments and find_spec("control") is None:
        pytest.skip("needs python-control")
    bag = small_loop.write(tmp_path / "bag") if "BAG" in arguments else None
    places = {"BAG": bag, "OUTPUT": tmp_path / "output"}
    words = [places.get(word, word) for word in arguments]
    done = with_closed_pipe(*words, buffered=buffered)
    assert (done.stderr, done.returncode) == ("", QUIET)


@pytest.mark.parametrize("buffered", [True, False])
def test_help_and_errors_that_nobody_reads_end_quietly(buffered):
    """The parser of the command line leaves errors of printing aside, and ends as it would."""
    done = with_closed_pipe("bench", "--help", buffered=buffered)
    assert (done.stderr, done.returncode) in [("", QUIET), ("", 0)]
    done = with_closed_pipe("analyze", "no_such_bag", buffered=buffered, error_output=None)
    assert done.returncode in (BAD_INPUT, QUIET)


def test_a_pipe_that_is_read_to_its_end_changes_nothing():
    done = subprocess.run(
        [sys.executable, "-m", "bdt_bringup.cli", "--help"], check=False, capture_output=True
    )
    assert done.returncode == 0
    assert done.stdout
