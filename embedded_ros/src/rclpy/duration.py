"""Periods of time."""

from embedded_ros.duration import Duration, Infinite
from embedded_ros.public_names import also_here, shown_in

__all__ = ["Duration", "Infinite"]

__getattr__ = also_here(__name__, {"rclpy.constants": "S_TO_NS"})
shown_in(__name__, Duration)
