"""The table of a node's parameters: what is there now, and how it gets replaced.

A change makes a new table and puts it in the old one's place: whoever reads meanwhile, in this
thread or in another one, sees all of the change or nothing. A change remembers what it replaced
and can be taken back.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from embedded_ros.message_classes import message_class
from embedded_ros.parameter_type import ParameterType
from embedded_ros.parameter_value import Parameter

__all__ = ["Changes", "Entry", "ParameterTable", "new_descriptor"]


class Entry(NamedTuple):
    """A parameter and the descriptor that says what it may become.

    The descriptor is the one that was given: several parameters may share one, as in rclpy.
    """

    parameter: Parameter
    descriptor: Any

    @property
    def has_value(self) -> bool:
        """Whether the parameter is set."""
        return self.parameter.type_ is not ParameterType.NOT_SET


@dataclass
class Changes:
    """What one change did; a parameter that got its first value is new.

    Attributes
    ----------
    new, changed, deleted : list of Parameter
    before : dict
        Entries by name that the change replaced; None if there was none.
    """

    new: list[Parameter] = field(default_factory=list)
    changed: list[Parameter] = field(default_factory=list)
    deleted: list[Parameter] = field(default_factory=list)
    before: dict[str, Entry | None] = field(default_factory=dict, repr=False)


class ParameterTable:
    """Entries by name, in the order of their declaration."""

    def __init__(self) -> None:
        self._entries: Mapping[str, Entry] = {}
        self._writing = threading.Lock()

    def __contains__(self, name: str) -> bool:
        return name in self._entries

    def __iter__(self) -> Iterator[str]:
        return iter(self._entries)

    def entry(self, name: str) -> Entry | None:
        """Entry of a name, if there is one."""
        return self._entries.get(name)

    def items(self) -> Iterator[tuple[str, Entry]]:
        """Iterate over what is there now, whatever changes meanwhile."""
        return iter(self._entries.items())

    def replace(self, entries: Mapping[str, Entry | None]) -> None:
        """Replace some entries; None takes one out."""
        with self._writing:
            merged = {**self._entries, **entries}
            self._entries = {name: entry for name, entry in merged.items() if entry is not None}
        for entry in filter(None, entries.values()):
            _complete(entry)

    def set(self, parameters: Sequence[Parameter]) -> Changes:
        """Give parameters new values; those without a value are taken out."""
        with self._writing:
            entries, changes = dict(self._entries), Changes()
            for parameter in parameters:
                old = entries.get(parameter.name)
                changes.before.setdefault(parameter.name, old)
                if parameter.type_ is ParameterType.NOT_SET:
                    entries.pop(parameter.name, None)
                    changes.deleted.append(parameter)
                else:
                    descriptor = old.descriptor if old else new_descriptor(dynamic_typing=True)
                    _write(entries, Entry(parameter, descriptor), changes)
            self._entries = entries
        return changes

    def declare(self, entry: Entry) -> Changes:
        """Enter a parameter, with or without a value."""
        name = entry.parameter.name
        with self._writing:
            entries, changes = dict(self._entries), Changes()
            changes.before[name] = entries.get(name)
            _write(entries, entry, changes)
            self._entries = entries
        return changes

    def take_back(self, changes: Changes) -> None:
        """Undo a change."""
        self.replace(changes.before)


def _write(entries: dict[str, Entry], entry: Entry, changes: Changes) -> None:
    old = entries.get(entry.parameter.name)
    is_change = old is not None and old.has_value
    (changes.changed if is_change else changes.new).append(entry.parameter)
    entries[entry.parameter.name] = entry
    _complete(entry)


def _complete(entry: Entry) -> None:
    """Tell a descriptor its parameter's name and, if dynamic, its type."""
    parameter, descriptor = entry
    if descriptor.name != parameter.name:
        descriptor.name = parameter.name
    if descriptor.dynamic_typing:
        descriptor.type = parameter.type_.value


def new_descriptor(**fields: Any) -> Any:
    """Make an ``rcl_interfaces.msg.ParameterDescriptor``."""
    return message_class("rcl_interfaces/msg/ParameterDescriptor")(**fields)
