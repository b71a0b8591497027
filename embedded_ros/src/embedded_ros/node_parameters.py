"""The parameters of a node: the part of :class:`rclpy.node.Node` that keeps them."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from embedded_ros.parameter_rules import accept, check_descriptor, reject, select_names
from rclpy.exceptions import (
    InvalidParameterTypeException,
    InvalidParameterValueException,
    ParameterAlreadyDeclaredException,
    ParameterImmutableException,
    ParameterNotDeclaredException,
    ParameterUninitializedException,
)
from rclpy.parameter import PARAMETER_SEPARATOR_STRING, Parameter
from rclpy.validate_parameter_name import validate_parameter_name

if TYPE_CHECKING:
    from rclpy.clock import Clock
    from rclpy.publisher import Publisher

__all__ = ["NodeParameters"]

PreSetCallback = Callable[[list[Parameter]], list[Parameter]]
OnSetCallback = Callable[[list[Parameter]], Any]
PostSetCallback = Callable[[list[Parameter]], Any]


class NodeParameters:
    """Declares, checks and keeps parameters, and publishes their changes."""

    _clock: Clock
    _parameter_event_publisher: Publisher | None

    def _init_parameters(self, *, allow_undeclared: bool) -> None:
        self._parameters: dict[str, Parameter] = {}
        self._descriptors: dict[str, Any] = {}
        self._parameter_overrides: dict[str, Parameter] = {}
        self._allow_undeclared_parameters = allow_undeclared
        self._pre_set_parameters_callbacks: list[PreSetCallback] = []
        self._on_set_parameters_callbacks: list[OnSetCallback] = []
        self._post_set_parameters_callbacks: list[PostSetCallback] = []

    def get_fully_qualified_name(self) -> str:
        """Namespace and name of the node."""
        raise NotImplementedError

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
            name, value, descriptor = self._checked_declaration(namespace, index, entry)
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

    def _checked_declaration(
        self, namespace: str, index: int, entry: tuple[Any, ...]
    ) -> tuple[str, Any, Any]:
        from rcl_interfaces.msg import ParameterDescriptor, ParameterValue

        if not 1 <= len(entry) <= 3:
            raise TypeError(
                f"Invalid parameter tuple length at index {index} in parameters list: "
                f"{entry}; expecting length between 1 and 3"
            )
        name = entry[0]
        if not isinstance(name, str):
            raise TypeError(
                f"First element {name} at index {index} in parameters list is not a str."
            )
        name = f"{namespace}.{name}" if namespace else name
        validate_parameter_name(name)
        value = entry[1] if len(entry) > 1 else None
        descriptor = entry[2] if len(entry) > 2 else ParameterDescriptor()
        if not isinstance(descriptor, ParameterDescriptor):
            raise TypeError(
                f"Third element {descriptor} at index {index} in parameters list "
                "is not a ParameterDescriptor."
            )
        if len(entry) == 1:
            warnings.warn(
                f"when declaring parameter named '{name}', "
                "declaring a parameter only providing its name is deprecated. "
                "You have to either:\n"
                '\t- Pass a name and a default value different to "PARAMETER NOT SET"'
                " (and optionally a descriptor).\n"
                "\t- Pass a name and a parameter type.\n"
                "\t- Pass a name and a descriptor with `dynamic_typing=True",
                stacklevel=4,
            )
            descriptor.dynamic_typing = True
        if isinstance(value, Parameter.Type):
            if value is Parameter.Type.NOT_SET:
                raise ValueError(
                    f"Cannot declare parameter {{{name}}} as statically typed of type NOT_SET"
                )
            if descriptor.dynamic_typing:
                raise ValueError(
                    f"When declaring parameter {{{name}}} passing a descriptor with"
                    "`dynamic_typing=True` is not allowed when the parameter type is provided"
                )
            descriptor.type = value.value
            return name, None, descriptor
        if not descriptor.dynamic_typing:
            if isinstance(value, ParameterValue):
                descriptor.type = value.type
            else:
                descriptor.type = Parameter.Type.from_parameter_value(value).value
            if descriptor.type == Parameter.Type.NOT_SET.value:
                raise ValueError(
                    "Cannot declare a statically typed parameter with default value "
                    "of type PARAMETER_NOT_SET"
                )
        return name, value, descriptor

    def undeclare_parameter(self, name: str) -> None:
        """Undeclare a parameter, unless it is read-only."""
        if not self.has_parameter(name):
            raise ParameterNotDeclaredException(name)
        if self._descriptors[name].read_only:
            raise ParameterImmutableException(name)
        del self._parameters[name]
        del self._descriptors[name]

    # ------------------------------------------------------------------ reading

    def has_parameter(self, name: str) -> bool:
        """Tell whether a parameter is declared."""
        return name in self._parameters

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
        if self._pre_set_parameters_callbacks:
            parameter_list = [
                parameter
                for callback in self._pre_set_parameters_callbacks
                for parameter in callback(parameter_list)
            ]
            if not parameter_list:
                return reject(
                    "parameter list cannot be empty, this might be due to "
                    "pre_set_parameters_callback modifying the original parameters list."
                )
        if not all(isinstance(parameter, Parameter) for parameter in parameter_list):
            raise TypeError(f"parameter must be instance of type '{Parameter!r}'")
        undeclared = [
            parameter.name for parameter in parameter_list if parameter.name not in self._parameters
        ]
        if undeclared and not self._allow_undeclared_parameters:
            # The first name is missing in rclpy's text, too: its check uses it up.
            raise ParameterNotDeclaredException(undeclared[1:])
        return self._apply(parameter_list, None)

    def _apply(self, parameters: list[Parameter], descriptors: dict[str, Any] | None) -> Any:
        """Check and set; with new descriptors this declares, and unset values are kept."""
        declares = descriptors is not None
        rules = self._descriptors if descriptors is None else descriptors
        for parameter in parameters:
            if parameter.name in rules:
                result = check_descriptor(
                    parameter,
                    rules[parameter.name],
                    is_declared=self.has_parameter(parameter.name),
                    check_read_only=not declares,
                )
                if not result.successful:
                    return result
        for callback in self._on_set_parameters_callbacks:
            result = callback(parameters)
            if not result.successful:
                return result
        self._store(parameters, descriptors)
        for post_callback in self._post_set_parameters_callbacks:
            post_callback(parameters)
        return accept()

    def _store(self, parameters: list[Parameter], descriptors: dict[str, Any] | None) -> None:
        from rcl_interfaces.msg import ParameterDescriptor, ParameterEvent

        event = ParameterEvent(node=self.get_fully_qualified_name())
        for parameter in parameters:
            name = parameter.name
            message = parameter.to_parameter_msg()
            if descriptors is None and parameter.type_ is Parameter.Type.NOT_SET:
                event.deleted_parameters.append(message)
                self._parameters.pop(name, None)
                self._descriptors.pop(name, None)
                continue
            if descriptors is not None:
                self._descriptors[name] = descriptors[name]
            elif name not in self._descriptors:
                self._descriptors[name] = ParameterDescriptor(dynamic_typing=True)
            if self.get_parameter_or(name).type_ is Parameter.Type.NOT_SET:
                event.new_parameters.append(message)
            else:
                event.changed_parameters.append(message)
            self._parameters[name] = parameter
        event.stamp = self._clock.now().to_msg()
        if self._parameter_event_publisher is not None:
            self._parameter_event_publisher.publish(event)

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

    # ---------------------------------------------------------------- callbacks

    def add_pre_set_parameters_callback(self, callback: PreSetCallback) -> None:
        """Have a function replace the list of parameters before they are checked."""
        self._pre_set_parameters_callbacks.insert(0, callback)

    def add_on_set_parameters_callback(self, callback: OnSetCallback) -> None:
        """Have a function accept or reject parameters: it returns a ``SetParametersResult``."""
        self._on_set_parameters_callbacks.insert(0, callback)

    def add_post_set_parameters_callback(self, callback: PostSetCallback) -> None:
        """Have a function called with the parameters that were set."""
        self._post_set_parameters_callbacks.insert(0, callback)

    def remove_pre_set_parameters_callback(self, callback: PreSetCallback) -> None:
        """Remove a callback; ``ValueError`` if it was not added."""
        self._pre_set_parameters_callbacks.remove(callback)

    def remove_on_set_parameters_callback(self, callback: OnSetCallback) -> None:
        """Remove a callback; ``ValueError`` if it was not added."""
        self._on_set_parameters_callbacks.remove(callback)

    def remove_post_set_parameters_callback(self, callback: PostSetCallback) -> None:
        """Remove a callback; ``ValueError`` if it was not added."""
        self._post_set_parameters_callbacks.remove(callback)
