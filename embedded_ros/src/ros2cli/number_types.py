"""Numbers of the command line: which ones an option takes."""

import argparse
import math
from dataclasses import dataclass

__all__ = [
    "COUNT",
    "FACTOR",
    "FREQUENCY",
    "INTEGER",
    "POSITIVE_COUNT",
    "POSITIVE_SECONDS",
    "SECONDS",
    "SECONDS_OR_ALL",
    "Number",
]


@dataclass(frozen=True)
class Number:
    """A kind of number; argparse calls it with what was typed.

    Attributes
    ----------
    of : {int, float}
    low, high : float
        What is allowed, ends included. Infinity and NaN never are.
    """

    of: type[int] | type[float]
    low: float = -math.inf
    high: float = math.inf

    def __call__(self, text: str) -> int | float:
        """Read a number.

        Raises
        ------
        argparse.ArgumentTypeError
            If it is none, or out of bounds.
        """
        try:
            number = self.of(text)
        except ValueError:
            number = math.nan
        if not math.isfinite(number):
            noun = "an integer" if self.of is int else "a number"
            raise argparse.ArgumentTypeError(f"must be {noun}, not '{text}'")
        if self.low <= number <= self.high:
            return number
        if number > self.high:
            bound = f"at most {self.high:.10g}"
        else:
            bound = "above 0" if number <= 0 < self.low else f"at least {self.low:.10g}"
        raise argparse.ArgumentTypeError(f"must be {bound}, not '{text}'")


# A year is for ever, and what is shorter than a nanosecond is no time that a clock can tell.
_YEAR_S = 365 * 86400.0
_TICK_S = 1e-9
_INT32_MAX = 2**31 - 1

INTEGER = Number(int)
COUNT = Number(int, 0, _INT32_MAX)
POSITIVE_COUNT = Number(int, 1, _INT32_MAX)
FACTOR = Number(float, _TICK_S, 1 / _TICK_S)
FREQUENCY = Number(float, 1 / _YEAR_S, 1 / _TICK_S)
SECONDS = Number(float, 0.0, _YEAR_S)
POSITIVE_SECONDS = Number(float, _TICK_S, _YEAR_S)
SECONDS_OR_ALL = Number(float, high=_YEAR_S)
