"""Limit cycles as the harmonic balance predicts them, beside simulated ones."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bdt_controller.pid import PidGains
from bdt_plant.plant import PlantModel, Sampling
from bdt_study.design.linear_model import is_stable, loop_transfer
from bdt_study.limit_cycles.harmonic_balance import (
    LimitCycle,
    describing_function_cycle,
    harmonic_balance_cycle,
)
from bdt_study.simulation.closed_loop import Scenario, simulate

FloatArray = NDArray[np.float64]

METHODS = ("describing_function", "harmonic_balance", "simulation")
"""Fields of a comparison, from simple to exact."""


@dataclass(frozen=True)
class LimitCycleComparison:
    """The three answers for one gap and structure.

    Attributes
    ----------
    gap : float
        Backlash gap theta_b [rad].
    stiffness : float
        Stiffness k of the beams [N/m].
    describing_function, harmonic_balance, simulation : LimitCycle or None
        None where the method finds no limit cycle.
    """

    gap: float
    stiffness: float
    describing_function: LimitCycle | None
    harmonic_balance: LimitCycle | None
    simulation: LimitCycle | None


def simulated_cycle(
    model: PlantModel,
    gains: PidGains,
    gap: float,
    sampling: Sampling | None = None,
    settling_time: float = 15.0,
    observed_time: float = 10.0,
) -> LimitCycle | None:
    """Return the limit cycle that the simulated loop runs into at a constant gap.

    The reference steps by the lost motion p theta_b, comparable to the limit cycle, so that it
    comes soon at any gap.

    Parameters
    ----------
    model, gains, gap
        See :func:`bdt_study.limit_cycles.harmonic_balance.describing_function_cycle`.
    sampling : Sampling, optional
        Rates of plant and controller.
    settling_time, observed_time : float
        Simulated time before and during the measurement [s].

    Returns
    -------
    LimitCycle or None
        None when the motor does not turn back and forth, or when the oscillation changes by more
        than 2 % over the observed time: it decays or is not yet there.
    """
    sampling = sampling or Sampling()
    scenario = Scenario(
        duration=settling_time + observed_time,
        reference=model.lead_screw.pitch * gap,
        gap=gap,
        model=model,
        gains=gains,
        sampling=sampling,
    )
    trajectory = simulate(scenario, ("q3", "theta_m"))
    rate = sampling.sampling_rate
    observed = slice(round(settling_time * rate), None)
    position, angle = trajectory.q3[observed], trajectory.theta_m[observed]
    # The motor's angle has weaker harmonics than q3: it crosses its mean twice a period.
    turning = angle - 0.5 * (angle.max() + angle.min())
    before = np.flatnonzero((turning[:-1] < 0) & (turning[1:] >= 0))
    crossings = before + turning[before] / (turning[before] - turning[before + 1])
    if crossings.size < 3 or np.ptp(angle) < gap:
        return None
    period = float(crossings[-1] - crossings[0]) / (crossings.size - 1)
    half = position.size // 2
    first, second = float(np.ptp(position[:half])), float(np.ptp(position[half:]))
    if abs(second - first) > 0.02 * first:
        return None
    whole = position[round(crossings[0]) : round(crossings[-1])]
    phase = 2 * math.pi * np.arange(whole.size) / period
    sizes = [2 * abs(np.mean((whole - whole.mean()) * np.exp(-1j * h * phase))) for h in (1, 3)]
    return LimitCycle(
        gap,
        2 * math.pi * rate / period,
        float(sizes[0]),
        float(np.ptp(whole)),
        float(sizes[1] / sizes[0]),
    )


def compare_over_gap(
    model: PlantModel, gains: PidGains, gaps: FloatArray
) -> tuple[LimitCycleComparison, ...]:
    """Return the three answers for each gap.

    Parameters
    ----------
    model, gains
        See :func:`bdt_study.limit_cycles.harmonic_balance.describing_function_cycle`.
    gaps : ndarray, shape (n,)
        Constant gaps [rad], positive.
    """
    predicted = describing_function_cycle(model, gains, 1.0)
    balanced = harmonic_balance_cycle(model, gains, 1.0)
    return tuple(
        LimitCycleComparison(
            gap,
            model.structure.stiffness,
            _scaled(predicted, gap),
            _scaled(balanced, gap),
            simulated_cycle(model, gains, gap),
        )
        for gap in gaps.tolist()
    )


def compare_over_stiffness(
    model: PlantModel, gains: PidGains, gap: float, factors: FloatArray
) -> tuple[LimitCycleComparison, ...]:
    """Return the three answers for stiffer and softer structures with the same damping ratio.

    It shows where the describing function holds: with the first mode well above three times the
    frequency of the limit cycle.

    Parameters
    ----------
    model, gains, gap
        See :func:`bdt_study.limit_cycles.harmonic_balance.describing_function_cycle`.
    factors : ndarray, shape (n,)
        Factors on the stiffness; a loop that is unstable without backlash is left out.
    """
    comparisons: list[LimitCycleComparison] = []
    for factor in factors.tolist():
        beams = model.structure
        changed = replace(
            beams,
            stiffness=factor * beams.stiffness,
            damping=math.sqrt(factor) * beams.damping,
        )
        stiffer = replace(model, structure=changed)
        if is_stable(loop_transfer(stiffer, gains)):
            comparisons.extend(compare_over_gap(stiffer, gains, np.array([gap])))
    return tuple(comparisons)


def limit_cycle_rows(
    comparisons: Sequence[LimitCycleComparison],
) -> list[tuple[str, str, str, str, str, str]]:
    """Return comparisons over the gap as the cells of a table, one row a gap and method.

    Parameters
    ----------
    comparisons : sequence of LimitCycleComparison
        From :func:`compare_over_gap`.

    Returns
    -------
    list of tuple of str
        Gap [deg], method, frequency [rad/s] or "none", fundamental and peak to peak [um], third
        harmonic over the fundamental.
    """
    rows = []
    for each in comparisons:
        for method in METHODS:
            cycle: LimitCycle | None = getattr(each, method)
            found = (
                ("none", "", "", "")
                if cycle is None
                else (
                    f"{cycle.frequency:.2f}",
                    f"{1e6 * cycle.fundamental:.1f}",
                    f"{1e6 * cycle.peak_to_peak:.1f}",
                    f"{cycle.third_harmonic:.2f}",
                )
            )
            rows.append((f"{math.degrees(each.gap):.4g}", method.replace("_", " "), *found))
    return rows


def limit_cycle_table(comparisons: Sequence[LimitCycleComparison]) -> str:
    """Return :func:`limit_cycle_rows` as a Markdown table, for a report or an issue."""
    lines = [
        "| gap [deg] | method | rad/s | fundamental [µm] | peak to peak [µm] | third harmonic |",
        "|---|---|---|---|---|---|",
    ]
    lines += [f"| {' | '.join(row)} |" for row in limit_cycle_rows(comparisons)]
    return "\n".join(lines)


def _scaled(cycle: LimitCycle | None, gap: float) -> LimitCycle | None:
    """Return the limit cycle of a gap of 1 rad at another gap: the loop is homogeneous."""
    if cycle is None:
        return None
    return replace(
        cycle,
        gap=gap,
        fundamental=gap * cycle.fundamental,
        peak_to_peak=gap * cycle.peak_to_peak,
    )
