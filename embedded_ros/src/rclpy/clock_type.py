"""Kinds of clocks."""

from embedded_ros.public_names import shown_in
from embedded_ros.time_point import ClockType

__all__ = ["ClockType"]

shown_in(__name__, ClockType)
