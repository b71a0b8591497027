"""Spinning that takes messages at intervals, so that they disturb nobody as they come."""

import math
import time
from collections.abc import Callable
from typing import Protocol

from rclpy.executors import SingleThreadedExecutor
from rclpy.signals import uninstall_signal_handlers

from bdt_msgs_py.stop_signals import StopSignals

SPIN_PERIOD = 0.005
"""Wall time [s] between two looks at what has arrived."""

IDLE_SPINS = 2
"""Looks without a message after which none is waiting."""

IDLE_TIME = 0.2
"""Wall time [s] without a message after which nothing more is on its way."""

DRAIN_TIMEOUT = 2.0
"""Wall time [s] after the end for which messages are taken at most: somebody may go on sending."""


class MessageCounter(Protocol):
    """A node that counts the messages it takes."""

    @property
    def messages(self) -> int:
        """Number of messages taken."""


def spin_at_intervals(executor: SingleThreadedExecutor, node: MessageCounter) -> None:
    """Run callbacks until a signal comes, and then those of what was sent before it.

    An executor that waits is woken by every message, twice in a control period, and on a small
    computer each time in the way of the controller. Here messages gather while nobody waits.

    Parameters
    ----------
    executor : SingleThreadedExecutor
        Executor that has the node.
    node : MessageCounter
        The node.
    """
    uninstall_signal_handlers()
    with StopSignals() as signals:
        _spin_until_idle(executor, node, lambda: signals.requested)


def spin_at_intervals_until(
    executor: SingleThreadedExecutor, node: MessageCounter, is_over: Callable[[], bool]
) -> None:
    """Run callbacks as :func:`spin_at_intervals` does, but end at once, whatever still waits.

    Parameters
    ----------
    executor : SingleThreadedExecutor
        Executor that has the node.
    node : MessageCounter
        The node.
    is_over : callable
        Tells whether to end, as a signal does.
    """
    uninstall_signal_handlers()
    with StopSignals() as signals:
        _spin_until_idle(executor, node, lambda: signals.requested or is_over(), drains=False)


def drain_messages(executor: SingleThreadedExecutor, node: MessageCounter) -> None:
    """Run callbacks until no message has come for a while.

    Parameters
    ----------
    executor : SingleThreadedExecutor
        Executor that has the node.
    node : MessageCounter
        The node.
    """
    _spin_until_idle(executor, node, lambda: True)


def _spin_until_idle(
    executor: SingleThreadedExecutor,
    node: MessageCounter,
    is_over: Callable[[], bool],
    *,
    drains: bool = True,
) -> None:
    idle_spins = 0
    quiet_at = latest = math.inf
    while (now := time.monotonic()) < min(quiet_at, latest):
        if latest == math.inf and is_over():
            if not drains:
                return
            quiet_at, latest = now + IDLE_TIME, now + DRAIN_TIMEOUT
        taken = node.messages
        executor.spin_once(timeout_sec=0.0)
        if node.messages > taken:
            idle_spins = 0
            if latest < math.inf:
                quiet_at = time.monotonic() + IDLE_TIME
            continue
        # One look proves nothing: rclpy does not wait anew in the one that ends a wait set.
        idle_spins += 1
        if idle_spins == IDLE_SPINS:
            time.sleep(SPIN_PERIOD)
            idle_spins = 0
