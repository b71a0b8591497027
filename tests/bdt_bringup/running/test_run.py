"""`bdt run` with real processes: it ends cleanly, whatever ends first."""

import json
import os
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from rclpy.node import Node
from rosbags.highlevel import AnyReader
from rosgraph_msgs.msg import Clock

from bdt_bringup.recovery.recover_bag import recover_bag
from bdt_msgs_py.qos import qos_profile
from bdt_msgs_py.reading import read_position, read_samples, read_voltage
from bdt_msgs_py.topics import CLOCK, GAP_JOINT, TELEMETRY_COLUMNS

CONFIG = Path(__file__).parents[3] / "config"
DEADLINE = 60.0


def bdt(*arguments):
    return subprocess.Popen(
        [sys.executable, "-m", "bdt_bringup.cli", *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def finished(process):
    out, err = process.communicate(timeout=DEADLINE)
    return process.returncode, out, err


def run(*arguments):
    return finished(bdt("run", "--config", CONFIG / "paper.yaml", *arguments))


def wait_for(condition, what):
    end = time.monotonic() + DEADLINE
    while not (result := condition()):
        assert time.monotonic() < end, what
        time.sleep(0.02)
    return result


def children(pid):
    """Return the nodes that `bdt run` started: name and process identifier."""
    nodes = {}
    for entry in Path("/proc").iterdir():
        if not entry.name.isdigit():
            continue
        try:
            parent = int((entry / "stat").read_text().rsplit(")", 1)[1].split()[1])
            words = (entry / "cmdline").read_text().split("\0")
        except (FileNotFoundError, ProcessLookupError):
            continue
        if parent == pid and "bdt_bringup.running.guarded_node" in words:
            nodes[words[4].rsplit(".", 1)[1].removesuffix("_node")] = int(entry.name)
    return nodes


def wait_for_the_loop(ros):
    """Wait until simulated time runs, in the domain of this test process."""
    listener = ros.create(Node, "listener")
    times = []
    listener.create_subscription(
        Clock, CLOCK.name, lambda message: times.append(message.clock.sec), qos_profile(CLOCK)
    )
    ros.spin_until(lambda: times and times[-1] >= 1, DEADLINE)


def alive(pid):
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


def contents(bag):
    """Return what determinism is about: telemetry, commands, estimates."""
    telemetry, commands, estimates = [], [], []
    with AnyReader([bag]) as reader:
        for connection, _, raw in reader.messages():
            message = reader.deserialize(raw, connection.msgtype)
            if connection.topic == "/telemetry":
                telemetry.append(read_samples(message, TELEMETRY_COLUMNS))
            elif connection.topic == "/command":
                commands.append(read_voltage(message))
            elif connection.topic == "/backlash_estimate":
                estimates.append(read_position(message, GAP_JOINT))
    return np.concatenate(telemetry), commands, estimates


@pytest.fixture(scope="module")
def twelve_seconds(tmp_path_factory):
    """One run in separate processes, for all tests that look at its result."""
    output = tmp_path_factory.mktemp("run") / "separate"
    code, out, err = run("--duration", "12", "--output", output, "--json")
    assert code == 0, err
    return output, json.loads(out)


def test_a_run_leaves_a_bag_logs_a_report_and_a_summary(twelve_seconds):
    output, summary = twelve_seconds
    assert (output / "bag" / "metadata.yaml").is_file()
    assert (output / "report.html").stat().st_size > 10_000
    assert json.loads((output / "summary.json").read_text()) == summary
    assert {log.stem for log in (output / "log").iterdir()} == {
        "plant",
        "controller",
        "twin",
        "recorder",
    }


def test_nothing_of_a_run_is_lost(twelve_seconds):
    _, summary = twelve_seconds
    assert summary["lost_messages"] == 0
    assert summary["messages"]["/measurement"] == summary["messages"]["/command"] == 6000
    assert summary["messages"]["/telemetry"] == 120
    assert summary["duration_s"] == pytest.approx(12.0, abs=1e-3)


def test_the_twin_reconfigures_the_controller_during_a_run(twelve_seconds):
    _, summary = twelve_seconds
    assert summary["reconfigurations"] > 10
    assert summary["dead_zone_final_m"] > 0.0
    assert not any(step["limit_cycle"] for step in summary["steps"])


def test_one_process_or_many_and_one_run_or_the_next_give_the_same_bytes(twelve_seconds, tmp_path):
    output, _ = twelve_seconds
    expected = contents(output / "bag")
    for processes in ("single", "separate"):
        again = tmp_path / processes
        code, _, err = run("--duration", "12", "--output", again, "--processes", processes)
        assert code == 0, err
        telemetry, commands, estimates = contents(again / "bag")
        np.testing.assert_array_equal(telemetry, expected[0])
        assert commands == expected[1]
        assert estimates == expected[2]


def test_real_time_takes_as_long_as_the_simulated_time(tmp_path):
    begin = time.monotonic()
    code, out, err = run(
        "--duration", "3", "--mode", "realtime", "--output", tmp_path / "run", "--json"
    )
    assert code == 0, err
    assert time.monotonic() - begin > 3.0
    # In lockstep it is above 3; a busy machine is late with the first or the last message.
    assert 0.3 < json.loads(out)["real_time_factor"] < 2.0


def test_without_a_bag_there_is_no_report(tmp_path):
    code, out, err = run("--duration", "1", "--output", tmp_path / "run", "--no-bag", "--json")
    assert code == 0, err
    pace = json.loads(out)
    assert pace["duration"] == 1.0
    assert pace["real_time_factor"] > 0
    assert not (tmp_path / "run" / "bag").exists()
    assert not (tmp_path / "run" / "report.html").exists()


@pytest.mark.parametrize("victim", ["plant", "controller", "twin", "recorder"])
def test_a_node_that_is_killed_ends_the_run_with_its_name_and_leaves_no_process(
    ros, tmp_path, victim
):
    process = bdt(
        "run", "--config", CONFIG / "paper.yaml", "--duration", "1000", "--output", tmp_path / "r"
    )
    nodes = wait_for(lambda: (n := children(process.pid)) and len(n) == 4 and n, "four nodes")
    wait_for_the_loop(ros)
    os.kill(nodes[victim], signal.SIGKILL)
    code, _, err = finished(process)
    assert code == 1
    assert f"error: node {victim}: killed by SIGKILL" in err
    assert "Traceback" not in err
    assert not any(alive(pid) for pid in nodes.values())


@pytest.mark.parametrize("processes", ["separate", "single"])
def test_ctrl_c_stops_everything_and_keeps_the_bag(ros, tmp_path, processes):
    output = tmp_path / "run"
    process = bdt("run", "--duration", "1000", "--output", output, "--processes", processes)
    wait_for_the_loop(ros)
    nodes = children(process.pid)
    process.send_signal(signal.SIGINT)
    code, _, err = finished(process)
    assert code == 130
    assert f"interrupted; what was recorded is in {output / 'bag'}" in err
    assert "Traceback" not in err
    assert not any(alive(pid) for pid in nodes.values())
    assert len(contents(output / "bag")[0]) > 0


def test_nodes_do_not_outlive_a_run_that_is_killed(ros, tmp_path):
    process = bdt("run", "--duration", "1000", "--output", tmp_path / "run")
    nodes = wait_for(lambda: (n := children(process.pid)) and len(n) == 4 and n, "four nodes")
    wait_for_the_loop(ros)
    process.kill()
    process.communicate(timeout=DEADLINE)
    wait_for(lambda: not any(alive(pid) for pid in nodes.values()), "the nodes are gone")


def test_a_second_loop_in_the_same_domain_is_refused(ros, tmp_path):
    first = bdt("run", "--duration", "1000", "--output", tmp_path / "first")
    wait_for_the_loop(ros)
    code, _, err = run("--duration", "1", "--output", tmp_path / "second")
    first.send_signal(signal.SIGINT)
    finished(first)
    assert code == 2
    assert "error: a plant already runs in this ROS domain" in err


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["run", "--config", "no_such.yaml"], "configuration no_such.yaml: cannot be read"),
        (["run", "--duration", "0"], "--duration 0.0 s: must be above 0"),
        (["run", "--duration", "soon"], "invalid float value: 'soon'"),
        (["run", "--mode", "warp"], "invalid choice: 'warp'"),
        (["analyze", "no_such_bag"], "no_such_bag"),
        (["fly"], "invalid choice: 'fly'"),
        ([], "required: COMMAND"),
    ],
)
def test_bad_input_is_one_line_and_exit_code_two(arguments, says):
    code, _, err = finished(bdt(*arguments))
    assert code == 2
    assert says in err
    assert "Traceback" not in err


def test_a_domain_id_that_is_not_one_is_bad_input(tmp_path, monkeypatch):
    monkeypatch.setenv("ROS_DOMAIN_ID", "many")
    code, _, err = run("--duration", "1", "--output", tmp_path / "run")
    assert code == 2
    assert "Traceback" not in err


def test_a_full_disk_ends_the_recording_and_not_the_loop(tmp_path):
    # Half of what the recorder has to write.
    space = 400_000
    command = ["run", "--config", CONFIG / "paper.yaml", "--duration", "3", "--output", tmp_path]
    process = subprocess.Popen(
        [sys.executable, "-m", "bdt_bringup.cli", *map(str, command)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (space, space)),  # noqa: PLW1509
    )
    code, _, err = finished(process)
    assert code == 1
    bag = tmp_path / "bag"
    assert "t =    3.0 s" in err
    assert err.endswith(
        f"error: {bag} has no end, see {tmp_path / 'log'}: `bdt recover` makes a whole one of it\n"
    )
    said = (tmp_path / "log" / "recorder.log").read_text(encoding="utf-8").splitlines()
    assert "File too large: what is recorded so far is kept" in said[0]
    assert "messages recorded" in said[-1]
    assert recover_bag(bag).messages["/measurement"] > 100
