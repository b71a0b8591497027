"""Which callbacks may run at the same time."""

import threading
import weakref
from typing import Any

__all__ = ["CallbackGroup", "MutuallyExclusiveCallbackGroup", "ReentrantCallbackGroup"]


class CallbackGroup:
    """Base of the groups that control whether callbacks run in parallel."""

    def __init__(self) -> None:
        #: Members, held weakly.
        self.entities: set[weakref.ref[Any]] = set()

    def add_entity(self, entity: Any) -> None:
        """Put an entity into the group."""
        # A node that makes a timer for each request would fill the memory with dead references.
        self.entities.add(weakref.ref(entity, self.entities.discard))

    def has_entity(self, entity: Any) -> bool:
        """Tell whether an entity is in the group."""
        return weakref.ref(entity) in self.entities

    def can_execute(self, entity: Any) -> bool:
        """Tell whether the callback of an entity may run now."""
        raise NotImplementedError

    def beginning_execution(self, entity: Any) -> bool:
        """Claim the right to run; False if it is not to be had now."""
        raise NotImplementedError

    def ending_execution(self, entity: Any) -> None:
        """Give the right back."""
        raise NotImplementedError


class ReentrantCallbackGroup(CallbackGroup):
    """Callbacks run in parallel without restriction."""

    def can_execute(self, entity: Any) -> bool:  # noqa: ARG002
        """Tell whether the callback of an entity may run now: always."""
        return True

    def beginning_execution(self, entity: Any) -> bool:  # noqa: ARG002
        """Claim the right to run: always granted."""
        return True

    def ending_execution(self, entity: Any) -> None:
        """Give the right back."""


class MutuallyExclusiveCallbackGroup(CallbackGroup):
    """One callback at a time."""

    def __init__(self) -> None:
        super().__init__()
        # Held by whoever runs. A thread may give back what another one took.
        self._right = threading.Lock()
        self._holder: Any = None

    def can_execute(self, entity: Any) -> bool:  # noqa: ARG002
        """Tell whether the callback of an entity may run now."""
        return not self._right.locked()

    def beginning_execution(self, entity: Any) -> bool:
        """Claim the right to run; False while another callback runs."""
        is_granted = self._right.acquire(blocking=False)
        if is_granted:
            self._holder = entity
        return is_granted

    def ending_execution(self, entity: Any) -> None:
        """Give the right back."""
        assert self._holder is entity, f"{entity!r} does not run"
        self._holder = None
        self._right.release()
