"""Which measurements the controller obeys: those of the time it knows, with readings it believes.

A stray message or a glitch of the sensor is one reading; a machine does not jump. A change that
stays, as after homing or a pause, is believed after a few readings that agree.
"""

from dataclasses import dataclass
from enum import Enum

from bdt_msgs_py.quantities import quantity, validate
from bdt_msgs_py.rejection import MessageRejectedError, Reason
from bdt_msgs_py.time_sequence import Step, TimeSequence

FEWEST_PERIODS = 3
"""Control periods that the tolerance of time covers at least."""


@dataclass(frozen=True)
class PlausibilitySettings:
    """What the controller believes of a measurement."""

    time_tolerance: float = quantity(
        0.1,
        "s",
        "time after the newest measurement up to which the next one is taken, 3 control periods "
        "at least; what is elsewhere has to be confirmed",
        minimum=1e-3,
        maximum=1e3,
    )
    largest_speed: float = quantity(
        0.5,
        "m/s",
        "largest plausible speed of platform 3; a reading that changed faster is not believed",
        minimum=1e-6,
        maximum=1e3,
    )
    smallest_change: float = quantity(
        2e-3,
        "m",
        "change of the reading that is always believed, however short the time",
        minimum=0.0,
        maximum=1e3,
    )
    confirmations: int = quantity(
        5,
        "",
        "measurements in a row that confirm a time or a reading that was not believed",
        minimum=2,
        maximum=1000,
    )
    largest_reference: float = quantity(
        0.05,
        "m",
        "largest position of either sign that is taken from the topic reference",
        minimum=0.0,
        maximum=1e3,
    )

    def __post_init__(self) -> None:
        validate(self)

    def check_reference(self, position: float, stamp: int, now: int) -> None:
        """Check a reference from a topic.

        Parameters
        ----------
        position : float
            Reference r [m].
        stamp : int
            Time from which it holds [ns]; what began earlier holds, too.
        now : int
            Stamp of the newest measurement [ns]; -1 before the first.

        Raises
        ------
        MessageRejectedError
            For a position beyond the travel, or a time that is still to come.
        """
        if abs(position) > self.largest_reference:
            raise MessageRejectedError(
                Reason.RANGE,
                f"reference {position:g} m: must be {-self.largest_reference:g} to "
                f"{self.largest_reference:g} m",
            )
        ahead = (stamp - now) * 1e-9
        if now >= 0 and ahead > self.time_tolerance:
            raise MessageRejectedError(
                Reason.TIME,
                f"reference from {stamp / 1e9:.9g} s on: is {ahead:.9g} s after the newest "
                f"measurement, must be {self.time_tolerance:g} s at most",
            )


class Verdict(Enum):
    """What the controller does with a measurement that it does not reject."""

    BEGIN = "begin"
    """Start anew, and answer: the first measurement, or another run."""
    ANSWER = "answer"
    REPEAT = "repeat"
    """Send the answer again: the measurement was sent twice."""


class UnbelievedReadingError(MessageRejectedError):
    """The time is right and the reading is not: it awaits an answer that must not rest on it."""


class PlausibilityCheck:
    """Judges measurements by those that were believed before.

    Parameters
    ----------
    settings : PlausibilitySettings
        What is plausible.
    control_rate : float
        Rate of measurements [Hz].
    """

    def __init__(self, settings: PlausibilitySettings, control_rate: float) -> None:
        self._settings = settings
        tolerance = max(settings.time_tolerance, FEWEST_PERIODS / control_rate)
        self._times = TimeSequence(round(tolerance * 1e9), settings.confirmations)
        self._believed: tuple[int, float] | None = None
        self._doubted: tuple[int, float] | None = None
        self._doubts = 0

    def expect_restart(self) -> None:
        """Note that simulated time has gone back: so will measurements."""
        self._times.expect_restart()

    def check(self, stamp: int, position: float, now: float) -> Verdict:
        """Judge a measurement.

        Parameters
        ----------
        stamp : int
            Its stamp [ns].
        position : float
            Its reading [m], finite.
        now : float
            Wall time [s], of any origin.

        Raises
        ------
        UnbelievedReadingError
            For a reading that the platform cannot have reached, at a time that is right.
        MessageRejectedError
            For a time that is far from the one that is known.
        """
        if self._believed is not None and self._times.continues(stamp):
            self._check_change(self._believed, stamp, position)
        step = self._times.check(stamp, now)
        if step is Step.REPEATS:
            if (stamp, position) == self._believed:
                return Verdict.REPEAT
            raise UnbelievedReadingError(
                Reason.REPEATED, f"position {position:g} m: another one of this time was answered"
            )
        self._believed, self._doubted = (stamp, position), None
        return Verdict.BEGIN if step is Step.BEGINS else Verdict.ANSWER

    def _check_change(self, believed: tuple[int, float], stamp: int, position: float) -> None:
        """Raise for a reading that is far from the believed one, until enough others agree."""
        if self._is_reachable(believed, stamp, position):
            return
        if self._doubted is None or not self._is_reachable(self._doubted, stamp, position):
            self._doubts = 1
        elif stamp > self._doubted[0]:
            self._doubts += 1
        self._doubted = stamp, position
        if self._doubts < self._settings.confirmations:
            raise UnbelievedReadingError(
                Reason.CHANGE,
                f"position {position:g} m, {(stamp - believed[0]) / 1e9:g} s after one of "
                f"{believed[1]:g} m: must not change faster than "
                f"{self._settings.largest_speed:g} m/s",
            )

    def _is_reachable(self, before: tuple[int, float], stamp: int, position: float) -> bool:
        travel = self._settings.largest_speed * (stamp - before[0]) * 1e-9
        return abs(position - before[1]) <= max(travel, self._settings.smallest_change)
