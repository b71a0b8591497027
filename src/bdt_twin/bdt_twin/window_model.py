"""Position over a window as a function of what is unknown about the mechanism, and its Jacobian."""

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from bdt_plant.elementary_functions import FULL_TURN, float_exponential
from bdt_plant.plant import PlantModel
from bdt_plant.structure import DiscreteStructure, StructureState
from bdt_twin.applied_voltage import applied_voltage
from bdt_twin.drive_bases import drive_bases
from bdt_twin.fixed_order import block_means, dot, product, standard_deviation
from bdt_twin.forward_model import (
    StretchResponse,
    initial_state,
    simulate_stretch,
    slow_motion,
    travel_in,
)
from bdt_twin.friction_change import FrictionChange
from bdt_twin.gap_samples import GapSamples, knot_weights
from bdt_twin.innovations import DeviationModel, Motion
from bdt_twin.machine_knowledge import EFFECTS, THREAD, TOP_MASS
from bdt_twin.model_factors import FACTORS, MODEL_FACTORS, block_model_with, plant_step_with
from bdt_twin.play_bases import play_bases
from bdt_twin.resisted_model import LONGEST_PART, resisted_plant_with, with_cogs
from bdt_twin.stretch import LEAD, Stretch
from bdt_twin.structure_responses import structure_responses
from bdt_twin.thread_error import thread_response, thread_waves
from bdt_twin.unknowns import INITIAL_CONDITION, Unknowns
from bdt_twin.window_loop import DRIVES

FloatArray = NDArray[np.float64]

FACTOR_CHANGE = 1e-3
"""Change of a factor's logarithm from which the slope of the position is taken."""


class WindowModel:
    """The forward model of one window.

    Parameters
    ----------
    model : PlantModel
        Constants of the mechanism, as the twin knows them.
    stretches : sequence of Stretch
        Data of the window.
    knots : ndarray, shape (knots,)
        Times of the gap's knots, evenly spaced [s].
    sampling_rate : float
        Sampling rate [Hz].
    block : int
        Samples in a block.
    cogs : int
        Periods of the motor's cogging in a turn; 0 for none.

    Attributes
    ----------
    longest_part : float
        Time that a motor takes to stop in a single step [s]; see :func:`resisted_plant_with`.
    """

    longest_part = LONGEST_PART

    def __init__(
        self,
        model: PlantModel,
        stretches: list[Stretch],
        knots: FloatArray,
        sampling_rate: float,
        block: int,
        cogs: int = 0,
    ) -> None:
        self.stretches, self.knots, self.block, self.cogs = stretches, knots, block, cogs
        self.block_rate = sampling_rate / block
        self.sampling_rate, self.pitch = sampling_rate, model.lead_screw.pitch
        self._model = model
        self._blocks = [stretch.voltage.size // block for stretch in stretches]
        self._times = [np.arange(stretch.voltage.size) / sampling_rate for stretch in stretches]
        self._gaps = [GapSamples(knots, stretch, sampling_rate) for stretch in stretches]

    def newest(self, duration: float) -> "WindowModel":
        """Return the window of its newest data without a hole, of no more than some time [s]."""
        count, lead = int(duration * self.block_rate) * self.block, round(LEAD * self.sampling_rate)
        if len(self.stretches) == 1 and count >= self.samples:
            return self
        stretch = self.stretches[-1].newest(count, max(lead, 1))
        begins = stretch.first / self.sampling_rate
        knots = self.knots[max(int(np.searchsorted(self.knots, begins, side="right")) - 1, 0) :]
        return WindowModel(self._model, [stretch], knots, self.sampling_rate, self.block, self.cogs)

    def coarse(self, lowest_rate: float, lowest_block_rate: float) -> "WindowModel":
        """Return the window with fewer samples and blocks, for a rough fit in little time.

        Parameters
        ----------
        lowest_rate, lowest_block_rate : float
            Rates of samples and blocks [Hz], not to go below; the window's own may be lower.
        """
        every = max(int(self.sampling_rate / lowest_rate), 1)
        rate = self.sampling_rate / every
        block = max(int(rate / lowest_block_rate), round(rate / self.block_rate), 1)
        stretches = [
            stretch.averaged(every, block)._replace(readings=None) for stretch in self.stretches
        ]
        window = WindowModel(self._model, stretches, self.knots, rate, block, self.cogs)
        window.longest_part = np.inf
        return window

    def simulate(self, unknowns: Unknowns) -> list[StretchResponse]:
        """Simulate each stretch."""
        effect = dict(zip(EFFECTS, unknowns.effects.tolist(), strict=True))
        friction, sample_time = unknowns.friction, 1.0 / self.sampling_rate
        of_step = unknowns.factors, unknowns.effects, sample_time, self.longest_part
        step = resisted_plant_with(self._model, *of_step)
        gain = float_exponential(float(unknowns.factors[FACTORS.index("gain")]))
        back_emf = self._model.motor.back_emf_constant / gain
        responses = []
        for number, (stretch, beginning) in enumerate(
            zip(self.stretches, unknowns.initial_conditions, strict=True)
        ):
            gaps = self._gaps[number].at(unknowns.gaps)
            applied = applied_voltage(stretch, unknowns.effects, sample_time)
            state = initial_state(
                StructureState(*beginning[2:].tolist()),
                0.5 * float(beginning[0]) * float(gaps[0]),
                np.append(applied.before, applied.voltage[0]),
                back_emf,
                step.plant,
            )
            turns = self.cogs * self.screw_turns(unknowns, number)
            run = simulate_stretch(
                with_cogs(step, self.cogs, turns, unknowns.effects),
                state,
                applied.voltage,
                gaps,
                self.block,
                sample_time,
                slow_motion(friction, back_emf),
                FrictionChange(
                    friction,
                    effect["friction_growth"],
                    effect["friction_slope"],
                    stretch.first / self.sampling_rate - self.span[1],
                    float(beginning[1]),
                ),
                applied.per_lag,
            )
            reading = run.position + beginning[1]
            thread = unknowns.effects[sorted(THREAD)]
            if thread.any():
                given = self.block_step(unknowns), run.screw, self.screw_turns(unknowns, number)
                reading += thread_response(*given, thread, self.block)
            if effect["drift"]:
                reading += effect["drift"] * self._times[number]
            if effect["delay"]:
                reading -= travel_in(run.position, effect["delay"] * self.sampling_rate)
            responses.append(run._replace(position=reading))
        return responses

    def jacobian(self, unknowns: Unknowns, responses: list[StretchResponse]) -> FloatArray:
        """Return the Jacobian of the block means of the position, shape (unknowns, blocks).

        The mean over a block of a linear model's response is the response to the input's mean,
        so the structure is simulated from block to block.
        """
        shared = self.knots.size + len(FACTORS) + len(EFFECTS)
        slopes = [self._stretch_slopes(*each, unknowns) for each in enumerate(responses)]
        if len(slopes) == 1:
            return slopes[0].T
        jacobian = np.zeros((sum(self._blocks), unknowns.as_vector().size))
        begin = 0
        for number, (of_stretch, blocks) in enumerate(zip(slopes, self._blocks, strict=True)):
            rows = slice(begin, begin + blocks)
            begin += blocks
            first = shared + len(INITIAL_CONDITION) * number
            jacobian[rows, :shared] = of_stretch[:, :shared]
            jacobian[rows, first : first + len(INITIAL_CONDITION)] = of_stretch[:, shared:]
        return jacobian.T

    def _stretch_slopes(self, number: int, run: StretchResponse, unknowns: Unknowns) -> FloatArray:
        """Return the slopes of one stretch, shape (blocks, unknowns), its own beginning's last."""
        knots, effects = self.knots.size, self.knots.size + len(FACTORS)
        first = effects + len(EFFECTS)
        count = first + len(INITIAL_CONDITION)
        start, step = self._by_blocks(unknowns.model_factors)
        bases, states = np.zeros((run.screw.size, count)), np.zeros((count, len(start)))
        begins, share = self.stretches[number].first, float(unknowns.initial_conditions[number, 0])
        times = (begins + run.sample) / self.sampling_rate
        initial = self.weights(np.array([begins / self.sampling_rate]))[:, 0]
        bases[:, :knots] = play_bases(self.knots, times, run.side, self.pitch, initial, share)
        half, moved = 0.5 * dot(initial, unknowns.gaps), np.abs(run.side)
        # The angle of the motor begins at its place in the gap.
        angle = run.motor + run.drives[DRIVES.index("gain")] - share * half
        bases[:, knots], bases[:, first] = self.pitch * (angle * moved), self.pitch * half * moved
        turns = self.cogs * self.screw_turns(unknowns, number)
        travel = self.travel_per_volt(unknowns) * moved
        bases[:, effects:first] = drive_bases(unknowns.effects, run.drives, turns, travel).T
        thread = sorted(THREAD)
        if unknowns.effects[thread].any():
            waves = thread_waves(run.screw, self.screw_turns(unknowns, number))
            bases[:, [effects + place for place in thread]] = waves
        states[first + INITIAL_CONDITION.index("q2") :] = start.T
        slopes = structure_responses(step, bases, states)
        by_structure = self._slopes_by_structure(number, run, unknowns)
        places = [knots + 1, knots + 2, effects + TOP_MASS]
        slopes[:, places[: by_structure.shape[1]]] = by_structure
        # The readings' own slope differs from the position's by what delay and drift add.
        delay, drift = (EFFECTS.index(name) for name in ("delay", "drift"))
        slope = travel_in(run.position, self.sampling_rate) - unknowns.effects[drift]
        slopes[:, effects + delay] = -block_means(slope, self.block)
        middles = np.arange(run.screw.size) + 0.5 - 0.5 / self.block
        slopes[:, effects + drift] = middles / self.block_rate
        slopes[:, first + INITIAL_CONDITION.index("offset")] = 1.0
        return slopes

    def _slopes_by_structure(
        self, number: int, run: StretchResponse, unknowns: Unknowns
    ) -> FloatArray:
        """Return the slopes by stiffness, damping and, of a payload, mass: (blocks, 2 or 3)."""
        factors = unknowns.model_factors
        changes = FACTOR_CHANGE * np.eye(len(MODEL_FACTORS))[1 : None if factors[-1] else 3]
        state = unknowns.initial_conditions[number, INITIAL_CONDITION.index("q2") :]
        models = [self._by_blocks(factors + change) for change in (*changes, *-changes)]
        states = np.array([product(start, state) for start, _ in models])
        bases = np.tile(self.pitch * run.screw[:, None], len(models))
        steps = np.array([step for _, step in models])
        ahead, behind = np.hsplit(structure_responses(steps, bases, states), 2)
        slopes: FloatArray = (ahead - behind) / (2 * FACTOR_CHANGE)
        return slopes

    def block_step(self, unknowns: Unknowns) -> FloatArray:
        """Return the structure's model from block to block, shape (4, 6)."""
        return self._by_blocks(unknowns.model_factors)[1]

    def sample_step(self, unknowns: Unknowns) -> DiscreteStructure:
        """Return the structure's model from sample to sample."""
        sample_time = 1.0 / self.sampling_rate
        return plant_step_with(self._model, unknowns.model_factors, sample_time).structure

    def screw_turns(self, unknowns: Unknowns, number: int) -> float:
        """Return how often the screw has turned when a stretch begins, from the reading there."""
        offset = float(unknowns.initial_conditions[number, INITIAL_CONDITION.index("offset")])
        return offset / (FULL_TURN * self.pitch)

    def with_cogs(self, cogs: int) -> "WindowModel":
        """Return the window of a motor with so many periods of cogging in a turn."""
        given = self._model, self.stretches, self.knots, self.sampling_rate, self.block
        return WindowModel(*given, cogs)

    def deviation_model(
        self, unknowns: Unknowns, responses: list[StretchResponse]
    ) -> DeviationModel:
        """Return the system that noise drives over the window, for a simulation of it."""
        motions = [Motion(run.fast, run.slow, run.contact) for run in responses]
        return DeviationModel(self.block_step(unknowns), 1.0 / self.block_rate, motions)

    @cached_property
    def span(self) -> tuple[float, float]:
        """Times of the first and of the newest sample [s]."""
        first, newest = self.stretches[0], self.stretches[-1]
        ends = newest.first + newest.voltage.size
        return first.first / self.sampling_rate, ends / self.sampling_rate

    @cached_property
    def samples(self) -> int:
        """Samples of a simulation."""
        return sum(stretch.voltage.size for stretch in self.stretches)

    @cached_property
    def readings_per_block(self) -> int:
        """Readings of the sensor in a block."""
        stretch = self.stretches[0]
        readings = stretch.position if stretch.readings is None else stretch.readings
        return self.block * readings.size // stretch.position.size

    @cached_property
    def motion(self) -> float:
        """Standard deviation of the measured position, in the stretch with the largest [m]."""
        return max(standard_deviation(stretch.position) for stretch in self.stretches)

    def reversals(self, responses: list[StretchResponse]) -> list[float]:
        """Return the times at which the screw began to move the other way [s]."""
        pairs = zip(self.stretches, responses, strict=True)
        return [
            (stretch.first + sample) / self.sampling_rate
            for stretch, run in pairs
            for sample in run.reversals
        ]

    def travel_per_volt(self, unknowns: Unknowns) -> float:
        """Return the speed of the screw for a volt [m/(V s)]; the motor settles in milliseconds."""
        gain = float_exponential(float(unknowns.factors[FACTORS.index("gain")]))
        return self.pitch * gain / self._model.motor.back_emf_constant

    def _by_blocks(self, factors: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the structure's model from block to block."""
        return block_model_with(self._model, factors, 1.0 / self.sampling_rate, self.block)

    def gap_at(self, gaps: FloatArray, time: float) -> float:
        """Return the gap [rad] at a time [s] for gaps at the knots, shape (knots,)."""
        return dot(self.weights(np.array([time]))[:, 0], gaps)

    def weights(self, times: FloatArray) -> FloatArray:
        """Return by how much the gap at each time depends on each knot, shape (knots, n)."""
        return knot_weights(self.knots, times)
