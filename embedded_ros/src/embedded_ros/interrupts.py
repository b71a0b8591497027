"""Signals and blocking waits.

A wait in Cyclone DDS does not notice signals, and Python runs signal handlers in the main thread
only, between two bytecodes. So the interpreter's wake-up descriptor leads to a thread that
interrupts all waits: the main thread comes out of its wait and Python runs the handler there,
``KeyboardInterrupt`` included. As in rclpy, the thread shuts the contexts down first if the
handlers of rclpy are installed for the signal.
"""

import contextlib
import os
import signal
import threading
import weakref
from types import FrameType
from typing import Any

from embedded_ros.session import Session

__all__ = ["install", "installed", "uninstall", "unwatch", "watch"]

_lock = threading.RLock()
_sessions: weakref.WeakSet[Session] = weakref.WeakSet()
_installed: set[int] = set()
_replaced: dict[int, Any] = {}
#: Reading and writing end of a pipe.
_channel: tuple[int, int] | None = None
_previous_descriptor = -1
_thread: threading.Thread | None = None
_STOP = b"\0"


def watch(session: Session) -> None:
    """Interrupt this session's waits when a signal comes."""
    with _lock:
        _sessions.add(session)
    _start()


def unwatch(session: Session) -> None:
    """Undo :func:`watch`; after the last one the thread ends."""
    with _lock:
        _sessions.discard(session)
        if not _sessions:
            _stop()


def install(signals: set[int]) -> None:
    """Have these signals shut all contexts down."""
    with _lock:
        _installed.update(signals)
    if threading.current_thread() is not threading.main_thread():
        return
    for number in signals:
        # With the default action no byte would arrive: the process would just die. A shell without
        # job control has background programs ignore SIGINT; rclpy's handlers replace that, too.
        if signal.getsignal(number) in (signal.SIG_DFL, signal.SIG_IGN):
            _replaced[number] = signal.getsignal(number)
            signal.signal(number, _ignore)


def uninstall() -> None:
    """Give the signals back their meaning from before :func:`install`."""
    with _lock:
        _installed.clear()
    if threading.current_thread() is threading.main_thread():
        for number, handler in _replaced.items():
            if signal.getsignal(number) is _ignore:
                signal.signal(number, handler)
        _replaced.clear()


def installed() -> set[int]:
    """Signals that shut the contexts down."""
    return set(_installed)


def _ignore(_number: int, _frame: FrameType | None) -> None:
    """Handle a signal: the thread does it."""


def _start() -> None:
    global _channel, _previous_descriptor, _thread
    with _lock:
        if _thread is not None or threading.current_thread() is not threading.main_thread():
            return
        if _channel is None:
            _channel = os.pipe()
            os.set_blocking(_channel[1], False)
        _previous_descriptor = signal.set_wakeup_fd(_channel[1], warn_on_full_buffer=False)
        _thread = threading.Thread(
            target=_listen, args=(_channel[0],), name="rclpy signals", daemon=True
        )
        _thread.start()


def _stop() -> None:
    global _thread
    thread = _thread
    if thread is None or _channel is None:
        return
    _thread = None
    if threading.current_thread() is threading.main_thread():
        signal.set_wakeup_fd(_previous_descriptor)
    # The pipe stays open: another thread cannot take the descriptor back from the interpreter.
    with contextlib.suppress(OSError):
        os.write(_channel[1], _STOP)
    if thread is not threading.current_thread():
        # It may wait for the lock to handle a last signal; nothing is left for it to do then.
        thread.join(timeout=0.1)


def _listen(channel: int) -> None:
    while data := os.read(channel, 64):
        for number in data:
            if number == _STOP[0]:
                return
            _handle(number)


def _handle(number: int) -> None:
    with _lock:
        sessions = list(_sessions)
        shut_down = number in _installed
    for session in sessions:
        if shut_down:
            session.invalidate()
        else:
            session.interrupt()
