"""Sensor of platform 3: from its true position to the reading that everybody else gets.

A reading is the position some samples ago, plus white noise, rounded to a multiple of the
quantization. A dropped sample repeats the reading before it, as the output register of a sensor
does that was not written in time. There is one reading a sample: the measurement that the
controller gets is the reading in the telemetry row of the same time.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bdt_msgs_py.quantities import quantity, validate

FloatArray = NDArray[np.float64]

BLOCK = 4096
"""Samples whose noise is drawn together; part of what a seed means."""


RESOLUTION = 2.0**-24
"""Step between two values of the noise, as a fraction of its rms."""


@dataclass(frozen=True)
class SensorParameters:
    """Imperfections of the position sensor; the paper has none."""

    noise: float = quantity(
        0.0, "m", "rms of the white noise of each reading", minimum=0.0, maximum=1.0
    )
    quantization: float = quantity(
        0.0, "m", "step between two readings; 0 for none", minimum=0.0, maximum=1.0
    )
    delay: float = quantity(
        0.0, "s", "age of a reading, rounded to whole samples", minimum=0.0, maximum=10.0
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

    def __post_init__(self) -> None:
        validate(self)

    @property
    def is_ideal(self) -> bool:
        """Whether every reading is the true position."""
        return not (self.noise or self.quantization or self.delay or self.drop_probability)


IDEAL_SENSOR = SensorParameters()
"""The paper's sensor."""


def delay_line(parameters: SensorParameters, sampling_rate: float) -> FloatArray:
    """Return what a sensor remembers before its first sample: the platform at rest at zero.

    Parameters
    ----------
    parameters : SensorParameters
        The sensor.
    sampling_rate : float
        Samples per second [Hz].

    Returns
    -------
    ndarray, shape (samples of delay,)
        Positions not yet read [m]; see :func:`delayed`.
    """
    return np.zeros(round(parameters.delay * sampling_rate))


def delayed(line: FloatArray, sample: int, position: float) -> float:
    """Put a position into the delay line and return the one that comes out of it [m].

    Parameters
    ----------
    line : ndarray, shape (samples of delay,)
        From :func:`delay_line`; written.
    sample : int
        Number of the sample, one more than in the call before.
    position : float
        True position at that sample [m].
    """
    if line.size == 0:
        return position
    place = sample % line.size
    before = float(line[place])
    line[place] = position
    return before


def sensor_reading(position: float, noise: float, before: float, quantization: float) -> float:
    """Return the reading of one sample [m].

    Parameters
    ----------
    position : float
        True position, from :func:`delayed` [m].
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
        self._line = delay_line(parameters, sampling_rate)
        self._noise: list[float] = []
        self._sample = 0
        self._reading = 0.0
        self.dropped = 0

    def read(self, position: float) -> float:
        """Return the reading of the next sample [m].

        Parameters
        ----------
        position : float
            True position at that sample [m].
        """
        if self._is_ideal:
            return position
        place = self._sample % BLOCK
        if place == 0:
            self._noise = noise_sequence(self._parameters, self._sample, BLOCK).tolist()
        noise = self._noise[place]
        self.dropped += math.isnan(noise)
        before = delayed(self._line, self._sample, position)
        self._reading = sensor_reading(before, noise, self._reading, self._parameters.quantization)
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
