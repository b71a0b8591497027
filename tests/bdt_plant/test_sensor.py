"""The sensor against statistics, numpy's rounding and plain shifts."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from bdt_plant.sensor import BLOCK, Sensor, SensorParameters, noise_sequence

RATE = 5000.0
SAMPLES = 20_000
MOTION = 5e-3 * np.sin(np.arange(SAMPLES) / 300.0)


def readings(parameters, positions=MOTION, rate=RATE):
    sensor = Sensor(parameters, rate)
    return np.array([sensor.read(position) for position in positions.tolist()])


@given(st.lists(st.floats(allow_nan=False), max_size=20))
def test_the_ideal_sensor_reads_every_bit(positions):
    assert readings(SensorParameters(), np.array(positions)).tobytes() == (
        np.array(positions).tobytes()
    )


def test_noise_is_white_and_normal_with_the_rms_asked_for():
    error = readings(SensorParameters(noise=1e-6)) - MOTION
    # Bounds that a right sensor misses once in 1e5 seeds; the seed is fixed.
    assert abs(error.mean()) < 4.4e-6 / math.sqrt(SAMPLES)
    assert abs(error.std() / 1e-6 - 1.0) < 4.4 / math.sqrt(2 * SAMPLES)
    assert stats.kstest(error / 1e-6, "norm").pvalue > 1e-3
    for lag in (1, 2, 10, BLOCK):
        correlation = np.mean(error[lag:] * error[:-lag]) / 1e-12
        assert abs(correlation) < 4.4 / math.sqrt(SAMPLES - lag)


@given(st.floats(-1.0, 1.0), st.floats(1e-9, 1e-3))
def test_a_quantized_reading_is_the_nearest_multiple(position, quantization):
    (reading,) = readings(SensorParameters(quantization=quantization), np.array([position]))
    steps = reading / quantization
    assert steps == pytest.approx(round(steps), abs=1e-6)
    rounding = 4 * np.spacing(abs(position))
    assert abs(reading - position) <= 0.5 * quantization + rounding


def test_quantization_of_a_moving_platform_adds_a_twelfth_of_its_square():
    step = 1e-7
    error = readings(SensorParameters(quantization=step)) - MOTION
    assert np.abs(error).max() <= 0.5 * step * (1 + 1e-9)
    assert np.mean(error**2) == pytest.approx(step**2 / 12, rel=0.05)


@pytest.mark.parametrize(
    ("delay", "samples"), [(2e-4, 1), (0.01, 50), (6e-4, 3), (1e-14, 0), (1.0, 5000)]
)
def test_a_delay_is_that_many_samples_of_rest_and_then_the_motion(delay, samples):
    expected = np.concatenate([np.zeros(samples), MOTION])[:SAMPLES]
    np.testing.assert_array_equal(readings(SensorParameters(delay=delay)), expected)


@settings(max_examples=50)
@given(st.floats(0.0, 0.02))
def test_a_delay_between_samples_is_the_position_at_that_time(delay):
    """Against the motion itself, which is known at every instant."""
    expected = 5e-3 * np.sin((np.arange(SAMPLES) - delay * RATE) / 300.0)
    settled = math.ceil(delay * RATE) + 4
    actual = readings(SensorParameters(delay=delay))
    # 5 mm / 24 / 300^4, and what 1e-9 of a sample is.
    np.testing.assert_allclose(actual[settled:], expected[settled:], rtol=0, atol=4.5e-14)


def test_the_error_of_a_delay_between_samples_is_of_fourth_order():
    errors = []
    for rate in (500.0, 1000.0, 2000.0):
        times = np.arange(500) / rate
        read = readings(SensorParameters(delay=0.4 / rate), np.sin(30 * times), rate)
        errors.append(np.abs(read - np.sin(30 * (times - 0.4 / rate)))[4:].max())
    assert errors[0] / errors[1] == pytest.approx(16, rel=0.1)
    assert errors[1] / errors[2] == pytest.approx(16, rel=0.1)


def test_bias_drift_and_periodic_error_are_added_to_what_is_seen():
    parameters = SensorParameters(
        bias=-5e-5, drift=1.7e-7, periodic_error=5e-7, periodic_length=2e-5
    )
    times = np.arange(SAMPLES) / RATE
    expected = MOTION - 5e-5 + 1.7e-7 * times + 5e-7 * np.sin(2 * np.pi * MOTION / 2e-5)
    np.testing.assert_allclose(readings(parameters), expected, rtol=0, atol=1e-17)


def test_the_periodic_error_is_that_of_the_position_that_is_read_and_is_rounded_with_it():
    parameters = SensorParameters(
        delay=1e-3, periodic_error=1e-6, periodic_length=1e-4, quantization=1e-7
    )
    seen = np.concatenate([np.zeros(5), MOTION])[:SAMPLES]
    expected = seen + 1e-6 * np.sin(2 * np.pi * seen / 1e-4)
    assert np.abs(readings(parameters) - expected).max() <= 0.5e-7 * (1 + 1e-6)


def test_a_dropped_sample_repeats_the_reading_before():
    sensor = Sensor(SensorParameters(drop_probability=0.2, seed=5), RATE)
    ramp = np.arange(1.0, SAMPLES + 1)  # a reading tells the sample that it was taken at
    actual = np.array([sensor.read(position) for position in ramp.tolist()])
    dropped = actual != ramp
    # What is not its own sample is the one before, and the platform was at zero at first.
    np.testing.assert_array_equal(actual[dropped], np.concatenate([[0.0], actual])[:-1][dropped])
    assert sensor.dropped == np.count_nonzero(dropped)
    assert sensor.dropped / SAMPLES == pytest.approx(0.2, abs=4.4 * math.sqrt(0.16 / SAMPLES))
    # Independent drops: two in a row are as probable as the square.
    both = np.mean(dropped[1:] & dropped[:-1])
    assert both == pytest.approx(0.04, abs=4.4 * math.sqrt(0.04 / SAMPLES))


def test_a_sensor_that_drops_everything_reads_zero_for_ever():
    assert not readings(SensorParameters(drop_probability=1.0, noise=1e-6)).any()


def test_all_imperfections_together_are_delay_noise_rounding_and_holding_in_this_order():
    parameters = SensorParameters(1e-6, 1e-7, 1e-3, 0.1, 3)
    noise = noise_sequence(parameters, 0, SAMPLES)
    moved = np.concatenate([np.zeros(5), MOTION])[:SAMPLES]
    taken = ~np.isnan(noise)
    rounded = np.rint((moved + np.nan_to_num(noise)) / 1e-7) * 1e-7
    newest = np.maximum.accumulate(np.where(taken, np.arange(SAMPLES), -1))
    expected = np.where(newest >= 0, rounded[newest], 0.0)
    np.testing.assert_array_equal(readings(parameters), expected)


@settings(max_examples=50)
@given(st.integers(0, 2**31 - 1), st.integers(0, 3 * BLOCK), st.integers(1, 2 * BLOCK), st.data())
def test_the_noise_of_a_sample_does_not_depend_on_where_one_begins_or_stops(
    seed, first, count, data
):
    parameters = SensorParameters(noise=1e-6, drop_probability=0.1, seed=seed)
    split = data.draw(st.integers(1, count))
    parts = [noise_sequence(parameters, first, split)]
    if split < count:
        parts.append(noise_sequence(parameters, first + split, count - split))
    whole = noise_sequence(parameters, 0, first + count)[first:]
    assert np.concatenate(parts).tobytes() == whole.tobytes()


def test_another_seed_is_another_noise_and_the_same_seed_the_same():
    one, again, other = (
        noise_sequence(SensorParameters(noise=1.0, seed=seed), 0, SAMPLES) for seed in (1, 1, 2)
    )
    assert one.tobytes() == again.tobytes()
    assert abs(np.corrcoef(one, other)[0, 1]) < 4.4 / math.sqrt(SAMPLES)


def test_the_same_samples_are_dropped_with_and_without_noise():
    loud, quiet = (
        noise_sequence(SensorParameters(noise=noise, drop_probability=0.1), 0, SAMPLES)
        for noise in (1e-6, 0.0)
    )
    np.testing.assert_array_equal(np.isnan(loud), np.isnan(quiet))


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("noise", -1e-6),
        ("noise", math.nan),
        ("quantization", -1e-7),
        ("delay", -1.0),
        ("delay", 11.0),
        ("drop_probability", 1.1),
        ("bias", 1.1),
        ("bias", math.inf),
        ("drift", -2.0),
        ("periodic_error", -1e-7),
        ("periodic_length", 0.0),
        ("seed", -1),
        ("seed", 1.0),
    ],
)
def test_what_no_sensor_does_is_refused(field, value):
    with pytest.raises(ValueError, match=rf"^SensorParameters\.{field} = .*: must be"):
        SensorParameters(**{field: value})
