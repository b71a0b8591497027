"""A loop of real processes under a schedule of faults: what goes wrong with nodes and files."""

import resource
import shutil
import signal
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np
import rclpy
from fault_relay import CHANNELS, FaultRelay
from forked_node import ForkedNode
from judged_bags import lost_by_recorder, wrong_with_bag
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor

from bdt_msgs_py.message_checks import check_telemetry_times
from bdt_msgs_py.qos import qos_profile
from bdt_msgs_py.stop_signals import StopSignals

RECOVERY = 10.0
"""Time after the last fault in which a loop is back to what it is without faults [s]."""
DEADLINE = 120.0
"""Wall time [s] in which a loop gets on, and the recorder ends, on the busiest of computers."""
LOOK = 0.02
"""Wall time from one look at the processes to the next [s]: each costs as much as a message."""
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


class LoopNode(NamedTuple):
    """A node of the loop.

    Attributes
    ----------
    module : str
        Python module with its ``main``.
    parameters : tuple of str
        Its parameters, as ``name:=value``.
    relayed : tuple of str
        Channels that it sends on, and that go through the relay.
    """

    module: str
    parameters: tuple[str, ...] = ()
    relayed: tuple[str, ...] = ()


class FaultedLoop:
    """Nodes as processes around a relay; see :class:`LockstepLoop` and :class:`MachineLoop`.

    Parameters
    ----------
    nodes : dict of str to LoopNode
        What is started, in this order; the recorder is one of them.
    schedule : tuple of Fault
        What goes wrong.
    domain : int
        ROS domain of the loop.
    """

    def __init__(self, nodes, schedule, domain):
        self._nodes, self._schedule = nodes, schedule
        self._folder = Path(tempfile.mkdtemp(prefix="faults-"))
        self._domain = domain
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
        self._due = sorted(one for one in schedule if one.target in nodes)
        self._passing = []

    def judge(self):
        """Run the loop to its end and return the verdict.

        A request to end is answered between two callbacks, and when no process is left: a node
        that is being started or ended would live on.
        """
        with StopSignals() as signals:
            try:
                verdict = self._run(signals)
            finally:
                self._end()
        signals.check()
        return verdict

    def _run(self, signals):
        for name in self._nodes:
            self._start(name)
        came, end = self._relay.now, time.monotonic() + DEADLINE
        while not self._is_over():
            signals.check()
            self._pass_on()
            if self._relay.now > came:
                came, end = self._relay.now, time.monotonic() + DEADLINE
            if time.monotonic() > end:
                return Verdict("failed", f"hangs at t = {self._relay.now:g} s")
            for name, process in self._running.items():
                if process.poll() is not None and not self._is_over():
                    return Verdict("failed", f"{name} has ended: {self._said()}")
        for _ in range(50):
            self._executor.spin_once(timeout_sec=0.01)
        code = self._stop_recorder()
        said = self._said()
        if code != 0:
            return Verdict("failed", f"the recorder ended with {code}: {said}")
        if "Traceback" in said:
            return Verdict("failed", said)
        rows = np.concatenate(self._rows)
        if not np.isfinite(rows).all():
            return Verdict("failed", "telemetry is not finite")
        wrong = self._wrong_with_bags()
        return Verdict("failed", wrong) if wrong else self._verdict(rows, said)

    def _pass_on(self):
        """Relay messages, and let go wrong what is due, until the next look at the processes."""
        look = time.monotonic() + LOOK
        while time.monotonic() < look:
            self._executor.spin_once(timeout_sec=LOOK)
            self._disturb()

    def _is_over(self):
        """Tell whether the loop has come to its end."""
        raise NotImplementedError

    def _verdict(self, rows, said):
        """Judge the telemetry, rows of (t [s], u [V], q3 [m]), and what all nodes have said."""
        raise NotImplementedError

    @property
    def _over_at(self):
        """Time of the relay from which on the loop is as without faults [s]."""
        return max((fault.end for fault in self._schedule), default=0.0) + RECOVERY

    def _start(self, name):
        self._lives += 1
        node = self._nodes[name]
        rules = [word for one in node.relayed for word in ("-r", f"{topic_of(one)}:=/sent/{one}")]
        parameters = (*node.parameters, *self._files_of(name))
        options = [word for one in parameters for word in ("-p", one)]
        self._running[name] = ForkedNode(
            node.module,
            ["--ros-args", *rules, *options],
            self._folder / f"{self._lives}-{name}.log",
            {"ROS_DOMAIN_ID": str(self._domain)},
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
