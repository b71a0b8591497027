"""A fleet as processes: machines that send telemetry, twins of which one fails or is killed."""

import os
import signal
import subprocess
import sys

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node
from running_loops import alive, children, wait_for
from std_msgs.msg import Float64MultiArray

from bdt_msgs_py.command_errors import BAD_INPUT
from bdt_msgs_py.qos import qos_profile
from bdt_msgs_py.topics import DIAGNOSTICS, TELEMETRY, TELEMETRY_COLUMNS
from bdt_msgs_py.writing import sample_message

FRAIL = """
class Fault(BaseException):
    pass

class Frail:
    def restart(self):
        pass

    def update(self, batch):
        if batch[0, 1] > 1.0:
            raise Fault
"""
CONFIGURATION = """
/**/twin:
  ros__parameters:
    estimator: {kind: "frail:Frail"}
"""
RATE, BATCH = 5000.0, 500


class Machines:
    """Two machines, and what is heard of their twins."""

    def __init__(self, ros):
        self.ros, self.said = ros, {}
        node = ros.create(Node, "machines")
        self.telemetry = {
            name: node.create_publisher(
                Float64MultiArray, f"/{name}/{TELEMETRY.name}", qos_profile(TELEMETRY)
            )
            for name in ("left", "right")
        }
        self.times = dict.fromkeys(self.telemetry, 0)
        node.create_subscription(
            DiagnosticArray, DIAGNOSTICS.name, self._hear, qos_profile(DIAGNOSTICS)
        )

    def _hear(self, message):
        (status,) = message.status
        self.said[status.name] = {each.key: each.value for each in status.values}

    def send(self, name, voltage=0.0):
        rows = np.zeros((BATCH, 3))
        rows[:, 0] = (self.times[name] + np.arange(BATCH)) / RATE
        rows[:, 1] = voltage
        self.times[name] += BATCH
        self.telemetry[name].publish(sample_message(rows, TELEMETRY_COLUMNS))

    def wait_for_twins(self):
        """Wait until both twins say something, and get telemetry."""
        self.said.clear()
        self.ros.spin_until(lambda: {"/left/twin", "/right/twin"} <= self.said.keys())
        matched = self.telemetry.values()
        self.ros.spin_until(lambda: all(one.get_subscription_count() for one in matched))

    def accepted(self, name):
        return int(self.said[f"/{name}/twin"]["telemetry_accepted"])


@pytest.fixture(scope="module")
def fleet(ros_loops, tmp_path_factory):
    """Two twins in one process, the machines that feed them, and what the command says."""
    folder = tmp_path_factory.mktemp("fleet")
    (folder / "frail.py").write_text(FRAIL)
    (folder / "fleet.yaml").write_text(CONFIGURATION)
    log = folder / "log"
    arguments = ["twins", "left", "right", "--config", "fleet.yaml", "--workers", "1"]
    with log.open("wb") as output:
        process = subprocess.Popen(
            [sys.executable, "-m", "bdt_bringup.cli", *arguments],
            cwd=folder,
            env=os.environ,
            stderr=output,
        )
    machines = Machines(ros_loops())
    machines.wait_for_twins()
    yield process, machines, log
    if process.poll() is None:
        process.send_signal(signal.SIGINT)
    process.wait(60.0)


def worker_of(process):
    (pid,) = children(process.pid).values()
    return pid


def test_a_twin_that_fails_is_started_anew_and_takes_no_other_with_it(fleet):
    process, machines, log = fleet
    worker = worker_of(process)
    machines.send("right")
    machines.ros.spin_until(lambda: machines.accepted("right") == 1)
    machines.send("left", voltage=2.0)
    wait_for(lambda: "/left/twin: failed, is started anew" in log.read_text(), "the left one fails")
    machines.wait_for_twins()
    machines.send("right")
    machines.send("left")
    machines.ros.spin_until(lambda: machines.accepted("right") == 2)
    machines.ros.spin_until(lambda: machines.accepted("left") == 1)
    assert worker_of(process) == worker


def test_a_process_that_is_killed_comes_again_with_all_its_twins(fleet):
    process, machines, log = fleet
    os.kill(worker_of(process), signal.SIGKILL)
    wait_for(lambda: "ended with code -9, is started anew" in log.read_text(), "that it is seen")
    machines.wait_for_twins()

    # The subscription of the process that died is there for some time to come.
    def is_fed():
        machines.send("right")
        machines.send("left")
        return machines.accepted("right") and machines.accepted("left")

    machines.ros.spin_until(is_fed)


def test_the_lag_of_each_twin_is_in_its_diagnostics(fleet):
    _, machines, _ = fleet
    machines.wait_for_twins()
    for said in machines.said.values():
        assert float(said["telemetry_lag_s"]) >= 0.0


def test_ctrl_c_ends_all_of_it(fleet):
    process, _, _ = fleet
    worker = worker_of(process)
    process.send_signal(signal.SIGINT)
    assert process.wait(60.0) == 0
    assert not alive(worker)


def test_a_fleet_of_which_no_twin_can_be_had_is_bad_input(tmp_path):
    config = tmp_path / "fleet.yaml"
    config.write_text(CONFIGURATION)
    done = subprocess.run(
        [sys.executable, "-m", "bdt_bringup.cli", "twins", "left", "--config", str(config)],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=60.0,
        check=False,
    )
    assert done.returncode == BAD_INPUT
    (line,) = done.stderr.splitlines()
    assert line.startswith("error: /left/twin: ")
    assert "No module named 'frail'" in line
