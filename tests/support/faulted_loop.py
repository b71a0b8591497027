"""A loop of real processes under a schedule of faults, and the judgment of how it stood them."""

import os
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import rclpy
from fault_relay import CHANNELS, FaultRelay
from fault_schedule import LAST, LONGEST
from judged_bags import lost_by_recorder, wrong_with_bag
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor

from bdt_controller.reference import ReferenceProfile
from bdt_msgs_py.message_checks import check_telemetry_times
from bdt_msgs_py.qos import qos_profile
from bdt_plant.gap_profile import GapProfile
from bdt_plant.plant import PlantModel
from bdt_study.simulation.closed_loop import Scenario
from bdt_study.simulation.twin_loop import simulate_with_twin
from bdt_twin.dead_zone_tolerance import EQUATION_9
from bdt_twin.inverse_filter import InverseFilterEstimator, InverseFilterSettings
from bdt_twin.link import LinkSettings

RECOVERY = 10.0
"""Simulated time after the last fault in which a loop is back to what it is without faults [s]."""
JUDGED = 4.0
"""Simulated time for which it is compared then [s]: a step."""
DURATION = LAST + LONGEST + RECOVERY + JUDGED
TOLERANCE = 3e-4
"""Distance of the position to that without faults [m]: a controller that is new, or that has
waited, goes through its dead zone with another integral; 6 % of a step."""
LOCKSTEP_TIMEOUT = 8.0
DEADLINE = 120.0
GAP, STEP_TIME, DELAY = 0.2, 4.0, 0.3

MODULES = {
    "controller": "bdt_controller.controller_node",
    "twin": "bdt_twin.twin_node",
    "recorder": "bdt_bags.recorder.recorder_node",
    "plant": "bdt_plant.plant_node",
}
PARAMETERS = {
    "controller": ("use_sim_time:=true", f"reference.step_time:={STEP_TIME}"),
    "twin": ("use_sim_time:=true", f"communication_delay:={DELAY}", "service_timeout:=0.5"),
    "plant": (
        f"duration:={DURATION}",
        "gap.kind:=constant",
        f"gap.initial:={GAP}",
        "lockstep_followers:=[twin,recorder]",
        f"lockstep_timeout:={LOCKSTEP_TIMEOUT}",
        # Each lost measurement and command costs it in wall time.
        "resend_period:=0.02",
    ),
}
RENAMED = {
    "controller": ("command",),
    "plant": ("measurement", "telemetry", "clock"),
}
"""What each node sends through the relay."""
HOSTILE = (
    ("dead_zone_tolerance", float("nan")),
    ("dead_zone_tolerance", -1.0),
    ("dead_zone_tolerance", 1e300),
    ("pid.proportional", float("inf")),
    ("voltage_offset", 1e9),
    ("control_rate", 1.0),
    ("no_such_parameter", 1.0),
    ("communication_delay", 0.0),
    ("reconfigure", 1.0),
)
"""What a client asks a node for that must not be granted."""


class Verdict(NamedTuple):
    """How a loop stood a schedule.

    Attributes
    ----------
    outcome : str
        ``recovered``, ``stood still`` (the plant ended, and named who was missing), or ``failed``.
    reason : str
        What was seen.
    """

    outcome: str
    reason: str


@cache
def undisturbed():
    """Return times [s] and positions [m] of the loop without faults, from the cores alone."""
    scenario = Scenario(
        DURATION,
        ReferenceProfile(step_time=STEP_TIME),
        GapProfile(kind="constant", initial=GAP),
    )
    estimator = InverseFilterEstimator(PlantModel(), InverseFilterSettings())
    run = simulate_with_twin(
        scenario, estimator, LinkSettings(communication_delay=DELAY), EQUATION_9
    )
    return run.loop.t, run.loop.q3


class FaultedLoop:
    """Plant, controller, twin and recorder as processes around a relay.

    Parameters
    ----------
    schedule : tuple of Fault
        What goes wrong.
    domain : int
        ROS domain of the loop.
    """

    def __init__(self, schedule, domain):
        self._schedule, self._folder = schedule, Path(tempfile.mkdtemp(prefix="faults-"))
        self._environment = os.environ | {"ROS_DOMAIN_ID": str(domain)}
        self._context = Context()
        rclpy.init(context=self._context, domain_id=domain)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._relay = FaultRelay(schedule, context=self._context)
        self._executor.add_node(self._relay)
        topic, kind, source = CHANNELS["telemetry"]
        self._rows, self._running, self._lives = [], {}, 0
        self._bags = []
        self._relay.create_subscription(
            kind, source, lambda m: self._rows.append(check_telemetry_times(m)), qos_profile(topic)
        )
        self._due = sorted(one for one in schedule if one.target in MODULES)
        self._passing = []

    def judge(self):
        """Run the loop to its end and return the verdict."""
        try:
            for name in MODULES:
                self._start(name)
            end = time.monotonic() + DEADLINE
            plant = self._running["plant"]
            while plant.poll() is None:
                self._executor.spin_once(timeout_sec=0.05)
                self._disturb()
                if time.monotonic() > end:
                    return Verdict("failed", f"hangs at t = {self._relay.now:g} s")
                for name, process in self._running.items():
                    if process is not plant and process.poll() is not None:
                        return Verdict("failed", f"{name} has ended: {self._said()}")
            for _ in range(50):
                self._executor.spin_once(timeout_sec=0.01)
            code = self._stop_recorder()
            if code != 0:
                return Verdict("failed", f"the recorder ended with {code}: {self._said()}")
            wrong = self._wrong_with_bags()
            return Verdict("failed", wrong) if wrong else self._verdict(plant.returncode)
        finally:
            self._end()

    def _start(self, name):
        self._lives += 1
        renamed = RENAMED.get(name, ())
        rules = [word for one in renamed for word in ("-r", f"{topic_of(one)}:=/sent/{one}")]
        parameters = (*PARAMETERS.get(name, ()), *self._files_of(name))
        options = [word for one in parameters for word in ("-p", one)]
        command = [sys.executable, "-m", MODULES[name], "--ros-args", *rules, *options]
        with (self._folder / f"{self._lives}-{name}.log").open("wb") as log:
            self._running[name] = subprocess.Popen(
                command, stdout=log, stderr=log, env=self._environment
            )

    def _files_of(self, name):
        """Return the parameters that name the files of a node; each recorder has its own bag."""
        if name == "twin":
            return (f"state_file:={self._folder / 'twin.json'}",)
        if name == "recorder":
            self._bags.append(self._folder / f"bag-{self._lives}")
            return (f"bag:={self._bags[-1]}",)
        return ()

    def _disturb(self):
        while self._due and self._due[0].time <= self._relay.now:
            fault = self._due.pop(0)
            process = self._running[fault.target]
            if fault.kind == "kill":
                process.send_signal(signal.SIGKILL)
                process.wait()
                self._start(fault.target)
            elif fault.kind == "stop":
                process.send_signal(signal.SIGSTOP)
                self._passing.append((time.monotonic() + fault.duration, continue_, process))
            elif fault.kind == "full":
                limit_files(process, self._largest_file(fault.target))
                self._passing.append((time.monotonic() + fault.duration, limit_files, process))
            else:
                self._ask(fault.target)
        for passing in self._passing[:]:
            due, undo, process = passing
            if due <= time.monotonic():
                self._passing.remove(passing)
                undo(process)

    def _ask(self, name):
        client = self._relay.create_client(SetParameters, f"/{name}/set_parameters")
        for parameter, number in HOSTILE:
            value = ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=number)
            request = SetParameters.Request(parameters=[Parameter(name=parameter, value=value)])
            client.call_async(request)

    def _largest_file(self, name):
        """Return the size [byte] beyond which no file of a node can grow on a disk that is full."""
        files = self._bags[-1].glob("*") if name == "recorder" else ()
        return max((file.stat().st_size for file in files), default=0)

    def _stop_recorder(self):
        """Have what was said last recorded, and end the recorder; return its exit code."""
        for _, undo, process in self._passing:
            undo(process)
        recorder = self._running["recorder"]
        recorder.send_signal(signal.SIGINT)
        return recorder.wait(DEADLINE)

    def _wrong_with_bags(self):
        for bag in self._bags:
            was_killed = bag is not self._bags[-1]
            wrong = wrong_with_bag(bag, self._relay.said, was_killed=was_killed)
            if wrong:
                return wrong
        if any(fault.target == "recorder" for fault in self._schedule):
            return ""
        return lost_by_recorder(self._bags[-1], self._relay.said)

    def _verdict(self, code):
        said = self._said()
        if "Traceback" in said:
            return Verdict("failed", said)
        rows = np.concatenate(self._rows)
        if not np.isfinite(rows).all():
            return Verdict("failed", "telemetry is not finite")
        if code != 0:
            errors = [line for line in said.splitlines() if line.startswith("error: ")]
            if code == 1 and len(errors) == 1 and " waited " in errors[0]:
                return Verdict("stood still", errors[0])
            return Verdict("failed", f"the plant ended with {code}: {said}")
        times, expected = undisturbed()
        over = max((fault.end for fault in self._schedule), default=0.0) + RECOVERY
        judged = rows[rows[:, 0] >= over]
        number = np.rint(judged[:, 0] * 5000.0).astype(int)
        np.testing.assert_allclose(times[number], judged[:, 0], atol=1e-9)
        off = float(np.abs(judged[:, 2] - expected[number]).max())
        text = f"{1e6 * off:.1f} um from the loop without faults after t = {over:g} s"
        return Verdict("recovered" if off <= TOLERANCE else "failed", text)

    def _said(self):
        logs = sorted(self._folder.glob("*.log"))
        return "\n".join(log.read_text(encoding="utf-8", errors="replace") for log in logs)

    def _end(self):
        for process in self._running.values():
            process.kill()
            process.wait()
        self._executor.shutdown()
        self._relay.destroy_node()
        self._context.try_shutdown()
        shutil.rmtree(self._folder)


def continue_(process):
    """Let a stopped process go on."""
    process.send_signal(signal.SIGCONT)


def limit_files(process, size=resource.RLIM_INFINITY):
    """Let no file that a process writes become larger [byte], as on a disk that is full."""
    if process.poll() is None:
        resource.prlimit(process.pid, resource.RLIMIT_FSIZE, (size, resource.RLIM_INFINITY))


def topic_of(name):
    """Return the topic of a channel, as its sender names it."""
    return CHANNELS[name][0].name


def judge(schedule, domain):
    """Run a loop under a schedule of faults and return the verdict."""
    return FaultedLoop(schedule, domain).judge()
