"""How programs of this project end, known to those without ROS, too."""

FAILED = 1
"""The loop, a node or a claim failed."""

BAD_INPUT = 2
"""The user's input cannot be used; one line says why."""


class LoopError(RuntimeError):
    """The control loop cannot go on, for example because another node is gone."""
