"""Points in time."""

from embedded_ros.public_names import also_here, shown_in
from embedded_ros.time_point import Time

__all__ = ["Time"]

__getattr__ = also_here(
    __name__,
    {
        "rclpy.clock_type": "ClockType",
        "rclpy.constants": "S_TO_NS",
        "rclpy.duration": "Duration",
    },
)
shown_in(__name__, Time)
