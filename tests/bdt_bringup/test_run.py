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
from rosbags.highlevel import AnyReader
from running_loops import DEADLINE, alive, bdt, children, finished, wait_for, wait_for_the_loop

from bdt_bags.recovery.recover_bag import recover_bag
from bdt_msgs_py.reading import read_position, read_samples, read_voltage
from bdt_msgs_py.topics import GAP_JOINT, TELEMETRY_COLUMNS

CONFIG = Path(__file__).parents[2] / "config"
VICTIMS = ("plant", "controller", "twin", "recorder")


def run(*arguments):
    return finished(bdt("run", "--config", CONFIG / "paper.yaml", *arguments))


def endless(output, *arguments, domain=None):
    """Start a loop that ends with a signal only, and wait until it runs."""
    process = bdt("run", "--duration", "1000", "--output", output, *arguments, domain=domain)
    wait_for_the_loop(process, output)
    return process


def contents(bag, namespace=""):
    """Return what determinism is about: telemetry, commands, estimates.

    A plant that gets no answer in time asks again, and is answered again: how often that happens
    is a matter of the computer, what the answer says is not. Each is taken once.
    """
    telemetry, commands, estimates = [], [], []
    with AnyReader([bag]) as reader:
        for connection, _, raw in reader.messages():
            message = reader.deserialize(raw, connection.msgtype)
            if connection.topic == f"{namespace}/telemetry":
                telemetry.append(read_samples(message, TELEMETRY_COLUMNS))
            elif connection.topic == f"{namespace}/command":
                commands.append(read_voltage(message))
            elif connection.topic == f"{namespace}/backlash_estimate":
                estimates.append(read_position(message, GAP_JOINT))
    return np.concatenate(telemetry), sorted(set(commands)), estimates


@pytest.fixture(scope="module")
def three_runs(tmp_path_factory, claim_domain):
    """Return folder and summary of three runs at the same time, each in a domain of its own.

    The plant of the last one asks again after 2 ms, as one does on a busy computer.
    """
    folder = tmp_path_factory.mktemp("runs")
    paper = CONFIG / "paper.yaml"
    hasty = folder / "hasty.yaml"
    plant = "  ros__parameters:\n    duration:"
    text = paper.read_text(encoding="utf-8")
    assert plant in text
    hasty.write_text(
        text.replace(plant, "  ros__parameters:\n    resend_period: 0.002\n    duration:")
    )
    runs = {
        "separate": ("separate", paper),
        "single": ("single", paper),
        "again": ("separate", hasty),
    }
    arguments = ("run", "--duration", "8", "--json")
    started = {
        folder / name: bdt(
            *arguments,
            *("--processes", processes, "--config", config, "--output", folder / name),
            domain=claim_domain(),
        )
        for name, (processes, config) in runs.items()
    }
    summaries = []
    for output, process in started.items():
        code, out, err = finished(process)
        assert code == 0, err
        summaries.append((output, json.loads(out)))
    return summaries


@pytest.fixture
def eight_seconds(three_runs):
    """Return folder and summary of the first of the runs, in separate processes."""
    return three_runs[0]


def test_a_run_leaves_a_bag_logs_a_report_and_a_summary(eight_seconds):
    output, summary = eight_seconds
    assert (output / "bag" / "metadata.yaml").is_file()
    assert (output / "report.html").stat().st_size > 10_000
    assert json.loads((output / "summary.json").read_text()) == summary
    assert {log.stem for log in (output / "log").iterdir()} == {
        "plant",
        "controller",
        "twin",
        "recorder",
    }


def test_nothing_of_a_run_is_lost(eight_seconds):
    _, summary = eight_seconds
    assert summary["lost_messages"] == 0
    for topic in ("measurement", "command"):
        stream = summary["timing"][topic]
        assert stream["messages"] - stream["repeated"] == 4000
    assert summary["messages"]["/telemetry"] == 80
    assert summary["duration_s"] == pytest.approx(8.0, abs=1e-3)


def test_the_twin_reconfigures_the_controller_during_a_run(eight_seconds):
    _, summary = eight_seconds
    assert summary["reconfigurations"] > 10
    assert summary["dead_zone_final_m"] > 0.0
    assert not any(step["limit_cycle"] for step in summary["steps"])


def test_one_process_or_many_and_one_run_or_the_next_give_the_same_bytes(three_runs):
    expected, *others = (contents(output / "bag") for output, _ in three_runs)
    assert len(expected[1]) == 4000
    for telemetry, commands, estimates in others:
        np.testing.assert_array_equal(telemetry, expected[0])
        assert commands == expected[1]
        assert estimates == expected[2]
    _, hasty = three_runs[-1]
    assert hasty["timing"]["measurement"]["repeated"] > 0, "otherwise this compares less"


def test_loops_in_namespaces_run_side_by_side_and_give_the_same_bytes(
    three_runs, tmp_path, claim_domain
):
    long_telemetry, long_commands, long_estimates = contents(three_runs[0][0] / "bag")
    domain = claim_domain()
    arguments = ("run", "--config", "paper", "--duration", "5", "--json")
    loops = {"left": "separate", "laboratory/right": "single"}
    started = {
        name: bdt(
            *(*arguments, "--processes", processes),
            *("--output", tmp_path / name, "--namespace", name),
            domain=domain,
        )
        for name, processes in loops.items()
    }
    for name, process in started.items():
        code, out, err = finished(process)
        assert code == 0, err
        assert json.loads(out)["reconfigurations"] > 0
        telemetry, commands, estimates = contents(tmp_path / name / "bag", f"/{name}")
        assert (len(telemetry), len(commands)) == (25000, 2500)
        np.testing.assert_array_equal(telemetry, long_telemetry[:25000])
        assert commands == long_commands[:2500]
        assert estimates == long_estimates[: len(estimates)]
        assert estimates


@pytest.mark.real_time
def test_real_time_takes_as_long_as_the_simulated_time(tmp_path):
    begin = time.monotonic()
    code, out, err = run(
        "--duration", "2", "--mode", "realtime", "--output", tmp_path / "run", "--json"
    )
    assert code == 0, err
    assert time.monotonic() - begin > 2.0
    # In lockstep it is above 3; a busy machine is late with the first or the last message.
    assert 0.3 < json.loads(out)["real_time_factor"] < 2.0


def test_without_a_bag_there_is_no_report(tmp_path):
    # Of a run that is over in a moment nobody may have seen more than the end.
    code, out, err = run("--duration", "10", "--output", tmp_path / "run", "--no-bag", "--json")
    assert code == 0, err
    pace = json.loads(out)
    assert pace["duration"] == 10.0
    assert pace["real_time_factor"] > 0
    assert not (tmp_path / "run" / "bag").exists()
    assert not (tmp_path / "run" / "report.html").exists()


@pytest.fixture(scope="module")
def bereaved(tmp_path_factory, claim_domain):
    """Return runs of which one node was killed: process and nodes by victim.

    Each ends while the next one starts, because DDS gives the dead a few seconds to answer.
    """
    folder = tmp_path_factory.mktemp("bereaved")
    runs = {}
    for victim in VICTIMS:
        process = endless(folder / victim, domain=claim_domain())
        nodes = children(process.pid)
        os.kill(nodes[victim], signal.SIGKILL)
        runs[victim] = process, nodes
    return runs


@pytest.mark.parametrize("victim", VICTIMS)
def test_a_node_that_is_killed_ends_the_run_with_its_name_and_leaves_no_process(bereaved, victim):
    process, nodes = bereaved[victim]
    assert set(nodes) == set(VICTIMS)
    code, _, err = finished(process)
    assert code == 1
    assert f"error: node {victim}: killed by SIGKILL" in err
    assert "Traceback" not in err
    assert not any(alive(pid) for pid in nodes.values())


@pytest.mark.parametrize("processes", ["separate", "single"])
def test_ctrl_c_stops_everything_and_keeps_the_bag(tmp_path, processes):
    output = tmp_path / "run"
    process = endless(output, "--processes", processes)
    nodes = children(process.pid)
    assert len(nodes) == (4 if processes == "separate" else 0)
    process.send_signal(signal.SIGINT)
    code, _, err = finished(process)
    assert code == 130
    assert f"interrupted; what was recorded is in {output / 'bag'}" in err
    assert "Traceback" not in err
    assert not any(alive(pid) for pid in nodes.values())
    assert len(contents(output / "bag")[0]) > 0


def test_a_second_loop_in_the_same_domain_is_refused_and_nodes_do_not_outlive_a_killed_run(
    tmp_path, claim_domain
):
    domain = claim_domain()
    first = endless(tmp_path / "first", domain=domain)
    second = bdt("run", "--duration", "1", "--output", tmp_path / "second", domain=domain)
    code, _, err = finished(second)
    assert code == 2
    assert "error: /plant already runs in this ROS domain" in err
    # A plant that is started by hand in a namespace shares the clock until it is told not to.
    plant = subprocess.run(
        [sys.executable, "-m", "bdt_plant.plant_node", "--ros-args", "-r", "__ns:=/right"],
        check=False,
        capture_output=True,
        text=True,
        timeout=DEADLINE,
        env=os.environ | {"ROS_DOMAIN_ID": str(domain)},
    )
    assert plant.returncode == 2
    assert plant.stderr.startswith("error: /right/plant: /clock is published by /plant, too: ")
    assert plant.stderr.count("\n") == 1
    assert first.poll() is None
    nodes = children(first.pid)
    assert set(nodes) == set(VICTIMS)
    first.kill()
    first.communicate(timeout=DEADLINE)
    wait_for(lambda: not any(alive(pid) for pid in nodes.values()), "the nodes are gone")


def test_bad_input_is_one_line_and_exit_code_two():
    cases = {
        ("run", "--config", "no_such.yaml"): "configuration no_such.yaml: cannot be read",
        ("run", "--duration", "0"): "--duration 0.0 s: must be above 0",
        ("run", "--duration", "soon"): "invalid float value: 'soon'",
        ("run", "--namespace", "a b"): "--namespace a b: ",
        ("record", "--namespace", "a b"): "--namespace a b: ",
        ("run", "--mode", "warp"): "invalid choice: 'warp'",
        ("analyze", "no_such_bag"): "no_such_bag",
        ("fly",): "invalid choice: 'fly'",
        (): "required: COMMAND",
    }
    started = [bdt(*arguments) for arguments in cases]
    for says, process in zip(cases.values(), started, strict=True):
        code, _, err = finished(process)
        assert says in err
        assert code == 2, err
        assert "Traceback" not in err


def test_a_domain_id_that_is_not_one_is_bad_input(tmp_path, monkeypatch):
    monkeypatch.setenv("ROS_DOMAIN_ID", "many")
    code, _, err = run("--duration", "1", "--output", tmp_path / "run")
    assert code == 2
    assert "Traceback" not in err


def test_a_full_disk_ends_the_recording_and_not_the_loop(tmp_path):
    # More than half of what the recorder has to write; it writes when it has a megabyte.
    space = 1_600_000
    command = ["run", "--config", CONFIG / "paper.yaml", "--duration", "10", "--output", tmp_path]
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
    assert "t =   10.0 s" in err
    *_, last = err.splitlines()
    assert last.startswith("error: node recorder: exit code 1: ")
    assert f"{bag} has no end: " in last
    assert last.endswith("`bdt recover` makes a whole one of it")
    said = (tmp_path / "log" / "recorder.log").read_text(encoding="utf-8").splitlines()
    assert "File too large: what is recorded so far is kept" in said[0]
    assert any("messages recorded" in line for line in said)
    assert recover_bag(bag).messages["/measurement"] > 100
