"""Sensor of platform 3: from its true position to the reading that everybody else gets.

A reading is the position some time ago, plus what the sensor is off there, plus white noise,
rounded to a multiple of the quantization. A dropped sample repeats the reading before it, as the
output register of a sensor does that was not written in time. There is one reading a sample: the
measurement that the controller gets is the reading in the telemetry row of the same time.
"""

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_msgs_py.quantities import quantity, validate
from bdt_plant.elementary_functions import sine_of_turns
from bdt_plant.sensor_delay import (
    DiscreteDelay,
    between_samples,
    delay_line,
    delayed,
    discretize_delay,
    recent_positions,
)

FloatArray = NDArray[np.float64]

BLOCK = 4096
"""Samples whose noise is drawn together; part of what a seed means."""


RESOLUTION = 2.0**-24
"""Step between two values of the noise, as a fraction of its rms."""


@dataclass(frozen=True)
class SensorParameters:
    """Imperfections of the position sensor; the paper has none."""

    noise: float = quantity(
        0.0,
        "m",
        "rms of the white noise of each reading",
        minimum=0.0,
        maximum=1.0,
        reconfigurable=True,
    )
    quantization: float = quantity(
        0.0, "m", "step between two readings; 0 for none", minimum=0.0, maximum=1.0
    )
    delay: float = quantity(
        0.0, "s", "age of a reading; need not be whole samples", minimum=0.0, maximum=10.0
    )
    drop_probability: float = quantity(
        0.0,
        "",
        "probability that a sample is dropped and repeats the reading before",
        minimum=0.0,
        maximum=1.0,
    )
    seed: int = quantity(
        1, "", "seed of noise and dropped samples", minimum=0, maximum=2_147_483_647
    )
    bias: float = quantity(0.0, "m", "what every reading is too large", minimum=-1.0, maximum=1.0)
    drift: float = quantity(
        0.0, "m/s", "growth of the bias from the first sample on", minimum=-1.0, maximum=1.0
    )
    periodic_error: float = quantity(
        0.0,
        "m",
        "amplitude of an error that repeats along the scale: a sine of the true position",
        minimum=0.0,
        maximum=1.0,
    )
    periodic_length: float = quantity(
        1e-3, "m", "travel after which the periodic error repeats", minimum=1e-9, maximum=1e3
    )

    def __post_init__(self) -> None:
        validate(self)

    @property
    def is_ideal(self) -> bool:
        """Whether every reading is the true position."""
        is_random = self.noise or self.drop_probability
        return not (is_random or self.quantization or self.delay or self.is_off)

    @property
    def is_off(self) -> bool:
        """Whether readings have an error that is neither noise nor rounding nor age."""
        return bool(self.bias or self.drift or self.periodic_error)


IDEAL_SENSOR = SensorParameters()
"""The paper's sensor."""


class DiscreteSensor(NamedTuple):
    """A sensor at one sampling rate, without its noise.

    Attributes
    ----------
    delay : DiscreteDelay
        Age of a reading.
    quantization : float
        Step between two readings [m]; 0 for none.
    is_odd : bool
        Whether there is a delay that is not whole samples, or any of the following errors.
    bias : float
        Error of every reading [m].
    drift : float
        Growth of the error in one sample [m].
    periodic_error : float
        Amplitude of the periodic error [m].
    periodic_length : float
        Length after which it repeats [m].
    """

    delay: DiscreteDelay
    quantization: float
    is_odd: bool
    bias: float
    drift: float
    periodic_error: float
    periodic_length: float


def discretize_sensor(parameters: SensorParameters, sampling_rate: float) -> DiscreteSensor:
    """Return a sensor for samples at `sampling_rate` [Hz]."""
    delay = discretize_delay(parameters.delay, sampling_rate)
    return DiscreteSensor(
        delay,
        float(parameters.quantization),
        parameters.is_off or delay.is_between,
        float(parameters.bias),
        parameters.drift / sampling_rate,
        float(parameters.periodic_error),
        float(parameters.periodic_length),
    )


def sensor_error(position: float, sample: int, sensor: DiscreteSensor) -> float:
    """Return what a sensor is off [m] at a true position [m] and the number of a sample."""
    error = sensor.bias + sensor.drift * sample
    if sensor.periodic_error > 0.0:
        error += sensor.periodic_error * sine_of_turns(position / sensor.periodic_length)
    return error


def seen_position(
    position: float, sample: int, recent: FloatArray, sensor: DiscreteSensor
) -> float:
    """Return what an odd sensor sees instead of a position [m].

    Parameters
    ----------
    position : float
        Position that came out of the delay line [m].
    sample : int
        Number of the sample.
    recent : ndarray, shape (3,)
        From :func:`bdt_plant.sensor_delay.recent_positions`; written.
    sensor : DiscreteSensor
        From :func:`discretize_sensor`.
    """
    seen = between_samples(position, recent, sensor.delay.weights)
    return seen + sensor_error(seen, sample, sensor)


def sensor_reading(position: float, noise: float, before: float, quantization: float) -> float:
    """Return the reading of one sample [m].

    Parameters
    ----------
    position : float
        Position that the sensor sees, with what it is off there [m].
    noise : float
        Noise of this sample [m]; NaN when it is dropped, see :func:`noise_sequence`.
    before : float
        Reading of the sample before [m].
    quantization : float
        Step between two readings [m]; 0 for none.
    """
    if math.isnan(noise):
        return before
    reading = position + noise
    if quantization > 0.0:
        return float(np.rint(reading / quantization)) * quantization
    return reading


def noise_sequence(parameters: SensorParameters, first: int, count: int) -> FloatArray:
    """Return the noise of some samples, a function of seed and sample number alone.

    Each block of samples has a range of the counter-based generator Philox to itself, so a
    sample's noise does not depend on where a simulation was begun or how it was split.

    Parameters
    ----------
    parameters : SensorParameters
        The sensor.
    first : int
        Number of the first sample, from 0.
    count : int
        Number of samples, at least 1.

    Returns
    -------
    ndarray, shape (count,)
        Noise [m]; NaN where the sample is dropped.
    """
    blocks = range(first // BLOCK, (first + count - 1) // BLOCK + 1)
    noise = np.concatenate([_noise_block(parameters, block) for block in blocks])
    begin = first - blocks.start * BLOCK
    return noise[begin : begin + count]


def _noise_block(parameters: SensorParameters, block: int) -> FloatArray:
    if not (parameters.noise or parameters.drop_probability):
        return np.zeros(BLOCK)
    # The lowest word of the counter counts the draws, the next one the blocks.
    generator = np.random.Generator(np.random.Philox(key=parameters.seed, counter=block << 64))
    # Drops are drawn first, so that the same samples are dropped with and without noise.
    dropped = generator.random(BLOCK) < parameters.drop_probability
    # The largest draws, one in 4000, hold a logarithm, whose last bits differ between C libraries.
    draws = np.rint(generator.standard_normal(BLOCK) / RESOLUTION) * RESOLUTION
    noise = parameters.noise * draws
    noise[dropped] = np.nan
    return noise


class Sensor:
    """A sensor that runs: it reads one sample after the other.

    Parameters
    ----------
    parameters : SensorParameters
        The sensor.
    sampling_rate : float
        Samples per second [Hz].

    Attributes
    ----------
    dropped : int
        Number of samples dropped so far.
    """

    def __init__(self, parameters: SensorParameters, sampling_rate: float) -> None:
        self._parameters = parameters
        self._is_ideal = parameters.is_ideal
        self._step = discretize_sensor(parameters, sampling_rate)
        self._line, self._recent = delay_line(self._step.delay), recent_positions()
        self._noise: list[float] = []
        self._sample = 0
        self._reading = 0.0
        self.dropped = 0

    def set_noise(self, noise: float) -> None:
        """Have noise of another rms [m] from the next sample on."""
        self._parameters = replace(self._parameters, noise=noise)
        self._is_ideal = self._parameters.is_ideal
        if place := self._sample % BLOCK:
            begin = self._sample - place
            self._noise = noise_sequence(self._parameters, begin, BLOCK).tolist()

    def read(self, position: float) -> float:
        """Return the reading of the next sample [m].

        Parameters
        ----------
        position : float
            True position at that sample [m].
        """
        if self._is_ideal:
            return position
        step, place = self._step, self._sample % BLOCK
        if place == 0:
            self._noise = noise_sequence(self._parameters, self._sample, BLOCK).tolist()
        noise = self._noise[place]
        self.dropped += math.isnan(noise)
        seen = delayed(self._line, self._sample, position)
        if step.is_odd:
            seen = seen_position(seen, self._sample, self._recent, step)
        self._reading = sensor_reading(seen, noise, self._reading, step.quantization)
        self._sample += 1
        return self._reading

    def read_all(self, positions: FloatArray) -> FloatArray:
        """Return the readings of the next samples [m], as :meth:`read` would one by one.

        Parameters
        ----------
        positions : ndarray, shape (n,)
            True positions at those samples [m].
        """
        if self._is_ideal:
            return positions
        return np.array([self.read(position) for position in positions.tolist()])
