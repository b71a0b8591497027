"""What others ask of a node's parameters: six services, each a function from request to response.

A request comes from outside: whatever it holds, the response says what is wrong with it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Final

from embedded_ros.errors import ParameterNotDeclaredException, ParameterUninitializedException
from embedded_ros.parameter_messages import listing_message, result_message
from embedded_ros.parameter_rules import Objection
from embedded_ros.parameter_store import ParameterStore
from embedded_ros.parameter_type import ParameterType
from embedded_ros.parameter_value import Parameter

__all__ = ["ANSWERS"]


def _describe(store: ParameterStore, request: Any, response: Any) -> Any:
    response.descriptors = _all_or_none(store.descriptor, request.names)
    return response


def _get(store: ParameterStore, request: Any, response: Any) -> Any:
    parameters = _all_or_none(store.parameter, request.names)
    response.values = [parameter.get_parameter_value() for parameter in parameters]
    return response


def _get_types(store: ParameterStore, request: Any, response: Any) -> Any:
    types = _all_or_none(store.type_of, request.names)
    response.types = [(type_ or ParameterType.NOT_SET).value for type_ in types]
    return response


def _all_or_none(ask: Callable[[str], Any], names: Sequence[str]) -> list[Any]:
    """Answers for all names, or an empty list if there is none for one of them."""
    try:
        return [ask(name) for name in names]
    except (ParameterNotDeclaredException, ParameterUninitializedException):
        return []


def _list(store: ParameterStore, request: Any, response: Any) -> Any:
    response.result = listing_message(store, request.prefixes, request.depth)
    return response


def _set(store: ParameterStore, request: Any, response: Any) -> Any:
    response.results = [result_message(_attempt(store, [item])) for item in request.parameters]
    return response


def _set_atomically(store: ParameterStore, request: Any, response: Any) -> Any:
    response.result = result_message(_attempt(store, request.parameters))
    return response


def _attempt(store: ParameterStore, messages: Sequence[Any]) -> Objection | None:
    wanted = []
    for message in messages:
        try:
            wanted.append(Parameter.from_parameter_msg(message))
        except ValueError:
            return Objection(
                f"Parameter '{message.name}' has a type that does not exist: {message.value.type}"
            )
    try:
        return store.set(wanted)
    except ParameterNotDeclaredException as error:
        return Objection(str(error))


#: By name below the node: the type of the service and what answers its requests.
ANSWERS: Final[dict[str, tuple[str, Callable[[ParameterStore, Any, Any], Any]]]] = {
    "describe_parameters": ("DescribeParameters", _describe),
    "get_parameters": ("GetParameters", _get),
    "get_parameter_types": ("GetParameterTypes", _get_types),
    "list_parameters": ("ListParameters", _list),
    "set_parameters": ("SetParameters", _set),
    "set_parameters_atomically": ("SetParametersAtomically", _set_atomically),
}
