"""Guard conditions: triggers from any thread."""

from collections.abc import Callable
from typing import Any

from embedded_ros import cyclone
from rclpy.callback_groups import CallbackGroup
from rclpy.context import Context
from rclpy.exceptions import InvalidHandle, NotInitializedException
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
        self._context = get_default_context() if context is None else context
        if self._context.handle is None:
            raise NotInitializedException
        self._condition = cyclone.GuardCondition(self._context.handle.ref)
        self._destroyed = False
        self.callback = callback
        self.callback_group = callback_group

    @property
    def _wait_ref(self) -> int:
        """What a wait set watches."""
        return self._condition.ref

    def _take(self) -> Callable[[], Any] | None:
        return self.callback if self._condition.clear() else None

    def trigger(self) -> None:
        """Have the callback run."""
        if self._destroyed:
            raise InvalidHandle
        self._condition.set()

    def destroy(self) -> None:
        """Delete the condition. Again is fine."""
        if not self._destroyed:
            self._destroyed = True
            self._condition.close()
