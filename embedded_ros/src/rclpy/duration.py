"""Periods of time."""

from embedded_ros.duration import Duration, Infinite
from embedded_ros.public_names import shown_in

__all__ = ["Duration", "Infinite"]

shown_in(__name__, Duration)
