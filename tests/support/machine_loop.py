"""A machine in real time under a schedule of faults: the emulated drive in place of the plant."""

import os
import time
from contextlib import ExitStack, contextmanager, suppress

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray
from fault_schedule import LAST, LONGEST
from faulted_loop import RECOVERY, FaultedLoop, LoopNode, Verdict
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger

from bdt_msgs_py.qos import qos_profile
from bdt_msgs_py.reading import nanoseconds_from_stamp
from bdt_msgs_py.real_time import RealTimeSettings, enter_real_time
from bdt_msgs_py.topics import DIAGNOSTICS, REFERENCE
from checks.emulated_hardware import emulator

STEP_TIME = 4.0
SETTLED = 3.0
"""Time after a step from which on the platform is where it is to be [s]."""
JUDGED = 2 * STEP_TIME
"""Time for which the loop is looked at in the end [s]: one settled step at least."""
DURATION = LAST + LONGEST + RECOVERY + JUDGED
TOLERANCE = 3e-4
"""Distance of the settled platform to its reference [m]: 6 % of a step."""
WALL_TIME = "use_sim_time:=false"
DEVICE_PRIORITY, RELAY_PRIORITY = 45, 42
IN_TIME = "real_time.priority:=40"
"""A busy computer is none of the faults; where it is refused, the nodes say so and go on."""


def nodes_at(port):
    """Return the nodes of a machine at a serial port."""
    return {
        "controller": LoopNode(
            "bdt_controller.controller_node",
            (WALL_TIME, IN_TIME, "voltage_limit:=24.0", f"reference.step_time:={STEP_TIME}"),
            ("command",),
        ),
        "twin": LoopNode(
            "bdt_twin.twin_node",
            (
                WALL_TIME,
                "communication_delay:=0.0",
                "estimator.kind:=output_error",
                "estimator.sampling_rate:=5000.0",
                "service_timeout:=0.5",
            ),
        ),
        "recorder": LoopNode("bdt_bags.recorder.recorder_node"),
        "driver": LoopNode(
            "bdt_driver.driver_node",
            (
                "driver:=bdt_serial_drive.serial_drive:SerialDrive",
                f"drive.port:={port}",
                "drive.watchdog:=0.5",
                "sampling_rate:=5000.0",
                "command_timeout:=0.5",
                IN_TIME,
            ),
            ("measurement", "telemetry"),
        ),
    }


class MachineLoop(FaultedLoop):
    """Driver, controller, twin and recorder, and an emulated drive; all in wall time."""

    def __init__(self, schedule, domain, port):
        super().__init__(nodes_at(port), schedule, domain)
        self._references, self._health, self._answer = [], None, None
        self._relay.create_subscription(
            JointState, REFERENCE.name, self._note_reference, qos_profile(REFERENCE)
        )
        self._relay.create_subscription(
            DiagnosticArray, DIAGNOSTICS.name, self._note_health, qos_profile(DIAGNOSTICS)
        )
        enter_real_time(RealTimeSettings(RELAY_PRIORITY))
        self._arm = self._relay.create_client(Trigger, "/driver/arm")
        self._ends_at = None

    def _note_reference(self, message):
        stamp = nanoseconds_from_stamp(message.header.stamp) * 1e-9
        self._references.append((stamp, message.position[0]))

    def _note_health(self, message):
        self._health = next((one for one in message.status if one.name == "/driver"), self._health)

    def _start(self, name):
        with scheduled(os.SCHED_OTHER, 0):
            super()._start(name)

    def _is_over(self):
        """Tell whether the machine was armed for the duration, or has a fault."""
        if self._answer is None and self._arm.service_is_ready() and self._rows:
            self._answer = self._arm.call_async(Trigger.Request())
        if self._ends_at is None and self._answer is not None and self._answer.done():
            assert self._answer.result().success, self._answer.result().message
            self._ends_at = time.monotonic() + DURATION
        is_done = self._ends_at is not None and time.monotonic() >= self._ends_at
        return is_done or self._fault() != ""

    def _fault(self):
        return self._told("fault")

    def _told(self, key):
        """Return a value of the driver's diagnostics; empty before they come."""
        values = self._health.values if self._health else ()
        return next((one.value for one in values if one.key == key), "")

    def _verdict(self, rows, _said):
        if self._fault():
            voltage = self._told("voltage_v")
            outcome = "stood still" if float(voltage) == 0.0 else "failed"
            return Verdict(outcome, f"{voltage} V: {self._fault()}")
        stamps, levels = np.array(self._references).T
        number = np.searchsorted(stamps, rows[:, 0], side="right") - 1
        is_settled = rows[:, 0] - stamps[number] >= SETTLED
        judged = is_settled & (rows[:, 0] >= self._relay.origin + self._over_at)
        if not judged.any():
            return Verdict("failed", "the reference does not stay for long enough")
        off = float(np.abs(rows[judged, 2] - levels[number[judged]]).max())
        text = f"{1e6 * off:.1f} um from the reference after t = {self._over_at:g} s"
        return Verdict("recovered" if off <= TOLERANCE else "failed", text)


def judge_machine(schedule, domain, folder):
    """Run a machine under a schedule of faults and return the verdict."""
    port = folder / "port"
    with ExitStack() as stack:
        with scheduled(os.SCHED_FIFO, DEVICE_PRIORITY):
            stack.enter_context(emulator(port))
        return MachineLoop(schedule, domain, port).judge()


@contextmanager
def scheduled(policy, priority):
    """Start processes within the block with a policy and a priority, where that is allowed."""
    before = os.sched_getscheduler(0), os.sched_getparam(0)
    with suppress(PermissionError):
        os.sched_setscheduler(0, policy, os.sched_param(priority))
    try:
        yield
    finally:
        os.sched_setscheduler(0, *before)
