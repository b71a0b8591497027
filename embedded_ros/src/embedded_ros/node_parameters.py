"""The parameters of a node: the part of :class:`rclpy.node.Node` that keeps them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from embedded_ros.parameter_declaration import checked_declaration
from embedded_ros.parameter_rules import check_descriptor, select_names
from embedded_ros.parameter_setting import ParameterSetting
from rclpy.exceptions import (
    InvalidParameterTypeException,
    InvalidParameterValueException,
    ParameterAlreadyDeclaredException,
    ParameterImmutableException,
    ParameterNotDeclaredException,
    ParameterUninitializedException,
)
from rclpy.parameter import PARAMETER_SEPARATOR_STRING, Parameter

if TYPE_CHECKING:
    pass

__all__ = ["NodeParameters"]


class NodeParameters(ParameterSetting):
    """Declares parameters and tells of them."""

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
        from rcl_interfaces.msg import ParameterDescriptor

        if value is None and descriptor is None:
            return self.declare_parameters("", [(name,)], ignore_override)[0]
        descriptor = ParameterDescriptor() if descriptor is None else descriptor
        return self.declare_parameters("", [(name, value, descriptor)], ignore_override)[0]

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
        declared: list[Parameter] = []
        descriptors: dict[str, Any] = {}
        for index, entry in enumerate(parameters):
            name, value, descriptor = checked_declaration(namespace, index, entry)
            if not ignore_override and name in self._parameter_overrides:
                value = self._parameter_overrides[name].value
            declared.append(Parameter(name, value=value))
            descriptors[name] = descriptor
        again = [parameter.name for parameter in declared if parameter.name in self._parameters]
        if again:
            raise ParameterAlreadyDeclaredException(again)
        for parameter in declared:
            result = self._apply([parameter], descriptors)
            if result.successful:
                continue
            if result.reason.startswith("Wrong parameter type"):
                expected = Parameter.Type(descriptors[parameter.name].type).name
                raise InvalidParameterTypeException(parameter, expected)
            raise InvalidParameterValueException(parameter.name, parameter.value, result.reason)
        return [self._parameters[parameter.name] for parameter in declared]

    def undeclare_parameter(self, name: str) -> None:
        """Undeclare a parameter, unless it is read-only."""
        if not self.has_parameter(name):
            raise ParameterNotDeclaredException(name)
        if self._descriptors[name].read_only:
            raise ParameterImmutableException(name)
        del self._parameters[name]
        del self._descriptors[name]

    # ------------------------------------------------------------------ reading

    def get_parameter_types(self, names: list[str]) -> list[int | Parameter.Type]:
        """Types of parameters; see :meth:`get_parameter_type`."""
        if not all(isinstance(name, str) for name in names):
            raise TypeError("All names must be instances of type str")
        return [self.get_parameter_type(name) for name in names]

    def get_parameter_type(self, name: str) -> int | Parameter.Type:
        """Type of a parameter, as the number that rclpy gives."""
        if self.has_parameter(name):
            number: int = self._parameters[name].type_.value
            return number
        if self._allow_undeclared_parameters:
            return Parameter.Type.NOT_SET
        raise ParameterNotDeclaredException(name)

    def get_parameters(self, names: list[str]) -> list[Parameter]:
        """Parameters of these names; see :meth:`get_parameter`."""
        if not all(isinstance(name, str) for name in names):
            raise TypeError("All names must be instances of type str")
        return [self.get_parameter(name) for name in names]

    def get_parameter(self, name: str) -> Parameter:
        """Parameter of a name.

        Raises
        ------
        ParameterNotDeclaredException
            If it is not declared and the node allows no undeclared ones.
        ParameterUninitializedException
            If it was declared by type and has no value yet.
        """
        if not self.has_parameter(name):
            if self._allow_undeclared_parameters:
                return Parameter(name, Parameter.Type.NOT_SET, None)
            raise ParameterNotDeclaredException(name)
        parameter = self._parameters[name]
        is_set = parameter.type_ is not Parameter.Type.NOT_SET
        if is_set or self._descriptors[name].dynamic_typing:
            return parameter
        raise ParameterUninitializedException(name)

    def get_parameter_or(self, name: str, alternative_value: Parameter | None = None) -> Parameter:
        """Parameter of a name, or another one if it is not declared or has no value."""
        if alternative_value is None:
            alternative_value = Parameter(name, Parameter.Type.NOT_SET)
        parameter = self._parameters.get(name)
        if parameter is None or parameter.type_ is Parameter.Type.NOT_SET:
            return alternative_value
        return parameter

    def get_parameters_by_prefix(self, prefix: str) -> dict[str, Parameter]:
        """Parameters by what follows the prefix and a dot in their names."""
        if prefix:
            prefix += PARAMETER_SEPARATOR_STRING
        return {
            name.removeprefix(prefix): parameter
            for name, parameter in self._parameters.items()
            if name.startswith(prefix)
        }

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
        from rcl_interfaces.msg import ListParametersResult

        if not isinstance(prefixes, list):
            raise TypeError("The prefixes argument must be a list")
        if not all(isinstance(prefix, str) for prefix in prefixes):
            raise TypeError("All prefixes must be instances of type str")
        if not isinstance(depth, int):
            raise TypeError("The depth must be instance of type int")
        if depth < 0:
            raise ValueError("The depth must be greater than or equal to zero")
        names = select_names(self._parameters, prefixes, depth)
        parents = dict.fromkeys(name.rpartition(PARAMETER_SEPARATOR_STRING)[0] for name in names)
        return ListParametersResult(names=names, prefixes=[parent for parent in parents if parent])

    def describe_parameter(self, name: str) -> Any:
        """Descriptor of a parameter."""
        if name in self._descriptors:
            return self._descriptors[name]
        if self._allow_undeclared_parameters:
            from rcl_interfaces.msg import ParameterDescriptor

            return ParameterDescriptor()
        raise ParameterNotDeclaredException(name)

    def describe_parameters(self, names: list[str]) -> list[Any]:
        """Descriptors of parameters."""
        return [self.describe_parameter(name) for name in names]

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
        from rcl_interfaces.msg import Parameter as ParameterMsg

        if not self.has_parameter(name):
            return self.get_parameter(name).get_parameter_value()  # raises unless undeclared are ok
        if self.describe_parameter(name).read_only:
            raise ParameterImmutableException(name)
        current = self.get_parameter(name)
        candidates = [current]
        if alternative_value is not None:
            message = ParameterMsg(name=name, value=alternative_value)
            candidates.append(Parameter.from_parameter_msg(message))
        for candidate in candidates:
            result = check_descriptor(
                candidate, descriptor, is_declared=True, check_read_only=False
            )
            if result.successful:
                self._parameters[name] = candidate
                self._descriptors[name] = descriptor
                return candidate.get_parameter_value()
        raise InvalidParameterValueException(name, candidates[-1].value, result.reason)
