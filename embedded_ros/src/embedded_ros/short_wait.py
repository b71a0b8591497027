"""Blocking for one thing, without an executor."""

from collections.abc import Iterable
from types import TracebackType
from typing import Self

from embedded_ros import cyclone
from embedded_ros.session import Session

__all__ = ["ShortWait"]


class ShortWait:
    """A wait set for the time of a ``with`` block; the shutdown of the context wakes it.

    Parameters
    ----------
    session : Session
    watched : iterable of int
        Conditions and entities that end a wait.
    """

    def __init__(self, session: Session, watched: Iterable[int]) -> None:
        self._bell = cyclone.GuardCondition(session.ref)
        self._wait_set = cyclone.WaitSet(session.ref)
        for ref in (self._bell.ref, *watched):
            self._wait_set.attach(ref)
        session.register(self)

    def interrupt(self) -> None:
        """End the wait; safe from any thread."""
        self._bell.set()

    def wait(self, nanoseconds: int) -> None:
        """Wait until something happens or the time is over."""
        self._wait_set.wait(nanoseconds)
        self._bell.clear()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        exc_type: type[BaseException] | None,
        exc_value: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._wait_set.close()
        self._bell.close()
