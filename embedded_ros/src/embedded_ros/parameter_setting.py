"""Setting parameters: the part of :class:`rclpy.node.Node` that checks, stores and publishes."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from embedded_ros.parameter_rules import accept, check_descriptor, reject
from rclpy.exceptions import (
    ParameterNotDeclaredException,
)
from rclpy.parameter import Parameter

if TYPE_CHECKING:
    from rclpy.clock import Clock
    from rclpy.publisher import Publisher

__all__ = ["ParameterSetting"]

PreSetCallback = Callable[[list[Parameter]], list[Parameter]]
OnSetCallback = Callable[[list[Parameter]], Any]
PostSetCallback = Callable[[list[Parameter]], Any]


class ParameterSetting:
    """Sets parameters that are declared, asking descriptors and callbacks."""

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

    def has_parameter(self, name: str) -> bool:
        """Tell whether a parameter is declared."""
        return name in self._parameters

    def _is_set(self, name: str) -> bool:
        parameter = self._parameters.get(name)
        return parameter is not None and parameter.type_ is not Parameter.Type.NOT_SET

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
            if self._is_set(name):
                event.changed_parameters.append(message)
            else:
                event.new_parameters.append(message)
            self._parameters[name] = parameter
        event.stamp = self._clock.now().to_msg()
        if self._parameter_event_publisher is not None:
            self._parameter_event_publisher.publish(event)

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
