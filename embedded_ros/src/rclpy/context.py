"""Contexts: what lies between init and shutdown."""

from __future__ import annotations

import os
import sys
import threading
import weakref
from collections.abc import Callable
from inspect import ismethod
from types import TracebackType
from typing import TYPE_CHECKING, Any

from embedded_ros.errors import RCLError, RCLInvalidROSArgsError
from embedded_ros.ros_arguments import NO_ARGUMENTS, RosArguments, parse_arguments

if TYPE_CHECKING:
    from embedded_ros.session import Session

__all__ = ["Context"]


class Context:
    """The life between init and shutdown, with a DDS participant of its own.

    A context is initialized once and cannot be used again after its shutdown. Used as a context
    manager it does both.
    """

    def __init__(self) -> None:
        # Reentrant: a callback of the shutdown may ask whether the context is ok.
        self._lock = threading.RLock()
        self._callbacks: list[Callable[[], Callable[[], Any] | None]] = []
        self._session: Session | None = None
        self._arguments: RosArguments = NO_ARGUMENTS

    @property
    def handle(self) -> Session | None:
        """What the context owns in the network; None before :meth:`init`."""
        return self._session

    def init(
        self,
        args: list[str] | None = None,
        *,
        initialize_logging: bool = True,
        domain_id: int | None = None,
    ) -> None:
        """Initialize the context.

        Parameters
        ----------
        args : list of str, optional
            Command line; ``sys.argv`` by default.
        initialize_logging : bool
            Whether to set logger levels from `args`.
        domain_id : int, optional
            ``ROS_DOMAIN_ID`` by default, or 0.
        """
        # Cyclone DDS is loaded here, so that ``import rclpy`` is quick.
        from embedded_ros import interrupts
        from embedded_ros.domain import domain_id_from
        from embedded_ros.session import Session
        from rclpy import logging

        with self._lock:
            if domain_id is not None and domain_id < 0:
                raise RuntimeError(f"Domain id ({domain_id}) should not be lower than zero.")
            if self._session is not None:
                raise RuntimeError("Context.init() must only be called once")
            try:
                arguments = parse_arguments(sys.argv if args is None else args)
            except RCLInvalidROSArgsError as error:
                raise RCLInvalidROSArgsError(f"failed to initialize rcl: {error}") from None
            chosen = (
                domain_id_from(os.environ.get("ROS_DOMAIN_ID")) if domain_id is None else domain_id
            )
            self._session = Session(chosen, arguments.enclave)
            self._arguments = arguments
            if initialize_logging:
                logging.configure(arguments)
        interrupts.watch(self._session)

    def ok(self) -> bool:
        """Tell whether the context is initialized and not shut down."""
        session = self._session
        return session is not None and session.valid

    def shutdown(self) -> None:
        """Shut down: all that spins or waits in this context returns.

        Raises
        ------
        RCLError
            If the context is shut down already.
        """
        if self._session is None:
            raise RuntimeError("Context must be initialized before it can be shutdown")
        with self._lock:
            if not self._session.valid:
                raise RCLError(
                    "failed to shutdown: rcl_shutdown already called on the given context"
                )
            self._shut_down(self._session)

    def try_shutdown(self) -> None:
        """Shut down, unless that has happened."""
        session = self._session
        if session is None:
            return
        with self._lock:
            if session.valid:
                self._shut_down(session)
            else:
                # A signal has invalidated it, which calls nobody: that is made up for here.
                self._call_back_and_leave(session)

    def _shut_down(self, session: Session) -> None:
        session.invalidate()
        self._call_back_and_leave(session)

    def _call_back_and_leave(self, session: Session) -> None:
        from embedded_ros import interrupts

        callbacks, self._callbacks = self._callbacks, []
        for reference in callbacks:
            callback = reference()
            if callback is not None:
                callback()
        interrupts.unwatch(session)
        session.close_if_unused()

    def on_shutdown(self, callback: Callable[[], Any]) -> None:
        """Have a function called on shutdown; at once if that has happened.

        Bound methods are held weakly.
        """
        if not callable(callback):
            raise TypeError(f"callback should be a callable, got {type(callback)}")
        with self._lock:
            if self._session is not None and not self._session.valid:
                callback()
            elif ismethod(callback):
                self._callbacks.append(weakref.WeakMethod(callback))
            else:
                self._callbacks.append(lambda: callback)

    def get_domain_id(self) -> int:
        """Domain of the context."""
        if self._session is None:
            raise RuntimeError("Context must be initialized before it can have a domain id")
        return self._session.domain_id

    def destroy(self) -> None:
        """Leave the network, whatever nodes there still are."""
        if self._session is not None:
            self.try_shutdown()
            self._session.close()

    def __enter__(self) -> Context:
        self.init()
        return self

    def __exit__(
        self,
        exc_type: type[BaseException] | None,
        exc_val: BaseException | None,
        exc_tb: TracebackType | None,
    ) -> None:
        self.try_shutdown()
