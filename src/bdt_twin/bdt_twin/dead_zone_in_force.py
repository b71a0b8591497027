"""Who set the controller's dead zone last: its parameter service does not say who calls it."""

from collections import deque
from dataclasses import dataclass, field

REQUESTS = 8
"""Own requests that are remembered: an event may come after the request that follows it."""


@dataclass
class DeadZoneInForce:
    """The controller's dead zone as its parameter events tell.

    Attributes
    ----------
    tolerance : float or None
        Value in force [m]; None before the first event.
    set_by : str
        ``twin``, ``somebody else``, ``start-up of the controller``, ``before the twin came``, or
        ``unknown``.
    """

    tolerance: float | None = None
    set_by: str = "unknown"
    _requested: deque[float] = field(default_factory=lambda: deque(maxlen=REQUESTS))

    def request(self, tolerance: float) -> None:
        """Note that the twin asks for a tolerance [m]."""
        self._requested.append(tolerance)

    def adopt(self, tolerance: float) -> None:
        """Note that a controller that was there before the twin has a tolerance [m]."""
        self.tolerance, self.set_by = tolerance, "before the twin came"

    def note(self, tolerance: float, *, is_new: bool) -> bool:
        """Take an event of the controller.

        Parameters
        ----------
        tolerance : float
            Value from now on [m].
        is_new : bool
            Whether the controller has just declared the parameter.

        Returns
        -------
        bool
            Whether somebody else has set it.
        """
        self.tolerance = tolerance
        if is_new:
            self.set_by = "start-up of the controller"
        else:
            self.set_by = "twin" if tolerance in self._requested else "somebody else"
        return self.set_by == "somebody else"
