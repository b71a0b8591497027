"""Waiting until DDS endpoints have found their peers."""

from collections.abc import Callable, Sequence
from typing import Final

from embedded_ros import cyclone
from embedded_ros.deadline import Deadline
from embedded_ros.endpoints import Reader, Writer
from embedded_ros.session import Session
from embedded_ros.short_wait import ShortWait

__all__ = ["wait_until_matched"]

_PUBLICATION_MATCHED: Final = 1 << 11
_SUBSCRIPTION_MATCHED: Final = 1 << 12
# Matching is told of at once; this only bounds the damage of a status that another wait consumed.
_LONGEST_WAIT_NS: Final = 1_000_000_000


def wait_until_matched(
    session: Session,
    endpoints: Sequence[Writer | Reader],
    is_matched: Callable[[], bool],
    deadline: Deadline,
) -> None:
    """Wait until `is_matched`, the deadline or the shutdown of the context.

    Parameters
    ----------
    session : Session
    endpoints : sequence of Writer or Reader
        Their matches are what `is_matched` looks at.
    is_matched : callable
    deadline : Deadline
    """
    if is_matched():
        return
    for endpoint in endpoints:
        cyclone.set_status_mask(endpoint.ref, _mask(endpoint))
    with ShortWait(session, [endpoint.ref for endpoint in endpoints]) as waiting:
        while session.valid and not is_matched() and not deadline.is_over():
            waiting.wait(min(_LONGEST_WAIT_NS, deadline.nanoseconds_left()))
            for endpoint in endpoints:
                cyclone.take_status(endpoint.ref, _mask(endpoint))


def _mask(endpoint: Writer | Reader) -> int:
    return _PUBLICATION_MATCHED if isinstance(endpoint, Writer) else _SUBSCRIPTION_MATCHED
