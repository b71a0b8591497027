"""The parameters of a node, without the node: declared, read, set.

A change goes through four rounds. *Before set*, callbacks may replace what is to be set. *On set*,
descriptors and then callbacks may object. The change is made and announced; what cannot be
announced is taken back. *After set*, callbacks may react. A declaration is a change without the
first round.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from embedded_ros.errors import (
    InvalidParameterTypeException,
    InvalidParameterValueException,
    ParameterAlreadyDeclaredException,
    ParameterImmutableException,
    ParameterNotDeclaredException,
    ParameterUninitializedException,
)
from embedded_ros.parameter_callbacks import Callbacks, Judge, React, Rewrite
from embedded_ros.parameter_declaration import Declaration
from embedded_ros.parameter_rules import Objection, objection
from embedded_ros.parameter_selection import SEPARATOR
from embedded_ros.parameter_table import Changes, Entry, ParameterTable, new_descriptor
from embedded_ros.parameter_type import ParameterType
from embedded_ros.parameter_value import Parameter

__all__ = ["ParameterStore"]


class ParameterStore:
    """Parameters with their descriptors.

    Parameters
    ----------
    overrides : mapping of str to Parameter, optional
        Values that take the place of the defaults of declarations.
    allow_undeclared : bool
        Whether setting declares a parameter, and reading one that is not there gives one that is
        not set.
    announce : callable, optional
        Gets the :class:`.Changes` of each change, once it is made.

    Attributes
    ----------
    overrides : dict
    allows_undeclared : bool
    announce : callable or None
    before_set, on_set, after_set : Callbacks
        Who is asked and told; see the module.
    """

    def __init__(
        self,
        *,
        overrides: Mapping[str, Parameter] | None = None,
        allow_undeclared: bool = False,
        announce: Callable[[Changes], Any] | None = None,
    ) -> None:
        self.overrides = dict(overrides or {})
        self.allows_undeclared = allow_undeclared
        self.before_set: Callbacks[Rewrite] = Callbacks()
        self.on_set: Callbacks[Judge] = Callbacks()
        self.after_set: Callbacks[React] = Callbacks()
        self.announce = announce
        self._table = ParameterTable()

    # ------------------------------------------------------------------ reading

    def __contains__(self, name: str) -> bool:
        return name in self._table

    def __iter__(self) -> Iterator[str]:
        """Iterate over the names, in the order of their declaration."""
        return iter(self._table)

    def _entry(self, name: str) -> Entry | None:
        entry = self._table.entry(name)
        if entry is None and not self.allows_undeclared:
            raise ParameterNotDeclaredException(name)
        return entry

    def parameter(self, name: str) -> Parameter:
        """Parameter of a name.

        Raises
        ------
        ParameterNotDeclaredException
            If it is not declared and has to be.
        ParameterUninitializedException
            If it was declared by type and has no value yet.
        """
        found = self.parameter_with_value(name)
        if found is not None:
            return found
        entry = self._entry(name)
        if entry is None:
            return Parameter(name)
        if not entry.descriptor.dynamic_typing:
            raise ParameterUninitializedException(name)
        return entry.parameter

    def parameter_with_value(self, name: str) -> Parameter | None:
        """Parameter of a name; None if it is not declared or has no value."""
        entry = self._table.entry(name)
        return entry.parameter if entry is not None and entry.has_value else None

    def type_of(self, name: str) -> ParameterType | None:
        """Type of a parameter's value; None if it is undeclared and may be."""
        entry = self._entry(name)
        return None if entry is None else entry.parameter.type_

    def descriptor(self, name: str) -> Any:
        """Descriptor of a parameter; an empty one if it is undeclared and may be."""
        entry = self._entry(name)
        return new_descriptor() if entry is None else entry.descriptor

    def below(self, prefix: str) -> dict[str, Parameter]:
        """Parameters by what follows a prefix and a separator in their names; all for ''."""
        start = prefix and prefix + SEPARATOR
        return {
            name[len(start) :]: entry.parameter
            for name, entry in self._table.items()
            if name.startswith(start)
        }

    # ----------------------------------------------------------------- changing

    def declare(
        self, declarations: Sequence[Declaration], *, ignore_overrides: bool = False
    ) -> list[Parameter]:
        """Declare parameters one after the other; what went before an error stays declared.

        Parameters
        ----------
        declarations : sequence of Declaration
        ignore_overrides : bool

        Returns
        -------
        list of Parameter
            With the values in force.

        Raises
        ------
        ParameterAlreadyDeclaredException
            With all names that are declared already; nothing is declared then.
        InvalidParameterTypeException
            If an override is of another type.
        InvalidParameterValueException
            If the descriptor or a callback objects to the value.
        """
        overrides = {} if ignore_overrides else self.overrides
        wanted = []
        for item in declarations:
            value = overrides[item.name].value if item.name in overrides else item.value
            wanted.append(Parameter(item.name, value=value))
        known = [parameter.name for parameter in wanted if parameter.name in self]
        if known:
            raise ParameterAlreadyDeclaredException(known)
        # Of several declarations of one name the last descriptor counts for all.
        descriptors = {item.name: item.descriptor for item in declarations}
        for parameter in wanted:
            self._declare(Entry(parameter, descriptors[parameter.name]))
        entries = [self._table.entry(parameter.name) for parameter in wanted]
        return [
            given if entry is None else entry.parameter
            for given, entry in zip(wanted, entries, strict=True)
        ]

    def _declare(self, entry: Entry) -> None:
        parameter = entry.parameter
        refused = self._objection([parameter], {parameter.name: entry}, mind_read_only=False)
        if refused is None:
            self._tell(self._table.declare(entry), [parameter])
        elif refused.expected_type is not None:
            raise InvalidParameterTypeException(parameter, refused.expected_type.name)
        else:
            raise InvalidParameterValueException(parameter.name, parameter.value, refused.reason)

    def undeclare(self, name: str) -> None:
        """Forget a parameter, which must not be read-only; nobody is asked or told."""
        entry = self._table.entry(name)
        if entry is None:
            raise ParameterNotDeclaredException(name)
        if entry.descriptor.read_only:
            raise ParameterImmutableException(name)
        self._table.replace({name: None})

    def set(self, parameters: Sequence[Parameter]) -> Objection | None:
        """Set all parameters or none; one without a value is undeclared if its type is dynamic.

        Returns
        -------
        Objection
            Why nothing is set; None if all is.

        Raises
        ------
        TypeError
            If something else than a parameter is to be set.
        ParameterNotDeclaredException
            If one is not declared and has to be.
        """
        wanted = list(parameters)
        rewriting = tuple(self.before_set)
        if rewriting:
            wanted = [parameter for rewrite in rewriting for parameter in rewrite(wanted)]
            if not wanted:
                return Objection(
                    "parameter list cannot be empty, this might be due to "
                    "pre_set_parameters_callback modifying the original parameters list."
                )
        if not all(isinstance(parameter, Parameter) for parameter in wanted):
            raise TypeError(f"parameter must be instance of type '{Parameter!r}'")
        entries = {parameter.name: self._table.entry(parameter.name) for parameter in wanted}
        unknown = [parameter.name for parameter in wanted if entries[parameter.name] is None]
        if unknown and not self.allows_undeclared:
            # The first one is missing in rclpy's text, too.
            raise ParameterNotDeclaredException(unknown[1:])
        refused = self._objection(wanted, entries, mind_read_only=True)
        if refused is None:
            self._tell(self._table.set(wanted), wanted)
        return refused

    def redescribe(
        self, name: str, descriptor: Any, alternative: Parameter | None = None
    ) -> Parameter:
        """Replace the descriptor of a parameter; nobody is asked or told.

        Parameters
        ----------
        name : str
        descriptor : rcl_interfaces.msg.ParameterDescriptor
        alternative : Parameter, optional
            Taken if the descriptor does not let the present value pass.

        Returns
        -------
        Parameter
            With the value in force.

        Raises
        ------
        ParameterImmutableException
            If the parameter is read-only.
        InvalidParameterValueException
            If no value passes.
        """
        current = self.parameter(name)
        if name not in self:
            return current
        if self.descriptor(name).read_only:
            raise ParameterImmutableException(name)
        chosen = current
        refused = objection(chosen, descriptor, is_declared=True, mind_read_only=False)
        if refused is not None and alternative is not None:
            chosen = alternative
            refused = objection(chosen, descriptor, is_declared=True, mind_read_only=False)
        if refused is not None:
            raise InvalidParameterValueException(name, chosen.value, refused.reason)
        self._table.replace({name: Entry(chosen, descriptor)})
        return chosen

    def _objection(
        self,
        parameters: list[Parameter],
        entries: Mapping[str, Entry | None],
        *,
        mind_read_only: bool,
    ) -> Objection | None:
        for parameter in parameters:
            entry = entries[parameter.name]
            if entry is None:
                continue  # allowed without a declaration, and so without rules
            refused = objection(
                parameter,
                entry.descriptor,
                is_declared=parameter.name in self,
                mind_read_only=mind_read_only,
            )
            if refused is not None:
                return refused
        for judge in self.on_set:
            verdict = judge(parameters)
            if not verdict.successful:
                return Objection(verdict.reason)
        return None

    def _tell(self, changes: Changes, parameters: list[Parameter]) -> None:
        if self.announce is not None:
            try:
                self.announce(changes)
            except BaseException:
                self._table.take_back(changes)
                raise
        for react in self.after_set:
            react(parameters)
