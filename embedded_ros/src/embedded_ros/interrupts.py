"""Signals and blocking waits.

A wait in Cyclone DDS does not notice signals, and Python runs signal handlers in the main thread
only, between two bytecodes. So the interpreter's wake-up descriptor leads to a thread that
interrupts all waits: the main thread comes out of its wait and Python runs the handler there,
``KeyboardInterrupt`` included. As in rclpy, the thread shuts the contexts down first if the
handlers of rclpy are installed for the signal.
"""

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
_listener: "_Listener | None" = None
#: By the descriptor that signals still lead to: those that a thread other than main has stopped.
_abandoned: "dict[int, _Listener]" = {}
_STOP = b"\0"


def watch(session: Session) -> None:
    """Interrupt this session's waits when a signal comes."""
    global _listener
    with _lock:
        _sessions.add(session)
        if _listener is None and threading.current_thread() is threading.main_thread():
            _listener = _Listener()


def unwatch(session: Session) -> None:
    """Undo :func:`watch`; after the last one the thread ends."""
    global _listener
    with _lock:
        _sessions.discard(session)
        if _sessions or _listener is None:
            return
        listener, _listener = _listener, None
    listener.stop()


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


class _Listener:
    """A thread that hears of signals through a pipe of its own.

    What came before it was there, or comes to it after its end, does not concern the sessions that
    there are by then. Made in the main thread: others cannot move the wake-up descriptor.
    """

    def __init__(self) -> None:
        self._reading, self._writing = os.pipe()
        os.set_blocking(self._writing, False)
        previous = signal.set_wakeup_fd(self._writing, warn_on_full_buffer=False)
        abandoned = _abandoned.pop(previous, None)
        self._previous = previous if abandoned is None else abandoned._release()
        self._thread = threading.Thread(target=self._listen, name="rclpy signals", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """End the thread, and give the wake-up descriptor back if this is the main thread."""
        in_main = threading.current_thread() is threading.main_thread()
        if in_main:
            signal.set_wakeup_fd(self._previous)
        else:
            _abandoned[self._writing] = self
        os.write(self._writing, _STOP)
        # Not if a garbage collection in the thread itself dropped the last context.
        if self._thread is not threading.current_thread():
            self._thread.join()
        if in_main:
            self._release()

    def _release(self) -> int:
        """Close the pipe; return the wake-up descriptor from before."""
        os.close(self._writing)
        os.close(self._reading)
        return self._previous

    def _listen(self) -> None:
        while _STOP not in (data := os.read(self._reading, 64)):
            for number in data:
                self._handle(number)

    def _handle(self, number: int) -> None:
        with _lock:
            sessions = list(_sessions) if _listener is self else []
            shut_down = number in _installed
        for session in sessions:
            if shut_down:
                session.invalidate()
            else:
                session.interrupt()
