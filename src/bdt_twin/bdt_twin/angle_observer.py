"""Angles on both sides of the backlash from voltage and position (eqs 10 and 11), as a stream."""

import math
from fractions import Fraction
from operator import mul
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_plant.matrix_exponential import matrix_exponential
from bdt_plant.motor import discretize_motor
from bdt_plant.plant import PlantModel
from bdt_plant.structure import structure_state_space
from bdt_twin.iir_filters import AT_REST, coefficients, compiled_filters

FractionArray = NDArray[np.object_]
Filter = tuple[NDArray[np.float64], NDArray[np.float64]]


class Angles(NamedTuple):
    """Estimated angles [rad] of the same samples: motor theta_m, lead screw theta_d."""

    theta_m: NDArray[np.float64]
    theta_d: NDArray[np.float64]


def motor_filter(model: PlantModel, sample_time: float) -> Filter:
    """Return G1(z) of eq. 10: eq. 2 with a zero-order hold, from voltage to motor angle.

    Parameters
    ----------
    model : PlantModel
        Constants of the mechanism.
    sample_time : float
        Sample time [s].

    Returns
    -------
    numerator, denominator : ndarray
        Coefficients of falling powers of z.
    """
    current, speed, angle = discretize_motor(model.motor, sample_time)
    a = _exact(np.array([(*current[:2], 0.0), (*speed[:2], 0.0), (*angle[:2], 1.0)]))
    b = _exact(np.array([current[2:], speed[2:], angle[2:]]))
    angle_of_state = np.array([[0, 0, 1]])
    denominator = _characteristic_polynomial(a)
    numerator = _characteristic_polynomial(a - b @ angle_of_state) - denominator
    return _rounded(numerator), _rounded(denominator)


def structure_filter(model: PlantModel, sample_time: float) -> Filter:
    """Return G2(z) of eq. 11: eq. 3 made discrete by impulse invariance, from d to q3.

    The impulse response of eq. 3 begins at zero, so the pole excess is one, and the remaining
    zeros lie inside the unit circle: the inverse is stable.

    Returns
    -------
    numerator, denominator : ndarray
        Coefficients of falling powers of z; the first coefficient of the numerator is zero.
    """
    state_matrix, input_matrix = structure_state_space(model.structure)
    one_sample = _exact(matrix_exponential(state_matrix * sample_time))
    a, b = _exact(state_matrix), _exact(input_matrix)
    # A unit impulse of d is a position impulse plus a velocity doublet; the latter is a b_v.
    state, response = b[:, 0] + a @ b[:, 1], [Fraction(0)]
    for _ in range(4):
        state = one_sample @ state
        response.append(Fraction(sample_time) * state[2])
    denominator = _characteristic_polynomial(one_sample)
    numerator = [sum(map(mul, response, denominator[n::-1])) for n in range(4)]
    return _rounded(np.array(numerator)), _rounded(denominator)


def _exact(numbers: NDArray[np.float64]) -> FractionArray:
    """Return the same numbers as fractions, with which polynomials lose no digit."""
    fractions: FractionArray = np.vectorize(Fraction, otypes=[object])(numbers)
    return fractions


def _rounded(fractions: FractionArray) -> NDArray[np.float64]:
    return fractions.astype(np.float64)


def _characteristic_polynomial(matrix: FractionArray) -> FractionArray:
    """Return det(z - matrix) as coefficients of falling powers of z, by Faddeev and LeVerrier."""
    identity, product, found = np.eye(len(matrix), dtype=int), matrix, [Fraction(1)]
    for order in range(1, len(matrix) + 1):
        found.append(-np.trace(product) / order)
        product = matrix @ (product + found[-1] * identity)
    return np.array(found)


class AngleObserver:
    """Streaming form of eqs 10 and 11: batches of any length give the same angles.

    Parameters
    ----------
    model : PlantModel
        Constants of the mechanism.
    sample_time : float
        Sample time [s].
    delay : int
        Delay N [samples] of both filters, at least the pole excess of G2(z), which is one.
        Output sample n belongs to input sample n - N.

    Raises
    ------
    ValueError
        If `delay` is less than one, or the structure has so little damping that the sampled
        inverse is unstable.
    """

    def __init__(self, model: PlantModel, sample_time: float, delay: int) -> None:
        if delay < 1:
            raise ValueError(f"delay = {delay} samples: must be 1 or more for a causal inverse")
        self.delay = delay
        self._pitch = float(model.lead_screw.pitch)
        motor = motor_filter(model, sample_time)
        numerator, denominator = structure_filter(model, sample_time)
        # Dividing by the numerator without its leading zero advances by one sample.
        inverse = denominator, numerator[1:]
        zeros = np.roots(inverse[1])
        if np.abs(zeros).max() >= 1.0:
            raise ValueError(
                f"structure.damping = {model.structure.damping!r} N s/m: must be larger, or the "
                f"inverse of eq. 11 is unstable (zero at {np.abs(zeros).max():.3g})"
            )
        self._motor, self._inverse = coefficients(*motor), coefficients(*inverse)
        self._filter = compiled_filters()
        self.restart()

    @property
    def settling(self) -> int:
        """Samples until the filters have forgotten an unknown beginning, to one part in 1e9.

        The motor's integrator never forgets, but its offset is the same for both directions.
        """
        poles = np.concatenate([np.roots(below) for _, below in (self._motor, self._inverse)])
        sizes = np.abs(poles)
        slowest = sizes[sizes < 1.0 - 1e-9].max()
        return math.ceil(math.log(1e-9) / math.log(slowest)) + self.delay

    def restart(self) -> None:
        """Forget all samples; the mechanism is taken to be at rest before the next one."""
        self._memory = AT_REST
        self._voltages = np.zeros(self.delay)
        self._rest_position: float | None = None

    def update(self, voltage: NDArray[np.float64], position: NDArray[np.float64]) -> Angles:
        """Return the angles of the next batch.

        Parameters
        ----------
        voltage, position : ndarray, shape (n,)
            Motor voltage u [V] and position q3 of platform 3 [m].

        Returns
        -------
        Angles
            Arrays of shape (n,), delayed by ``delay`` samples. Offsets are those of a motor that
            starts at the angle zero.
        """
        if not position.size:
            return Angles(np.empty(0), np.empty(0))
        if self._rest_position is None:
            self._rest_position = float(position[0])
            # The inverse advances by one sample: one less than the delay.
            self._positions = np.full(self.delay - 1, self._rest_position)
        voltages = np.concatenate([self._voltages, voltage])
        positions = np.concatenate([self._positions, position])
        self._voltages = voltages[voltage.size :]
        self._positions = positions[position.size :]
        angles = Angles(np.empty(voltage.size), np.empty(position.size))
        self._memory = self._filter(
            voltages[: voltage.size],
            positions[: position.size],
            self._rest_position,
            self._pitch,
            self._motor,
            self._inverse,
            self._memory,
            *angles,
        )
        return angles
