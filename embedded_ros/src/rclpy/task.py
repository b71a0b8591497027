"""Futures, and tasks that an executor runs."""

from embedded_ros.futures import Future, Task
from embedded_ros.public_names import shown_in

__all__ = ["Future", "Task"]

shown_in(__name__, Future, Task)
