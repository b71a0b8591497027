"""The parameters of a node under the names that rclpy's ``Node`` has for them.

All of it is asked of the node's :class:`.ParameterStore`; here are the signatures, and the messages
that a store does without.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import Any

from embedded_ros.message_classes import message_class
from embedded_ros.parameter_callbacks import Judge, React, Rewrite
from embedded_ros.parameter_declaration import read_declarations
from embedded_ros.parameter_messages import listing_message, result_message
from embedded_ros.parameter_store import ParameterStore
from embedded_ros.parameter_table import new_descriptor
from embedded_ros.parameter_type import ParameterType
from embedded_ros.parameter_value import Parameter

__all__ = ["NodeParameters"]


class NodeParameters:
    """Declares, gets, sets, describes and lists parameters."""

    _parameter_store: ParameterStore

    @property
    def _parameter_overrides(self) -> dict[str, Parameter]:
        """Overrides by name. Programs look here, as rclpy has no public way to see them."""
        return self._parameter_store.overrides

    # ---------------------------------------------------------------- declaring

    def declare_parameter(
        self, name: str, value: Any = None, descriptor: Any = None, ignore_override: bool = False
    ) -> Parameter:
        """Declare a parameter.

        Parameters
        ----------
        name : str
        value : optional
            Default value, or a :class:`Parameter.Type` for a parameter without default.
        descriptor : rcl_interfaces.msg.ParameterDescriptor, optional
            Description, ranges, whether read-only or dynamically typed.
        ignore_override : bool
            Whether to ignore the value from the command line or constructor.

        Returns
        -------
        Parameter
            With the value in force.

        Raises
        ------
        ParameterAlreadyDeclaredException, InvalidParameterException
        InvalidParameterTypeException
            If an override is of another type.
        InvalidParameterValueException
            If the descriptor or a callback rejects the value.
        """
        entry: tuple[Any, ...] = (name,)
        if value is not None or descriptor is not None:
            entry = (name, value, new_descriptor() if descriptor is None else descriptor)
        return self._declare("", [entry], ignore_override)[0]

    def declare_parameters(
        self, namespace: str, parameters: Sequence[tuple[Any, ...]], ignore_override: bool = False
    ) -> list[Parameter]:
        """Declare parameters one after the other.

        Parameters
        ----------
        namespace : str
            Put with a dot before every name, unless it is empty.
        parameters : sequence of (name, value, descriptor)
            As for :meth:`declare_parameter`; value and descriptor may be missing.
        ignore_override : bool
        """
        return self._declare(namespace, parameters, ignore_override)

    def _declare(
        self, namespace: str, entries: Sequence[tuple[Any, ...]], ignore_override: bool
    ) -> list[Parameter]:
        declarations = read_declarations(namespace, entries)
        for declaration in declarations:
            if declaration.is_name_only:
                warnings.warn(
                    f"when declaring parameter named '{declaration.name}', declaring a parameter "
                    "only providing its name is deprecated: give it a default value or a "
                    "Parameter.Type, or a descriptor with dynamic_typing=True",
                    stacklevel=3,
                )
        return self._parameter_store.declare(declarations, ignore_overrides=ignore_override)

    def undeclare_parameter(self, name: str) -> None:
        """Undeclare a parameter, unless it is read-only."""
        self._parameter_store.undeclare(name)

    # ------------------------------------------------------------------ reading

    def has_parameter(self, name: str) -> bool:
        """Tell whether a parameter is declared."""
        return name in self._parameter_store

    def get_parameter(self, name: str) -> Parameter:
        """Parameter of a name.

        Raises
        ------
        ParameterNotDeclaredException
            If it is not declared and the node allows no undeclared ones.
        ParameterUninitializedException
            If it was declared by type and has no value yet.
        """
        return self._parameter_store.parameter(name)

    def get_parameters(self, names: list[str]) -> list[Parameter]:
        """Parameters of these names; see :meth:`get_parameter`."""
        return [self._parameter_store.parameter(name) for name in _strings("names", names)]

    def get_parameter_or(self, name: str, alternative_value: Parameter | None = None) -> Parameter:
        """Parameter of a name, or another one if it is not declared or has no value."""
        found = self._parameter_store.parameter_with_value(name)
        return found or alternative_value or Parameter(name)

    def get_parameters_by_prefix(self, prefix: str) -> dict[str, Parameter]:
        """Parameters by what follows the prefix and a dot in their names."""
        return self._parameter_store.below(prefix)

    def get_parameter_type(self, name: str) -> int | ParameterType:
        """Number of a parameter's type, or ``NOT_SET`` if it is undeclared and may be."""
        type_ = self._parameter_store.type_of(name)
        return ParameterType.NOT_SET if type_ is None else int(type_.value)

    def get_parameter_types(self, names: list[str]) -> list[int | ParameterType]:
        """Types of parameters; see :meth:`get_parameter_type`."""
        return [self.get_parameter_type(name) for name in _strings("names", names)]

    def describe_parameter(self, name: str) -> Any:
        """Descriptor of a parameter."""
        return self._parameter_store.descriptor(name)

    def describe_parameters(self, names: list[str]) -> list[Any]:
        """Descriptors of parameters."""
        return [self._parameter_store.descriptor(name) for name in names]

    def list_parameters(self, prefixes: list[str], depth: int) -> Any:
        """Names of parameters, and what stands before their last dots.

        Parameters
        ----------
        prefixes : list of str
            Names must begin with one of them; empty: all names.
        depth : int
            Names have fewer dots (beyond the prefix) than this; 0: any number.

        Returns
        -------
        rcl_interfaces.msg.ListParametersResult
        """
        if not isinstance(prefixes, list):
            raise TypeError("The prefixes argument must be a list")
        _strings("prefixes", prefixes)
        if not isinstance(depth, int):
            raise TypeError("The depth must be instance of type int")
        if depth < 0:
            raise ValueError("The depth must be greater than or equal to zero")
        return listing_message(self._parameter_store, prefixes, depth)

    # ------------------------------------------------------------------ setting

    def set_parameters(self, parameter_list: list[Parameter]) -> list[Any]:
        """Set parameters one after the other.

        Returns
        -------
        list of rcl_interfaces.msg.SetParametersResult

        Raises
        ------
        ParameterNotDeclaredException
            If one is not declared; those before it are set.
        """
        return [self.set_parameters_atomically([parameter]) for parameter in parameter_list]

    def set_parameters_atomically(self, parameter_list: list[Parameter]) -> Any:
        """Set all parameters or none.

        Returns
        -------
        rcl_interfaces.msg.SetParametersResult
        """
        return result_message(self._parameter_store.set(parameter_list))

    def set_descriptor(self, name: str, descriptor: Any, alternative_value: Any = None) -> Any:
        """Replace the descriptor of a parameter.

        Parameters
        ----------
        name : str
        descriptor : rcl_interfaces.msg.ParameterDescriptor
        alternative_value : rcl_interfaces.msg.ParameterValue, optional
            Set if the present value does not fit the new descriptor.

        Returns
        -------
        rcl_interfaces.msg.ParameterValue
            The value in force.
        """
        alternative = None
        if alternative_value is not None:
            parameter = message_class("rcl_interfaces/msg/Parameter")
            alternative = Parameter.from_parameter_msg(
                parameter(name=name, value=alternative_value)
            )
        chosen = self._parameter_store.redescribe(name, descriptor, alternative)
        return chosen.get_parameter_value()

    # ---------------------------------------------------------------- callbacks

    def add_pre_set_parameters_callback(self, callback: Rewrite) -> None:
        """Have a function replace the list of parameters before they are checked."""
        self._parameter_store.before_set.add(callback)

    def add_on_set_parameters_callback(self, callback: Judge) -> None:
        """Have a function accept or reject parameters: it returns a ``SetParametersResult``."""
        self._parameter_store.on_set.add(callback)

    def add_post_set_parameters_callback(self, callback: React) -> None:
        """Have a function called with the parameters that were set."""
        self._parameter_store.after_set.add(callback)

    def remove_pre_set_parameters_callback(self, callback: Rewrite) -> None:
        """Remove a callback; ``ValueError`` if it was not added."""
        self._parameter_store.before_set.remove(callback)

    def remove_on_set_parameters_callback(self, callback: Judge) -> None:
        """Remove a callback; ``ValueError`` if it was not added."""
        self._parameter_store.on_set.remove(callback)

    def remove_post_set_parameters_callback(self, callback: React) -> None:
        """Remove a callback; ``ValueError`` if it was not added."""
        self._parameter_store.after_set.remove(callback)


def _strings(what: str, values: list[str]) -> list[str]:
    if not all(isinstance(value, str) for value in values):
        raise TypeError(f"All {what} must be instances of type str")
    return values
