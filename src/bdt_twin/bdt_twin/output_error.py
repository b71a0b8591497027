"""Estimator of the backlash gap by output error: the forward model fitted to the newest window."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bdt_plant.plant import PlantModel
from bdt_twin.estimator import Estimate
from bdt_twin.forward_model import SMALLEST_TRAVEL, compiled_structure, compiled_window
from bdt_twin.output_error_fit import Fit, WindowFit
from bdt_twin.output_error_settings import OutputErrorSettings
from bdt_twin.telemetry_window import TelemetryWindow
from bdt_twin.window_model import BEGINNING, FACTORS, Stretch, Unknowns, WindowModel

FloatArray = NDArray[np.float64]

FIRST_GAPS = (2.0, 8.0, 16.0, 28.0)
"""Gaps from which a fit without a predecessor begins [deg]."""
ITERATIONS = 15
MISFIT = 0.05
"""Share of the position's motion that the residual may have in a window that is explained."""


@dataclass(frozen=True, eq=False)
class _Learned:
    fit: Fit
    knots: FloatArray
    stretches: list[Stretch]
    estimate: Estimate
    growth_uncertainty: float


class OutputErrorEstimator:
    def __init__(self, model: PlantModel, settings: OutputErrorSettings) -> None:
        self._model, self._settings = model, settings
        rate = settings.sampling_rate
        self._period = round(settings.update_period * rate)
        self._length = round(settings.window * rate)
        self._window = TelemetryWindow(rate, self._length)
        compiled_window()
        compiled_structure()
        self.restart()

    def restart(self) -> None:
        """Forget everything: another run begins."""
        self._window.restart()
        self._learned: _Learned | None = None

    def update(self, batch: FloatArray, *, newest_only: bool = False) -> Estimate | None:
        end = self._window.end
        try:
            numbers = self._window.append(batch)
        finally:
            if end is not None and self._window.end is None:
                self._learned = None
        # A window ends with the sample whose number is a multiple of the period.
        first = -(-numbers.start // self._period) * self._period
        due = list(range(first, numbers.stop, self._period))
        if newest_only:
            due = due[-1:]
        estimate = None
        for newest in due:
            estimate = self._estimate(newest)
        self._window.forget(numbers.stop)
        return estimate

    def _estimate(self, newest: int) -> Estimate:
        chosen = self._settings
        rate = chosen.sampling_rate
        time = self._window.time(newest)
        shortest = round(chosen.shortest_stretch * rate)
        stretches = self._window.stretches(newest + 1, shortest, chosen.block)
        if not stretches:
            return self._kept(
                time, f"less than {chosen.shortest_stretch:g} s of data without a hole"
            )
        if not any(s.voltage.any() for s in stretches):
            return self._kept(time, "the motor does not move")
        spacing = chosen.knot_spacing
        first = math.floor(stretches[0].first / rate / spacing)
        last = math.ceil((newest + 1) / rate / spacing)
        knots = spacing * np.arange(first, last + 1)
        window = WindowModel(self._model, stretches, knots, rate, chosen.block)
        fit = self._fit(window)
        return self._judge(fit, window, newest, time)

    def _fit(self, window: WindowModel) -> Fit:
        problem = WindowFit(window, self._settings.growth_change)
        last = self._learned
        if last is not None:
            fit = problem.solve(self._follow(window, last), ITERATIONS)
            if fit.noise <= 2.0 * last.fit.noise + 1e-9:
                return fit
            fits = [fit]
        else:
            fits = []
        for gap in FIRST_GAPS:
            beginnings = np.zeros((len(window.stretches), len(BEGINNING)))
            beginnings[:, 1] = [s.position[0] for s in window.stretches]
            gaps = np.full(window.knots.size, math.radians(gap))
            fits.append(
                problem.solve(Unknowns(gaps, np.zeros(len(FACTORS)), beginnings), ITERATIONS)
            )
        return min(fits, key=lambda fit: fit.noise)

    def _follow(self, window: WindowModel, last: _Learned) -> Unknowns:
        rate = self._settings.sampling_rate
        gaps = np.interp(window.knots, last.knots, last.fit.unknowns.gaps)
        after = window.knots > last.knots[-1]
        gaps[after] += last.estimate.growth * (window.knots[after] - last.knots[-1])
        gaps = np.maximum(gaps, 0.0)
        beginnings = np.zeros((len(window.stretches), len(BEGINNING)))
        for beginning, stretch in zip(beginnings, window.stretches, strict=True):
            beginning[1] = stretch.position[0]
            gap = float(np.interp(stretch.first / rate, window.knots, gaps))
            for before, run in zip(last.stretches, last.fit.runs, strict=True):
                index = stretch.first - before.first
                if 0 <= index < run.lag.size and gap > 0:
                    beginning[0] = np.clip(run.lag[index] / (0.5 * gap), -1.0, 1.0)
        return Unknowns(gaps, last.fit.unknowns.factors, beginnings)

    def _judge(self, fit: Fit, window: WindowModel, newest: int, time: float) -> Estimate:
        rate = self._settings.sampling_rate
        travel = sum(run.travel for run in fit.runs)
        if travel < SMALLEST_TRAVEL:
            return self._kept(time, "the lead screw does not move")
        reversals = [
            stretch.first + sample
            for stretch, run in zip(window.stretches, fit.runs, strict=True)
            for sample in run.reversals
        ]
        if not reversals:
            return self._kept(time, "the lead screw does not reverse")
        motion = float(np.std(np.concatenate([run.position for run in fit.runs])))
        if fit.noise > MISFIT * motion:
            return self._kept(
                time,
                f"the model leaves {1e6 * fit.noise:.3g} um of {1e6 * motion:.3g} um of motion",
            )
        covariance = np.linalg.inv(fit.information)[: window.knots.size, : window.knots.size]
        at = reversals[-1] / rate
        weights = window.weights(
            np.array([at, at - 2 * self._settings.knot_spacing]).clip(window.knots[0])
        )
        gap = float(weights[:, 0] @ fit.unknowns.gaps)
        uncertainty = math.hypot(
            math.sqrt(weights[:, 0] @ covariance @ weights[:, 0]),
            _bend(fit.unknowns.gaps, int((at - window.knots[0]) / self._settings.knot_spacing)),
        )
        if uncertainty > self._settings.largest_uncertainty:
            return self._kept(time, "the data do not tell the gap")
        slope = (weights[:, 0] - weights[:, 1]) / (2 * self._settings.knot_spacing)
        estimate = Estimate(
            self._window.time(newest) - (newest - reversals[-1]) / rate,
            gap,
            uncertainty,
            float(slope @ fit.unknowns.gaps),
            math.exp(fit.unknowns.factors[0]),
            len(reversals),
        )
        self._learned = _Learned(
            fit, window.knots, window.stretches, estimate, math.sqrt(slope @ covariance @ slope)
        )
        return estimate

    def _kept(self, time: float, reason: str) -> Estimate:
        if self._learned is None:
            return Estimate(time, math.nan, math.inf, reason=reason)
        last = self._learned.estimate
        age = time - last.time
        grown = math.hypot(
            last.uncertainty,
            age * last.growth,
            age * self._learned.growth_uncertainty,
            self._settings.growth_change * math.sqrt(age**3 / 3),
        )
        return last._replace(time=time, uncertainty=grown, reason=reason)


def _bend(gaps: FloatArray, knot: int) -> float:
    """Return by how much the gap may be off a straight line between the knots `knot` and next."""
    changes = np.abs(np.diff(gaps, 2))[max(knot - 2, 0) : knot + 1]
    return float(changes.max()) / 8 if changes.size else 0.0
