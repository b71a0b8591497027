"""Waiting until DDS endpoints have found their peers."""

import time
from collections.abc import Callable, Sequence
from typing import Final

from embedded_ros import cyclone
from embedded_ros.endpoints import Reader, Writer
from embedded_ros.session import Session

__all__ = ["wait_until_matched"]

_PUBLICATION_MATCHED: Final = 1 << 11
_SUBSCRIPTION_MATCHED: Final = 1 << 12
# Matching is told of at once; this only bounds the damage of a status that another wait consumed.
_LONGEST_WAIT_NS: Final = 1_000_000_000


class _Interruption:
    """Ends a wait when the context is shut down."""

    def __init__(self, session: Session) -> None:
        self.condition = cyclone.GuardCondition(session.ref)

    def interrupt(self) -> None:
        self.condition.set()


def wait_until_matched(
    session: Session,
    endpoints: Sequence[Writer | Reader],
    is_matched: Callable[[], bool],
    deadline: float | None,
) -> None:
    """Wait until `is_matched`, the deadline or the shutdown of the context.

    Parameters
    ----------
    session : Session
    endpoints : sequence of Writer or Reader
        Their matches are what `is_matched` looks at.
    is_matched : callable
    deadline : float or None
        On :func:`time.monotonic`; None: for ever.
    """
    if is_matched():
        return
    interruption = _Interruption(session)
    session.register(interruption)
    wait_set = cyclone.WaitSet(session.ref)
    try:
        wait_set.attach(interruption.condition.ref)
        for endpoint in endpoints:
            cyclone.set_status_mask(endpoint.ref, _mask(endpoint))
            wait_set.attach(endpoint.ref)
        while session.valid and not is_matched():
            left = _LONGEST_WAIT_NS
            if deadline is not None:
                left = min(left, int((deadline - time.monotonic()) * 1e9))
                if left <= 0:
                    return
            wait_set.wait(left)
            interruption.condition.clear()
            for endpoint in endpoints:
                cyclone.take_status(endpoint.ref, _mask(endpoint))
    finally:
        wait_set.close()
        interruption.condition.close()


def _mask(endpoint: Writer | Reader) -> int:
    return _PUBLICATION_MATCHED if isinstance(endpoint, Writer) else _SUBSCRIPTION_MATCHED
