"""Error of the kernel over its step size, against a reference that locates contact changes.

The kernel advances motor and structure exactly. What it does not do is find the instant within a
sample at which the motor touches the screw or leaves it. So without backlash there is nothing to
converge, at any step size; with backlash the error comes from the samples in which contact
changes. The instant is then wrong by a part of the step h, and the screw has moved on a path that
differs by the motor's acceleration times h^2: the error of q3 is of second order.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from bdt_controller.pid import INITIAL_PID, discretize_pid, pid_step
from bdt_plant.gap_profile import GapProfile, gap_at
from bdt_plant.motor import motor_state_space
from bdt_plant.plant import PlantModel, Sampling
from bdt_plant.structure import structure_state_space
from bdt_study.simulation.closed_loop import Scenario, sample_inputs, simulate

FloatArray = NDArray[np.float64]

RATES = (1000.0, 2500.0, 5000.0, 10000.0, 20000.0)
"""Sampling rates [Hz] of a study; the controller keeps its 500 Hz."""

LONGEST_STEP = 2e-4
"""Longest step of the reference [s]: contact opens and closes at least some steps apart."""

ANGLE_TOLERANCE = 1e-9
"""Distance from the end of the gap that counts as contact [rad]; 1.6e-13 m of the screw."""

MOST_EVENTS = 100
"""Contact changes between two measurements after which the reference gives up."""

SPEED_TOLERANCE = 1e-9
"""Speed relative to the end of the gap that counts as none [rad/s]."""

SCENARIOS = (
    ("without backlash", GapProfile(kind="constant"), 0.5),
    (
        "gap of 10°, growing by 0.25°/s",
        GapProfile(kind="ramp", initial=math.radians(10.0), final=math.radians(40.0)),
        1.0,
    ),
)
"""Name, gap and simulated time [s], short enough that neighboring paths stay together."""


@dataclass(frozen=True)
class Convergence:
    """Error of the kernel for several step sizes.

    Attributes
    ----------
    scenario : str
        What was simulated.
    rates : tuple of float
        Sampling rates [Hz], increasing.
    errors : tuple of float
        Largest difference of q3 at the measurements from the reference [m].
    order : float or None
        Order in the step size, fitted; None when the error is that of the reference.
    """

    scenario: str
    rates: tuple[float, ...]
    errors: tuple[float, ...]
    order: float | None


def convergence_study(rates: Sequence[float] = RATES) -> tuple[Convergence, ...]:
    """Return the errors of the linear controller without and with a growing gap.

    Parameters
    ----------
    rates : sequence of float
        Sampling rates [Hz], multiples of 500 Hz.
    """
    return tuple(_convergence(name, gap, time, rates) for name, gap, time in SCENARIOS)


def reference_positions(scenario: Scenario, gap: GapProfile) -> FloatArray:
    """Return q3 at the measurements of a closed loop, integrated with located events.

    DOP853 with a relative tolerance of 1e-10 integrates between the instants at which eq. 6
    changes: the motor reaches the end of the gap, or turns back and leaves it. (In a gap that
    grows it leaves when it is slower than the end of the gap.)

    Parameters
    ----------
    scenario : Scenario
        Loop; its dead zone is ignored.
    gap : GapProfile
        Its gap: constant, or a ramp that lasts longer than the run.

    Returns
    -------
    ndarray, shape (control steps,)
        Positions q3 [m].
    """
    mechanism = _Mechanism(scenario.model, gap)
    pid, state = INITIAL_PID, np.zeros(8)
    step = discretize_pid(scenario.gains, 1.0 / scenario.sampling.control_rate)
    reference = sample_inputs(scenario).references
    positions = []
    for k in range(scenario.control_steps):
        positions.append(state[6])
        pid, voltage = pid_step(pid, float(reference[k]) - state[6], step)
        begin, end = (float(n / scenario.sampling.control_rate) for n in (k, k + 1))
        state = mechanism.integrate(state, voltage, begin, end)
    return np.array(positions)


class _Mechanism:
    """Continuous plant with the state (i, omega_m, theta_m, theta_d, q2, q2', q3, q3')."""

    def __init__(self, model: PlantModel, gap: GapProfile) -> None:
        self._gap = gap
        self._growth = (gap_at(gap, LONGEST_STEP) - gap_at(gap, 0.0)) / LONGEST_STEP
        self._pitch = model.lead_screw.pitch
        self._motor, self._voltage = motor_state_space(model.motor)
        self._structure, self._screw = structure_state_space(model.structure)

    def integrate(self, state: FloatArray, voltage: float, begin: float, end: float) -> FloatArray:
        """Return the state at `end` [s] for a constant voltage [V] from `begin` on."""
        time = begin
        for _ in range(MOST_EVENTS):
            side = self._driven_side(time, state)
            solution: Any = solve_ivp(
                lambda _t, x, side=side: self._rates(x, voltage, side),
                (time, end),
                state,
                "DOP853",
                rtol=1e-10,
                atol=1e-14,
                max_step=LONGEST_STEP,
                events=self._event(side),
            )
            time, state = float(solution.t[-1]), solution.y[:, -1]
            if time >= end:
                return state
        raise RuntimeError(f"contact changes without end at t = {time!r} s")

    def _rates(self, x: FloatArray, voltage: float, side: int) -> FloatArray:
        screw_speed = x[1] - 0.5 * side * self._growth if side else 0.0
        rates = np.empty(8)
        rates[:3] = self._motor @ x[:3] + self._voltage[:, 0] * voltage
        rates[3] = screw_speed
        d = self._pitch * np.array([x[3], screw_speed])
        rates[4:] = self._structure @ x[4:] + self._screw @ d
        return rates

    def _leaving(self, side: int, x: FloatArray) -> float:
        """Return how much faster than the end of the gap the motor turns towards it."""
        return float(side * x[1] - 0.5 * self._growth)

    def _driven_side(self, time: float, x: FloatArray) -> int:
        """Return the side on which the motor drives the screw from now on, 0 for neither."""
        half = 0.5 * gap_at(self._gap, time)
        if half == 0.0:
            return 1
        play = float(x[2] - x[3])
        if abs(play) < half - ANGLE_TOLERANCE:
            return 0
        side = int(math.copysign(1, play))
        towards = self._leaving(side, x)
        if abs(towards) < SPEED_TOLERANCE:
            # The motor just turns back: its acceleration says in which direction.
            towards = side * float(self._motor[1] @ x[:3])
        return side if towards > 0 else 0

    def _event(self, side: int) -> Callable[[float, FloatArray], float] | None:
        if gap_at(self._gap, 0.0) == 0.0 and self._growth == 0.0:
            return None

        def leaves(_time: float, x: FloatArray) -> float:
            return self._leaving(side, x)

        def touches(time: float, x: FloatArray) -> float:
            return abs(float(x[2] - x[3])) - 0.5 * gap_at(self._gap, time)

        event: Any = leaves if side else touches
        event.terminal, event.direction = True, -1 if side else 1
        chosen: Callable[[float, FloatArray], float] = event
        return chosen


def _convergence(
    name: str, gap: GapProfile, duration: float, rates: Sequence[float]
) -> Convergence:
    scenario = Scenario(duration=duration, reference=0.005, gap=gap)
    expected = reference_positions(scenario, gap)
    errors = []
    for rate in rates:
        sampling = Sampling(sampling_rate=rate)
        finer = Scenario(duration=duration, reference=0.005, gap=gap, sampling=sampling)
        position = simulate(finer, ("q3",)).q3[:: sampling.samples_per_control_step]
        errors.append(float(np.max(np.abs(position - expected))))
    backlash = gap_at(gap, duration) > 0.0
    return Convergence(
        name, tuple(rates), tuple(errors), order_of(rates, errors) if backlash else None
    )


def order_of(rates: Sequence[float], errors: Sequence[float]) -> float:
    """Return the order of convergence: the slope of log error over log step size."""
    slope = np.polyfit(np.log(np.asarray(rates)), np.log(np.asarray(errors)), 1)[0]
    return float(-slope)
