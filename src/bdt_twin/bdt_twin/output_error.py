"""Estimator of the backlash gap by output error: the forward model fitted to the newest window.

Voltage -> motor -> play -> structure is simulated with the plant's own step functions, and its
unknowns are chosen such that the simulated position is the measured one. Nothing is
differentiated, so noise on the position does little harm.
"""

import math

import numpy as np
from numpy.typing import NDArray

from bdt_plant.elementary_functions import float_exponential
from bdt_plant.plant import PlantModel
from bdt_twin import fixed_order
from bdt_twin.alternative_friction import AlternativeFriction
from bdt_twin.answer_check import AnswerCheck
from bdt_twin.cogging_trials import CoggingTrials
from bdt_twin.compiled_loops import LOOPS
from bdt_twin.estimator import Estimate
from bdt_twin.fit_doubt import FIRST_MOTIONS
from bdt_twin.fit_result import Fit
from bdt_twin.gap_doubt import doubted
from bdt_twin.gap_knowledge import GapKnowledge
from bdt_twin.gap_of_fit import answered_reversals, gap_at, growth_at, growth_change_of
from bdt_twin.growth_knowledge import GrowthKnowledge
from bdt_twin.machine_memory import MachineMemory
from bdt_twin.machine_recollection import MachineRecollection
from bdt_twin.model_factors import FACTORS, check_room
from bdt_twin.next_fit import AcceptedFit, next_fit
from bdt_twin.noise_levels import is_walking
from bdt_twin.output_error_settings import OutputErrorSettings
from bdt_twin.sensor_saturation import motor_travel_in_saturation
from bdt_twin.telemetry_window import TelemetryWindow
from bdt_twin.unexplained_window import unexplained
from bdt_twin.window_model import WindowModel
from bdt_twin.window_prediction import Predecessor
from bdt_twin.window_search import explains_worse, leaves_newest_unexplained

FloatArray = NDArray[np.float64]

MOST_HELD = 5
"""Windows in a row that leave the gap or their newest data unknown before a fit begins anew."""
LARGEST_SATURATED_TRAVEL = 2.0
"""Angle by which the motor may turn, beside twice the gap, while the position is stuck [rad]."""


class OutputErrorEstimator:
    """Fits the forward model to the newest window of telemetry, once in each update period.

    An estimate states the gap at the last reversal of the screw that the platform has answered:
    later samples tell nothing about the gap until the screw reverses again. Its time is that of
    this reversal, when the screw began to move the other way, so the gap at another time is
    ``gap + growth * (time - estimate.time)``. A window that teaches nothing repeats the last
    estimate, with an uncertainty that covers all that the gap may have grown until its end.

    A missing batch leaves a hole. The stretches of data on its sides are fitted together, each
    with a beginning of its own; those shorter than ``shortest_stretch`` are left out, because
    their beginning takes all they tell. Samples far off the others around are left out, too.

    Windows end with samples whose number is a multiple of the update period, so the estimates do
    not depend on how the telemetry is split into batches.

    Parameters
    ----------
    model : PlantModel
        Constants of the mechanism, as the twin knows them. The gain of the motor and the
        structure's k/m and c/m are corrected by factors that are fitted, too, and so are effects
        that the model has not, once the data give evidence of them.
    settings : OutputErrorSettings
        Settings of the estimator.
    sampling_rate : float
        Sampling rate of the telemetry [Hz].

    Raises
    ------
    ValueError
        If the update period is not a whole number of samples, or the fit would leave the limits of
        a constant of the model.

    Attributes
    ----------
    last_fit : AcceptedFit or None
        The last window that taught something, for those who want to know more than the estimate.
    """

    def __init__(
        self, model: PlantModel, settings: OutputErrorSettings, sampling_rate: float = 5000.0
    ) -> None:
        check_room(model)
        self._model, self._settings, self._rate = model, settings, sampling_rate
        self._period = settings.samples_per_update(sampling_rate)
        self._block = settings.samples_per_block(sampling_rate)
        self._recalled: tuple[MachineRecollection, float] | None = None
        self._window = TelemetryWindow(sampling_rate, round(settings.window * sampling_rate))
        # Whatever is not in numba's cache is compiled now, not when the first batch waits.
        for compiled in LOOPS:
            compiled()
        self.restart()

    def restart(self) -> None:
        """Forget everything: another run begins."""
        self._window.restart()
        self._recalled = None
        self._forget_fits()

    @property
    def recollection(self) -> MachineRecollection | None:
        """What is worth keeping of the machine beyond the end of the program; None for nothing."""
        return self._machine.recollection()

    def recall(self, kept: MachineRecollection, age: float) -> None:
        """Begin with what another estimator has kept of the same machine some time [s] ago."""
        self._recalled = kept, age
        self._forget_fits()

    def _forget_fits(self) -> None:
        self.last_fit: AcceptedFit | None = None
        self._walks = False
        self._predecessor: Predecessor | None = None
        self._moves_from = self._error = math.inf
        self._check, self._held = AnswerCheck(self._settings.largest_uncertainty), 0
        self._gap = GapKnowledge(self._settings.largest_uncertainty)
        self._growth = GrowthKnowledge(self._settings.growth_change)
        self._machine = MachineMemory(self._model.motor)
        if self._recalled is not None:
            self._machine.recall(*self._recalled)
        self._trials, self._friction = CoggingTrials(self._model.motor), AlternativeFriction()

    def update(self, batch: FloatArray, *, newest_only: bool = False) -> Estimate | None:
        """Take the next batch.

        Parameters
        ----------
        batch : ndarray, shape (n, 3)
            Telemetry rows (t [s], u [V], q3 [m]), oldest first, one sample time apart.
        newest_only : bool
            Let all windows go but the newest that ends within the batch. This is for those who
            are behind; the estimates then depend on the batches a little, because each fit begins
            where the last one ended.

        Returns
        -------
        Estimate or None
            The estimate from the newest window that ended within the batch; None if none did.

        Raises
        ------
        TelemetryRejectedError
            For a batch that is empty, not finite, not sampled at the sampling rate, or going back
            in time. Time that goes back restarts the estimator; any other rejected batch leaves a
            hole.
        """
        numbers = self._append(batch)
        if math.isinf(self._moves_from) and batch[:, 1].any():
            first = numbers.start + int(np.flatnonzero(batch[:, 1])[0])
            self._moves_from = first / self._rate
        due = range(-(-numbers.start // self._period) * self._period, numbers.stop, self._period)
        estimate = None
        for newest in due[-1:] if newest_only else due:
            estimate = self._estimate(newest)
        self._window.forget(numbers.stop)
        return estimate

    def _append(self, batch: FloatArray) -> range:
        try:
            return self._window.append(batch)
        finally:
            # The window forgets itself when time goes back.
            if self._window.end is None:
                self._forget_fits()

    def _estimate(self, newest: int) -> Estimate:
        """Return the estimate from the window whose last sample has the number `newest`."""
        chosen, time = self._settings, self._window.time(newest)
        rate, spacing = self._rate, chosen.knot_spacing
        shortest = round(chosen.shortest_stretch * rate)
        stretches = self._window.stretches(newest + 1, shortest, self._block)
        if not stretches:
            reason = f"no {chosen.shortest_stretch:g} s of data without a hole"
            return self._hold_estimate(time, reason)
        if not any(stretch.voltage.any() for stretch in stretches):
            return self._hold_estimate(time, "the motor does not move")
        known = 0.0 if self.last_fit is None else self.last_fit.estimate.gap
        per_volt = 1.0 / (rate * self._model.motor.back_emf_constant)
        if any(
            motor_travel_in_saturation(stretch.voltage, stretch.position, per_volt)
            > LARGEST_SATURATED_TRAVEL + 2.0 * known
            for stretch in stretches
        ):
            reason = "the position is stuck at its extreme while the motor turns"
            return self._hold_estimate(time, reason)
        numbers = np.arange(
            math.floor(stretches[0].first / rate / spacing),
            math.ceil((newest + 1) / rate / spacing) + 1,
        )
        knots: FloatArray = spacing * numbers.astype(np.float64)
        every = chosen.samples_per_step(rate, walks=self._walks)
        block = self._block // every
        averaged = [stretch.averaged(every, block) for stretch in stretches]
        window = WindowModel(self._model, averaged, knots, rate / every, block, self._machine.cogs)
        window, fit = next_fit(window, self._predecessor, self._machine, self._growth.change)
        machine, fit = self._friction.better(window, fit, self._machine, self._growth.change)
        if machine is not self._machine:
            self._machine, self._predecessor = machine, Predecessor(window, fit, 0.0)
        estimate = self._validate(window, fit, newest)
        if estimate.reason:
            self._try_cogging(window, fit)
        return estimate

    def _try_cogging(self, window: WindowModel, fit: Fit) -> None:
        """Look further for what explains a window that has taught nothing."""
        found = self._trials.advance(window, fit, self._machine, self._growth.change)
        if found is not None:
            self._machine.begin_anew(found.cogs, found.present)
            self._friction = AlternativeFriction()
            self._predecessor, self._held = found.window, 0
            self._error = found.window.fit.prediction_error

    def _validate(self, window: WindowModel, fit: Fit, newest: int) -> Estimate:
        """Return what a fit teaches, or the last estimate with the reason why it does not."""
        time = self._window.time(newest)
        reversals = answered_reversals(self._model, window, fit, newest / self._rate)
        self._walks = is_walking(fit.levels, window.motion)
        if reason := unexplained(fit, len(reversals), self._machine):
            self._check.unexplained()
            return self._hold_estimate(time, reason)
        # Telemetry may be stamped anywhere between two multiples of the sample time.
        at = reversals[-1]
        stamp = time - (newest / self._rate - at)
        gap, uncertainty = gap_at(window, fit, at)
        is_unsure = uncertainty > self._settings.largest_uncertainty
        is_first = self._recalled is None and at < self._moves_from + FIRST_MOTIONS
        uncertainty = doubted(window, fit, at, uncertainty, len(reversals), is_first=is_first)
        growth, growth_uncertainty = growth_at(window, fit, at)
        sudden = self._growth.sudden(stamp, growth, growth_uncertainty)
        before, self._error = self._error, fit.prediction_error
        # A fit that had to begin anew may have found a bad one; the next window tells.
        is_surprised = leaves_newest_unexplained(window, fit) or explains_worse(window, fit, before)
        last = fit if self.last_fit is None else self.last_fit.fit
        doubt = self._check.doubt(
            gap,
            uncertainty,
            self._gap.expected(stamp, self._growth.change),
            fit.levels,
            at=at,
            pushed=fixed_order.mean(fit.pushed),
            is_surprised=is_surprised,
            error_ratio=fit.prediction_error / last.prediction_error,
        )
        self._held = self._held + 1 if is_surprised or is_unsure else 0
        # Windows that follow find out more from here, unless it is here that nothing is found.
        follows = self._held < MOST_HELD
        self._predecessor = Predecessor(window, fit, growth) if follows else None
        self._held = self._held if follows else 0
        gain = float_exponential(float(fit.unknowns.factors[FACTORS.index("gain")]))
        # A gap that has jumped does not grow from knot to knot: it is that at either of them.
        jump = 0.5 * self._settings.knot_spacing * sudden
        estimate = Estimate(
            time=stamp,
            gap=gap,
            uncertainty=math.hypot(uncertainty, self._friction.doubt(fit), jump),
            growth=growth,
            growth_uncertainty=math.hypot(growth_uncertainty, sudden),
            gain_correction=gain,
            reversals=len(reversals),
            age=time - stamp,
        )
        if doubt.reason:
            if doubt.is_rough:
                self._gap.learn_roughly(estimate, self._growth.change)
            return self._hold_estimate(time, doubt.reason)
        offset = self._machine.voltage_offset(fit.machine)
        if offset is not None:
            estimate = estimate._replace(
                voltage_offset=offset.voltage, voltage_offset_uncertainty=offset.uncertainty
            )
        self._growth.learn(estimate, sudden, growth_change_of(window, fit))
        estimate = self._gap.learn(estimate)
        self.last_fit = AcceptedFit(window, fit, estimate)
        self._machine.learn(newest / self._rate, fit.machine)
        return estimate

    def _hold_estimate(self, time: float, reason: str) -> Estimate:
        """Return what is known of the gap, as unsure as it is for a window that ends at `time`."""
        return self._gap.held(time, reason, self._growth.change)
