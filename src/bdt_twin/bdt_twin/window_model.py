"""Position over a window as a function of what is unknown about the mechanism, and its Jacobian."""

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from bdt_plant.elementary_functions import FULL_TURN, exponential
from bdt_plant.plant import PlantModel
from bdt_plant.structure import DiscreteStructure, StructureState
from bdt_twin.effect_slopes import add_drive_slopes
from bdt_twin.fixed_order import dot, product, standard_deviation
from bdt_twin.forward_model import (
    SlowMotion,
    StretchResponse,
    initial_state,
    simulate_stretch,
    simulate_structure,
)
from bdt_twin.gap_samples import GapSamples
from bdt_twin.innovations import DeviationModel, Motion
from bdt_twin.machine_knowledge import EFFECTS
from bdt_twin.model_factors import FACTORS, block_model_with, plant_step_with
from bdt_twin.resisted_model import resisted_plant_with, with_cogs
from bdt_twin.stretch import LEAD, Stretch
from bdt_twin.unknowns import INITIAL_CONDITION, Unknowns
from bdt_twin.window_loop import DRIVES

FloatArray = NDArray[np.float64]

SLOW_VOLTAGE = 0.5
"""Voltage for which the motor turns slowly [V]: friction that depends on speed is felt there."""

STANDING_SHARE = 0.3
"""Share of the friction's voltage with which a motor that stands still may yet turn."""

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
    """

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
        return WindowModel(self._model, stretches, self.knots, rate, block, self.cogs)

    def simulate(self, unknowns: Unknowns) -> list[StretchResponse]:
        """Simulate each stretch."""
        effect = dict(zip(EFFECTS, unknowns.effects.tolist(), strict=True))
        friction, offset = effect["friction_voltage"], effect["voltage_offset"]
        step = resisted_plant_with(
            self._model, unknowns.factors, unknowns.effects, 1.0 / self.sampling_rate
        )
        gain = float(exponential(unknowns.factors[FACTORS.index("gain")]))
        back_emf = self._model.motor.back_emf_constant / gain
        responses = []
        slow = SlowMotion(SLOW_VOLTAGE / back_emf, STANDING_SHARE * friction, back_emf)
        for number, (stretch, beginning) in enumerate(
            zip(self.stretches, unknowns.initial_conditions, strict=True)
        ):
            gaps = self._gaps[number].at(unknowns.gaps)
            state = initial_state(
                StructureState(*beginning[2:].tolist()),
                0.5 * float(beginning[0]) * float(gaps[0]),
                np.append(stretch.before, stretch.voltage[0]) + offset,
                back_emf,
                step.plant,
            )
            turns = self.cogs * self.screw_turns(unknowns, number)
            run = simulate_stretch(
                with_cogs(step, self.cogs, turns, unknowns.effects),
                state,
                stretch.voltage + offset,
                gaps,
                self.block,
                1.0 / self.sampling_rate,
                slow,
            )
            reading = run.position + beginning[1]
            if effect["drift"]:
                reading += effect["drift"] * self._times[number]
            if effect["delay"]:
                reading -= self._slope(run.position, effect["delay"])
            responses.append(run._replace(position=reading))
        return responses

    def _slope(self, position: FloatArray, duration: float = 1.0) -> FloatArray:
        """Return how far a position moves at its samples' velocities in some time [s]."""
        # What numpy.gradient gives, which takes more than twice as long.
        slope, samples = np.empty(position.size), duration * self.sampling_rate
        np.subtract(position[2:], position[:-2], out=slope[1:-1])
        slope[1:-1] *= 0.5 * samples
        slope[0] = samples * (position[1] - position[0])
        slope[-1] = samples * (position[-1] - position[-2])
        return slope

    def jacobian(self, unknowns: Unknowns, responses: list[StretchResponse]) -> FloatArray:
        """Return the Jacobian of the block means of the position, shape (unknowns, blocks).

        The mean over a block of a linear model's response is the response to the input's mean,
        so the structure is simulated from block to block.
        """
        knots, count = self.knots.size, sum(self._blocks)
        jacobian = np.zeros((unknowns.as_vector().size, count))
        start = 0
        for number, (run, blocks) in enumerate(zip(responses, self._blocks, strict=True)):
            columns = slice(start, start + blocks)
            start += blocks
            first = knots + len(FACTORS) + len(EFFECTS) + len(INITIAL_CONDITION) * number
            self._add_play(jacobian[:, columns], first, number, unknowns, run)
            self._add_structure(jacobian[:, columns], first, number, unknowns, run)
            effects = knots + len(FACTORS)
            rows = slice(effects, effects + len(EFFECTS))
            self._add_effects(jacobian[rows, columns], number, unknowns, run)
        return jacobian

    def _add_effects(
        self, jacobian: FloatArray, number: int, unknowns: Unknowns, run: StretchResponse
    ) -> None:
        """Add the rows of the machine's effects."""
        _, step = self._by_blocks(unknowns.factors)
        turns = self.cogs * self.screw_turns(unknowns, number)
        per_volt = self.travel_per_volt(unknowns)
        moved = np.abs(run.side)
        add_drive_slopes(jacobian, unknowns.effects, run.drives, turns, per_volt * moved, step)
        # The readings' own slope differs from the position's by what delay and drift add.
        slope = self._slope(run.position) - unknowns.effects[EFFECTS.index("drift")]
        jacobian[EFFECTS.index("delay")] = -slope.reshape(-1, self.block).mean(axis=1)
        blocks = np.arange(run.side.size)
        jacobian[EFFECTS.index("drift")] = (blocks + 0.5 - 0.5 / self.block) / self.block_rate

    def block_step(self, unknowns: Unknowns) -> DiscreteStructure:
        """Return the structure's model from block to block."""
        return self._by_blocks(unknowns.factors)[1]

    def sample_step(self, unknowns: Unknowns) -> DiscreteStructure:
        """Return the structure's model from sample to sample."""
        rate = self.sampling_rate
        return plant_step_with(self._model, unknowns.factors, 1.0 / rate).structure

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
        step = self.block_step(unknowns)
        return DeviationModel(step, 1.0 / self.block_rate, motions)

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
        gain = float(exponential(unknowns.factors[FACTORS.index("gain")]))
        return self.pitch * gain / self._model.motor.back_emf_constant

    def _add_play(
        self,
        jacobian: FloatArray,
        first: int,
        number: int,
        unknowns: Unknowns,
        run: StretchResponse,
    ) -> None:
        """Add the rows that act through the angle of the screw: gap, gain, first contact."""
        _, step = self._by_blocks(unknowns.factors)
        base_of, at_rest = self.pitch, StructureState(0.0, 0.0, 0.0, 0.0)
        moved = np.abs(run.side)
        begins = self.stretches[number].first
        share = float(unknowns.initial_conditions[number, 0])
        initial = self.weights(np.array([begins / self.sampling_rate]))[:, 0]
        weights = self.weights((begins + run.sample) / self.sampling_rate)
        for knot in range(self.knots.size):
            acts = moved if initial[knot] else weights[knot]
            if not acts.any():
                continue
            # Before that the structure rests.
            begin = max(int((acts != 0.0).argmax()) - 1, 0)
            turned = 0.5 * (share * initial[knot] * moved - run.side * weights[knot])[begin:]
            jacobian[knot, begin:] = simulate_structure(step, at_rest, base_of * turned)
        gap = dot(initial, unknowns.gaps)
        # The angle of the motor begins at its place in the gap.
        turned = (run.motor + run.drives[DRIVES.index("gain")] - 0.5 * share * gap) * moved
        jacobian[self.knots.size] = simulate_structure(step, at_rest, base_of * turned)
        jacobian[first] = simulate_structure(step, at_rest, base_of * 0.5 * gap * moved)

    def _add_structure(
        self,
        jacobian: FloatArray,
        first: int,
        number: int,
        unknowns: Unknowns,
        run: StretchResponse,
    ) -> None:
        """Add the rows of the structure's constants and of its initial state."""
        knots, beginning = self.knots.size, unknowns.initial_conditions[number]
        base = self.pitch * run.screw
        for which in (1, 2):
            ends = []
            for change in (FACTOR_CHANGE, -FACTOR_CHANGE):
                factors = unknowns.factors.copy()
                factors[which] += change
                start, step = self._by_blocks(factors)
                state = StructureState(*product(start, beginning[2:]).tolist())
                ends.append(simulate_structure(step, state, base))
            jacobian[knots + which, :] = (ends[0] - ends[1]) / (2 * FACTOR_CHANGE)
        jacobian[first + 1] = 1.0
        start, step = self._by_blocks(unknowns.factors)
        nothing = np.zeros(base.size)
        for state_number, mean in enumerate(start.T):
            free = simulate_structure(step, StructureState(*mean.tolist()), nothing)
            jacobian[first + 2 + state_number] = free

    def _by_blocks(self, factors: FloatArray) -> tuple[FloatArray, DiscreteStructure]:
        """Return the structure's model from block to block."""
        return block_model_with(self._model, factors, 1.0 / self.sampling_rate, self.block)

    def gap_at(self, gaps: FloatArray, time: float) -> float:
        """Return the gap [rad] at a time [s] for gaps at the knots, shape (knots,)."""
        return dot(self.weights(np.array([time]))[:, 0], gaps)

    def weights(self, times: FloatArray) -> FloatArray:
        """Return by how much the gap at each time depends on each knot, shape (knots, n)."""
        spacing = self.knots[1] - self.knots[0]
        distance = np.abs(times[None, :] - self.knots[:, None]) / spacing
        weights: FloatArray = np.maximum(1.0 - distance, 0.0)
        return weights
