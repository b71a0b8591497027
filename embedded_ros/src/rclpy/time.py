"""Points in time."""

from embedded_ros.public_names import shown_in
from embedded_ros.time_point import Time

__all__ = ["Time"]

shown_in(__name__, Time)
