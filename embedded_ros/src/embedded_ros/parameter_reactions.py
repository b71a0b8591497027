"""Who wants to hear of which change of a parameter."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

__all__ = [
    "ParameterCallbackHandle",
    "ParameterEventCallbackHandle",
    "Reactions",
    "parameter_in",
    "parameters_in",
]


@dataclass(eq=False)
class ParameterEventCallbackHandle:
    """A registered callback for events."""

    callback: Callable[[Any], Any]


@dataclass(eq=False)
class ParameterCallbackHandle:
    """A registered callback for a parameter of a node."""

    parameter_name: str
    node_name: str
    callback: Callable[[Any], Any]


_Handle = ParameterCallbackHandle | ParameterEventCallbackHandle
#: What a callback is for: a parameter of a node, or None for all events.
_Subject = tuple[str, str] | None


def parameters_in(event: Any) -> Iterator[Any]:
    """New and changed parameters in an ``rcl_interfaces.msg.ParameterEvent``."""
    yield from event.new_parameters
    yield from event.changed_parameters


def parameter_in(event: Any, parameter_name: str, node_name: str) -> Any:
    """New or changed parameter of a node in an event; None if it is not there."""
    found = (item for item in parameters_in(event) if item.name == parameter_name)
    return next(found, None) if event.node == node_name else None


class Reactions:
    """Callbacks by what they are for; while one runs it may add and remove some."""

    def __init__(self) -> None:
        self._handles: dict[_Subject, tuple[_Handle, ...]] = {}
        self._writing = threading.Lock()

    def add(self, handle: _Handle) -> None:
        """Have a callback called, before the others for the same."""
        subject = _subject(handle)
        with self._writing:
            self._handles[subject] = (handle, *self._handles.get(subject, ()))

    def remove(self, handle: _Handle) -> None:
        """Undo :meth:`add`; ``RuntimeError`` if there is nothing to undo."""
        subject = _subject(handle)
        with self._writing:
            handles = self._handles.pop(subject, ())
            left = tuple(other for other in handles if other is not handle)
            if left:
                self._handles[subject] = left
            if left == handles:
                raise RuntimeError("Callback doesn't exist")

    def call(self, event: Any) -> None:
        """Call back for the parameters in an event, and then for the event."""
        with self._writing:
            handles = dict(self._handles)
        for_events = handles.pop(None, ())
        for subject, for_parameter in handles.items():
            parameter = subject and parameter_in(event, *subject)
            if parameter is not None:
                for handle in for_parameter:
                    handle.callback(parameter)
        for handle in for_events:
            handle.callback(event)


def _subject(handle: _Handle) -> _Subject:
    if isinstance(handle, ParameterCallbackHandle):
        return handle.parameter_name, handle.node_name
    return None
