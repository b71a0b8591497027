"""What the services that every node offers need of the node."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

__all__ = ["ServingNode"]


class ServingNode(Protocol):
    """A node that makes services."""

    def get_name(self) -> str:
        """Name of the node, without its namespace."""
        ...

    @property
    def create_service(self) -> Callable[..., Any]:
        """Make a service of a type and a name with what answers its requests."""
        ...
