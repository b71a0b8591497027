"""Who is asked before parameters are set, who judges them, who reacts."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, Generic, TypeVar

from embedded_ros.parameter_value import Parameter

__all__ = ["Callbacks", "Judge", "React", "Rewrite"]

Rewrite = Callable[[list[Parameter]], list[Parameter]]
Judge = Callable[[list[Parameter]], Any]
React = Callable[[list[Parameter]], Any]
_Callback = TypeVar("_Callback", bound=Callable[..., Any])


class Callbacks(Generic[_Callback]):
    """Functions that are called in turn, the newest first; a call may add and remove some."""

    def __init__(self) -> None:
        self._newest_first: tuple[_Callback, ...] = ()

    def add(self, callback: _Callback) -> None:
        """Have a function called, too."""
        self._newest_first = (callback, *self._newest_first)

    def remove(self, callback: _Callback) -> None:
        """Undo :meth:`add`; ``ValueError`` if there is nothing to undo."""
        left = list(self._newest_first)
        left.remove(callback)
        self._newest_first = tuple(left)

    def __iter__(self) -> Iterator[_Callback]:
        return iter(self._newest_first)
