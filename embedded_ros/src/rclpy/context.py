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

from embedded_ros import log_output
from embedded_ros.argument_encoding import check_encoding
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
        #: What the command line says, for all nodes of the context.
        self.arguments: RosArguments = NO_ARGUMENTS
        self._session: Session | None = None
        # Reentrant: a callback of the shutdown may ask whether the context is ok.
        self._changing = threading.RLock()
        self._farewells: list[Callable[[], Callable[[], Any] | None]] = []

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

        Raises
        ------
        RuntimeError
            If the domain id is negative or the context was initialized before.
        RCLInvalidROSArgsError
            If a ROS argument is malformed.
        UnicodeEncodeError
            If an argument is not UTF-8.
        """
        # Cyclone DDS is loaded here, so that ``import rclpy`` is quick.
        from embedded_ros import interrupts
        from embedded_ros.domain import domain_id_from
        from embedded_ros.session import Session

        with self._changing:
            if domain_id is not None and domain_id < 0:
                raise RuntimeError(f"Domain id ({domain_id}) should not be lower than zero.")
            if self._session is not None:
                raise RuntimeError("Context.init() must only be called once")
            arguments = _parsed(sys.argv if args is None else args)
            if domain_id is None:
                domain_id = domain_id_from(os.environ.get("ROS_DOMAIN_ID"))
            session = self._session = Session(domain_id, arguments.enclave)
            self.arguments = arguments
            if initialize_logging:
                _configure_logging(arguments)
        interrupts.watch(session)

    def ok(self) -> bool:
        """Tell whether the context is initialized and not shut down."""
        return self._session is not None and self._session.valid

    def _initialized(self, to: str) -> Session:
        if self._session is None:
            raise RuntimeError(f"Context must be initialized before it can {to}")
        return self._session

    def shutdown(self) -> None:
        """Shut down: all that spins or waits in this context returns.

        Raises
        ------
        RuntimeError
            If the context is not initialized.
        RCLError
            If it is shut down already.
        """
        session = self._initialized("be shutdown")
        with self._changing:
            if not session.valid:
                raise RCLError(
                    "failed to shutdown: rcl_shutdown already called on the given context"
                )
            self._end(session)

    def try_shutdown(self) -> None:
        """Shut down, unless that has happened."""
        if self._session is not None:
            with self._changing:
                self._end(self._session)

    def _end(self, session: Session) -> None:
        from embedded_ros import interrupts

        # A signal may have done this part, which calls nobody.
        if session.valid:
            session.invalidate()
        while self._farewells:
            farewell = self._farewells.pop(0)()
            if farewell is not None:
                farewell()
        interrupts.unwatch(session)
        session.close_if_unused()

    def on_shutdown(self, callback: Callable[[], Any]) -> None:
        """Have a function called on shutdown; at once if that has happened.

        Bound methods are held weakly.
        """
        if not callable(callback):
            raise TypeError(f"callback should be a callable, got {type(callback)}")
        with self._changing:
            is_over = self._session is not None and not self._session.valid
            if not is_over:
                held = weakref.WeakMethod(callback) if ismethod(callback) else lambda: callback
                self._farewells.append(held)
        if is_over:
            callback()

    def get_domain_id(self) -> int:
        """Domain of the context."""
        return self._initialized("have a domain id").domain_id

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


def _parsed(words: list[str]) -> RosArguments:
    check_encoding(words)
    try:
        return parse_arguments(words)
    except RCLInvalidROSArgsError as error:
        raise RCLInvalidROSArgsError(f"failed to initialize rcl: {error}") from None


def _configure_logging(arguments: RosArguments) -> None:
    for name, level in arguments.log_levels:
        log_output.set_level(name, level)
    log_output.set_stderr_enabled("--disable-stdout-logs" not in arguments.switches)
