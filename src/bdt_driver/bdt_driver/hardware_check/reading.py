"""Checks of reading a machine that rests."""

import numpy as np

from bdt_driver.hardware_check.check import Check, CheckSkippedError, require
from bdt_driver.hardware_check.drive_stand import DriveStand
from bdt_driver.hardware_clock import LARGEST_DRIFT

LARGEST_CALL_SHARE = 0.5
"""Share of the control period that a reading may take."""
KEPT_SHARE = 0.95
"""Share of the control periods that must have a reading."""
FINEST_SHARE = 1e-3
"""Share of the travel that noise, drift and resolution may be."""
SPIKE_SHARE = 1e-2
"""Share of the travel that a single reading may be off."""
LARGEST_CLOCK_STEP = 0.1
"""Time [s] by which the samples may be ahead of their clock or behind it."""


def _is_finite(stand: DriveStand) -> str:
    record = stand.at_rest
    bad = np.count_nonzero(~np.isfinite(record.positions) | ~np.isfinite(record.voltages))
    require(not bad, f"{bad} of {len(record.readings)} readings are no numbers")
    return "all are numbers"


def _is_in_meters(stand: DriveStand) -> str:
    low, high = np.nanmin(stand.at_rest.positions), np.nanmax(stand.at_rest.positions)
    limits = stand.limits
    require(
        limits.allow(low) and limits.allow(high),
        f"{low:g} to {high:g} m, must be {limits.lowest_position:g} to "
        f"{limits.highest_position:g} m",
    )
    return f"{low:g} m"


def _is_quick(stand: DriveStand) -> str:
    typical = float(np.median(stand.at_rest.call_times))
    allowed = LARGEST_CALL_SHARE * stand.period
    text = f"{typical * 1e3:.3g} ms of {stand.period * 1e3:.3g} ms"
    require(typical <= allowed, f"{text}, must be at most {allowed * 1e3:.3g} ms")
    return text


def _is_never_late(stand: DriveStand) -> str:
    worst, allowed = float(np.max(stand.at_rest.call_times)), stand.settings.command_timeout
    text = f"the slowest lasts {worst * 1e3:.3g} ms"
    require(worst <= allowed, f"{text}, must be at most {allowed * 1e3:.3g} ms")
    return text


def _keeps_rate(stand: DriveStand) -> str:
    record = stand.at_rest
    wanted = (record.ended[-1] - record.began[0]) / stand.period
    kept = len(record.readings) / wanted
    gaps = np.diff(record.began)
    text = f"{kept:.1%} of the periods, 99 % within {np.quantile(gaps, 0.99) * 1e3:.3g} ms"
    require(kept >= KEPT_SHARE, f"{text}; must be at least {KEPT_SHARE:.0%}")
    return text


def _has_low_noise(stand: DriveStand) -> str:
    allowed = FINEST_SHARE * stand.travel
    text = f"{stand.noise * 1e6:.3g} um rms"
    require(stand.noise <= allowed, f"{text}, must be at most {allowed * 1e6:.3g} um")
    return text


def _rests(stand: DriveStand) -> str:
    positions = stand.at_rest.positions
    part = max(len(positions) // 10, 1)
    drift = abs(float(np.median(positions[-part:]) - np.median(positions[:part])))
    allowed = max(FINEST_SHARE * stand.travel, 5.0 * stand.noise)
    text = f"{drift * 1e6:.3g} um in {stand.at_rest.ended[-1] - stand.at_rest.began[0]:.2g} s"
    require(drift <= allowed, f"{text}, must be at most {allowed * 1e6:.3g} um")
    return text


def _has_no_spikes(stand: DriveStand) -> str:
    positions = stand.at_rest.positions
    off = np.abs(positions - np.median(positions))
    allowed = max(SPIKE_SHARE * stand.travel, 8.0 * stand.noise)
    spikes = int(np.count_nonzero(off > allowed))
    require(
        not spikes,
        f"{spikes} of {len(positions)} readings are off by up to {np.max(off) * 1e6:.3g} um",
    )
    return f"the largest is off by {np.max(off) * 1e6:.3g} um"


def _tells_newest(stand: DriveStand) -> str:
    _needs_samples(stand)
    off = [
        abs(reading.position - reading.samples[-1, 1])
        for reading in stand.at_rest.readings
        if reading.samples is not None and len(reading.samples)
    ]
    worst = max(off, default=np.inf)
    require(worst <= 1e-9, f"the position is {worst:g} m from that of the newest sample")
    return "the position is that of the newest sample"


def _samples_at_rate(stand: DriveStand) -> str:
    rate = found_rate(stand)
    stated = stand.settings.sampling_rate
    text = f"{rate:.1f} Hz, {rate / stated - 1.0:+.2%}"
    require(abs(rate / stated - 1.0) <= LARGEST_DRIFT, f"{text}; must be within 0.5 %")
    return text


def _samples_without_steps(stand: DriveStand) -> str:
    rate = found_rate(stand)
    record = stand.at_rest
    ahead = record.passed_samples / rate - (np.array(record.ended) - record.began[0])
    step = float(np.ptp(ahead))
    text = f"{step * 1e3:.3g} ms at most"
    require(step <= LARGEST_CLOCK_STEP, f"{text}, must be {LARGEST_CLOCK_STEP * 1e3:g} ms")
    return text


def _loses_nothing(stand: DriveStand) -> str:
    _needs_samples(stand)
    lost = stand.at_rest.lost_samples
    require(not lost, f"{lost} of {stand.at_rest.passed_samples[-1]:.0f} samples")
    return f"none of {stand.at_rest.passed_samples[-1]:.0f}"


def found_rate(stand: DriveStand) -> float:
    """Return the rate of the samples at rest [Hz], blind to a single step of their clock.

    Raises
    ------
    CheckSkippedError
        If the drive has no samples.
    """
    _needs_samples(stand)
    record = stand.at_rest
    lag = max(len(record.readings) // 4, 1)
    passed, ended = record.passed_samples, np.array(record.ended)
    rates = (passed[lag:] - passed[:-lag]) / (ended[lag:] - ended[:-lag])
    return float(np.median(rates))


def _needs_samples(stand: DriveStand) -> None:
    if not stand.brings_samples:
        raise CheckSkippedError("the drive samples when it is read: sampling_rate is 0")


READING = (
    Check(
        "is_finite",
        _is_finite,
        "A reading that is no number is no position; after command_timeout without one the drive "
        "is faulted.",
        "Raise when the sensor has nothing to say, and look why it has not.",
    ),
    Check(
        "is_in_meters",
        _is_in_meters,
        "Beyond its travel the driver stops the machine; a wrong unit or zero looks like that.",
        "Return meters from the zero of your limits; or correct limits.lowest_position and "
        "limits.highest_position.",
        needs=("reads", "is_finite"),
    ),
    Check(
        "reads_quickly",
        _is_quick,
        "What a reading takes is missing to the controller and delays its answer.",
        "Read what has come and wait for nothing; ask less often (control_rate).",
    ),
    Check(
        "is_never_late",
        _is_never_late,
        "A call that lasts longer than command_timeout is a fault: the drive is stopped.",
        "Give the port a timeout below command_timeout; on USB look at its latency timer.",
    ),
    Check(
        "keeps_rate",
        _keeps_rate,
        "Missing periods are holes in the telemetry and steps for the controller.",
        "Free the computer, give the process priority, or lower control_rate.",
    ),
    Check(
        "has_low_noise",
        _has_low_noise,
        "Noise sets how small a gap the twin can see, and what the derivative makes of it.",
        "Look at shield, ground and filter of the sensor.",
        needs=("reads", "is_finite"),
    ),
    Check(
        "rests",
        _rests,
        "A machine that creeps without a voltage has another drive, or a sensor that drifts.",
        "Look for a voltage at the motor, and let the sensor warm up.",
        needs=("reads", "is_finite"),
    ),
    Check(
        "has_no_spikes",
        _has_no_spikes,
        "A single wrong position is a blow for the controller's derivative.",
        "Check every reading's checksum, and read both bytes of a counter at once.",
        needs=("reads", "is_finite"),
    ),
    Check(
        "tells_newest",
        _tells_newest,
        "The controller gets the position, the twin the samples; they must be one thing.",
        "Return the position of the last row.",
    ),
    Check(
        "samples_at_rate",
        _samples_at_rate,
        "Times of samples follow the stated rate; more than 0.5 % off they lose track.",
        "Set sampling_rate to what the device samples at, and count what is lost.",
    ),
    Check(
        "samples_without_steps",
        _samples_without_steps,
        "Samples that are missing and not told shift all that follow in time.",
        "Number the samples in the device and return the holes as `lost`.",
    ),
    Check(
        "loses_nothing",
        _loses_nothing,
        "Every hole ends a stretch from which the twin learns.",
        "A faster line, a larger buffer, a shorter cable; or sample less often.",
    ),
)
"""The checks, in their order."""
