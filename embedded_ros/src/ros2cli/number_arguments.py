"""Numbers of the command line that argparse checks."""

from argparse import ArgumentTypeError

__all__ = ["not_negative_float", "not_negative_int", "positive_float", "positive_int"]


def _float(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise ArgumentTypeError(f"{text} is not the valid type (float)") from None


def _int(text: str) -> int:
    try:
        return int(text)
    except ValueError:
        raise ArgumentTypeError(f"{text} is not the valid type (int)") from None


def positive_float(text: str) -> float:
    """Read a number above zero."""
    value = _float(text)
    if not value > 0.0:
        raise ArgumentTypeError(f"{text} is not in the valid range (> 0.0)")
    return value


def not_negative_float(text: str) -> float:
    """Read a number that is not below zero."""
    value = _float(text)
    if not value >= 0.0:
        raise ArgumentTypeError(f"Value {text} is less than zero.")
    return value


def positive_int(text: str) -> int:
    """Read an integer above zero."""
    value = _int(text)
    if value <= 0:
        raise ArgumentTypeError("value must be a positive integer")
    return value


def not_negative_int(text: str) -> int:
    """Read an integer that is not below zero."""
    value = _int(text)
    if value < 0:
        raise ArgumentTypeError(f"Value {text} is less than zero.")
    return value
