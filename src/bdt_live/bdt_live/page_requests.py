"""What a page may ask for: one JSON object a message, checked field by field."""

import json
import math
import re
from dataclasses import dataclass

LARGEST_MESSAGE = 4096
"""Bytes of a message from a page."""

LARGEST_NUMBER = 2**31
"""Of the numbers by which pages know their requests."""

NODES = ("plant", "driver", "controller", "twin")
"""Nodes whose parameters a page may set."""

PRESETS = ("linear", "fixed_dead_zone", "paper")
"""Packaged configurations that are one click: figures 3, 4 and 7."""

PARAMETER_NAME = re.compile(r"[a-z][a-z0-9_]*(\.[a-z][a-z0-9_]*){0,4}")
LONGEST_TEXT = 200

ParameterValue = bool | int | float | str


class PageRequestError(ValueError):
    """A message from a page that is not obeyed; the text is one line that says why."""


@dataclass(frozen=True)
class PageRequest:
    """A request.

    Attributes
    ----------
    number : int
        By which the page knows the answer.
    action : str
        ``set``, ``pause``, ``resume``, ``step``, ``pace``, ``wear``, ``mark``, ``save`` or
        ``preset``.
    node : str
        For ``set``: whose parameters.
    values : tuple of (str, value)
        For ``set``: parameters by name, all or none of them.
    amount : float
        For ``pace``, simulated seconds in a second.
    preset : str
        For ``preset``: one of ``PRESETS``.
    """

    number: int
    action: str
    node: str = ""
    values: tuple[tuple[str, ParameterValue], ...] = ()
    amount: float = 0.0
    preset: str = ""


WITHOUT_FIELDS = ("pause", "resume", "step", "wear", "mark", "save")
SLOWEST, FASTEST = 0.1, 10.0
"""Pace that a page may ask for."""
MOST_VALUES = 8


def read_request(text: str) -> PageRequest:
    """Return the request that a message is.

    Raises
    ------
    PageRequestError
        If it is none.
    """
    if len(text) > LARGEST_MESSAGE:
        raise PageRequestError(f"{len(text)} characters: must be {LARGEST_MESSAGE} at most")
    try:
        message = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise PageRequestError("must be a JSON object") from error
    if not isinstance(message, dict):
        raise PageRequestError("must be a JSON object")
    number, action = message.pop("number", None), message.pop("action", None)
    if type(number) is not int or not 0 <= number < LARGEST_NUMBER:
        raise PageRequestError(f"number: must be 0 to {LARGEST_NUMBER - 1}")
    if action in WITHOUT_FIELDS:
        _only(message)
        return PageRequest(number, action)
    if action == "set":
        _only(message, "node", "values")
        return PageRequest(number, action, _node(message), _values(message))
    if action == "pace":
        _only(message, "amount")
        return PageRequest(number, action, amount=_pace(message))
    if action == "preset":
        _only(message, "preset")
        if message["preset"] not in PRESETS:
            raise PageRequestError(f"preset: must be one of {', '.join(PRESETS)}")
        return PageRequest(number, action, preset=message["preset"])
    raise PageRequestError("action: is not known")


def _only(message: dict[str, object], *names: str) -> None:
    if set(message) != set(names):
        raise PageRequestError(
            f"must have the fields number, action{''.join(f', {x}' for x in names)}"
        )


def _node(message: dict[str, object]) -> str:
    node = message["node"]
    if not isinstance(node, str) or node not in NODES:
        raise PageRequestError(f"node: must be one of {', '.join(NODES)}")
    return node


def _values(message: dict[str, object]) -> tuple[tuple[str, ParameterValue], ...]:
    values = message["values"]
    if not isinstance(values, dict) or not 1 <= len(values) <= MOST_VALUES:
        raise PageRequestError(f"values: must be an object with 1 to {MOST_VALUES} parameters")
    for name, value in values.items():
        if len(name) > LONGEST_TEXT or not PARAMETER_NAME.fullmatch(name):
            raise PageRequestError("values: has a name that no parameter has")
        _check_value(name, value)
    return tuple(values.items())


def _check_value(name: str, value: object) -> None:
    if isinstance(value, float) and not math.isfinite(value):
        raise PageRequestError(f"{name}: must be finite")
    if isinstance(value, int) and abs(value) >= 2**63:
        raise PageRequestError(f"{name}: must be below 2^63")
    if isinstance(value, str) and (len(value) > LONGEST_TEXT or not value.isprintable()):
        raise PageRequestError(f"{name}: must be {LONGEST_TEXT} printable characters at most")
    if not isinstance(value, (bool, int, float, str)):
        raise PageRequestError(f"{name}: must be a number, a text, true or false")


def _pace(message: dict[str, object]) -> float:
    amount = message["amount"]
    if isinstance(amount, bool) or not isinstance(amount, (int, float)):
        raise PageRequestError("amount: must be a number")
    if not SLOWEST <= amount <= FASTEST:
        raise PageRequestError(f"amount: must be {SLOWEST:g} to {FASTEST:g}")
    return float(amount)
