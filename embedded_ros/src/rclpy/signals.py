"""Handlers for SIGINT and SIGTERM."""

import signal
from enum import IntEnum
from typing import Final

__all__ = [
    "SignalHandlerOptions",
    "get_current_signal_handlers_options",
    "install_signal_handlers",
    "uninstall_signal_handlers",
]


class SignalHandlerOptions(IntEnum):
    """For which signals all contexts are shut down."""

    NO = 0
    SIGINT = 1
    SIGTERM = 2
    ALL = 3


_SIGNALS: Final = {
    SignalHandlerOptions.NO: set[int](),
    SignalHandlerOptions.SIGINT: {int(signal.SIGINT)},
    SignalHandlerOptions.SIGTERM: {int(signal.SIGTERM)},
    SignalHandlerOptions.ALL: {int(signal.SIGINT), int(signal.SIGTERM)},
}


def install_signal_handlers(options: SignalHandlerOptions = SignalHandlerOptions.ALL) -> None:
    """Shut all contexts down when one of the signals comes.

    The handlers that Python has go on working: SIGINT still raises ``KeyboardInterrupt``.
    """
    from embedded_ros import interrupts

    interrupts.install(_SIGNALS[SignalHandlerOptions(options)])


def get_current_signal_handlers_options() -> SignalHandlerOptions:
    """Options that are in force."""
    from embedded_ros import interrupts

    current = interrupts.installed()
    return next(option for option, signals in _SIGNALS.items() if signals == current)


def uninstall_signal_handlers() -> None:
    """Give the signals back their meaning from before."""
    from embedded_ros import interrupts

    interrupts.uninstall()
