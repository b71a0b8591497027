"""Guard conditions: triggers from any thread."""

from collections.abc import Callable
from typing import Any

from embedded_ros import cyclone
from embedded_ros.errors import InvalidHandle, NotInitializedException
from embedded_ros.futures import TaskRunner
from rclpy.callback_groups import CallbackGroup
from rclpy.context import Context
from rclpy.utilities import get_default_context

__all__ = ["GuardCondition"]


class GuardCondition:
    """Has a callback run when it is triggered.

    Made by :meth:`rclpy.node.Node.create_guard_condition`.
    """

    def __init__(
        self,
        callback: Callable[[], Any] | None,
        callback_group: CallbackGroup | None,
        context: Context | None = None,
    ) -> None:
        session = (context or get_default_context()).handle
        if session is None:
            raise NotInitializedException
        self._trigger: cyclone.GuardCondition | None = cyclone.GuardCondition(session.ref)
        #: What a wait set watches.
        self._wait_ref: int = self._trigger.ref
        self.callback_group = callback_group
        self.callback = callback

    def _take(
        self, _runner: TaskRunner | None = None
    ) -> tuple[Callable[[], Any], tuple[()]] | None:
        if self._trigger is None or not self._trigger.clear() or self.callback is None:
            return None
        return self.callback, ()

    def trigger(self) -> None:
        """Have the callback run."""
        if self._trigger is None:
            raise InvalidHandle
        self._trigger.set()

    def destroy(self) -> None:
        """Delete the condition. Again is fine."""
        trigger, self._trigger = self._trigger, None
        if trigger is not None:
            trigger.close()
