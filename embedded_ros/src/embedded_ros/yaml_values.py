"""Parameter values and parameter files, typed as rcl types them.

rcl's rules differ from YAML's: ``1`` is an integer and ``1.0`` a double, ``0x10`` and ``010`` are
read as C does, a list holds values of one type, and a quoted scalar is always a string.
"""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import yaml

__all__ = ["ParameterFileError", "ParameterValue", "read_parameter_file", "typed_value"]

ParameterValue = bool | int | float | str | list[bool] | list[int] | list[float] | list[str]

_TRUE = {"Y", "y", "yes", "Yes", "YES", "true", "True", "TRUE", "on", "On", "ON"}
_FALSE = {"N", "n", "no", "No", "NO", "false", "False", "FALSE", "off", "Off", "OFF"}
_INTEGER = re.compile(r"[+-]?(0[xX][0-9a-fA-F]+|0[0-7]*|[1-9][0-9]*)")
# What C's strtod takes, and YAML's words.
_DECIMAL = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?")
_HEXADECIMAL = re.compile(
    r"[+-]?0[xX]([0-9a-fA-F]+\.?[0-9a-fA-F]*|\.[0-9a-fA-F]+)([pP][+-]?[0-9]+)?"
)
_NO_NUMBER = re.compile(r"\.(nan|NaN|NAN)|[+-]?(?i:nan(\(\w*\))?)")
_INFINITY = re.compile(r"[+-]?(\.(inf|Inf|INF)|(?i:inf|infinity))")
# A wildcard stands alone between slashes.
_WILD_WORD = re.compile(r"[^/*]\*|\*[^/*]|\*{3}")
_SMALLEST_NORMAL = 2.0**-1022
_TYPE_NAMES = {bool: "bool", int: "integer", float: "double", str: "string"}


class _Loader(yaml.SafeLoader):
    """Reads YAML without aliases, as rcl does."""

    def compose_node(self, parent: yaml.Node | None, index: Any) -> yaml.Node | None:
        """Compose the next node."""
        if self.check_event(yaml.AliasEvent):
            raise ParameterFileError(f"line {self.line + 1}: an alias has no meaning here")
        return super().compose_node(parent, index)


class ParameterFileError(ValueError):
    """A parameter value or file that rcl does not take; the text says where and why."""


def typed_value(text: str) -> ParameterValue | None:
    """Value of the YAML text after ``name:=`` on a command line.

    None for an empty list, whose type nobody knows: rcl hands it on as a value that is not set.
    """
    try:
        node = yaml.compose(text, Loader=_Loader)
    except yaml.YAMLError as error:
        raise ParameterFileError(f"not YAML: {_one_line(error)}") from None
    if node is None:
        raise ParameterFileError("no value")
    return _value(node)


def read_parameter_file(path: str) -> list[tuple[str, str, ParameterValue | None]]:
    """Read a ROS parameter file.

    Parameters
    ----------
    path : str

    Returns
    -------
    list of (node pattern, parameter name, value)
        In the order of the file. The pattern is absolute and may hold ``*`` and ``**``.

    Raises
    ------
    ParameterFileError
    """
    try:
        root = yaml.compose(Path(path).read_text(encoding="utf-8"), Loader=_Loader)
    except OSError as error:
        raise ParameterFileError(f"cannot read {path!r}: {error.strerror}") from None
    except UnicodeDecodeError:
        raise ParameterFileError(f"{path!r} is not a text file") from None
    except yaml.YAMLError as error:
        raise ParameterFileError(f"{path!r} is not YAML: {_one_line(error)}") from None
    if root is None:
        return []
    try:
        return list(_nodes(root, ""))
    except ParameterFileError as error:
        raise ParameterFileError(f"{path!r}: {error}") from None


def _one_line(error: yaml.YAMLError) -> str:
    return " ".join(str(error).split())


def _entries(node: yaml.Node, what: str) -> Iterator[tuple[str, yaml.Node]]:
    if not isinstance(node, yaml.MappingNode):
        raise ParameterFileError(f"line {_line(node)}: {what} must be a mapping")
    for key, value in node.value:
        if not isinstance(key, yaml.ScalarNode) or not key.value:
            raise ParameterFileError(f"line {_line(key)}: a key must be a name")
        yield key.value, value


def _line(node: yaml.Node) -> int:
    return int(node.start_mark.line) + 1


def _nodes(node: yaml.Node, prefix: str) -> Iterator[tuple[str, str, ParameterValue | None]]:
    for key, value in _entries(node, "a node or namespace"):
        if key == "ros__parameters":
            if not prefix:
                raise ParameterFileError(
                    f"line {_line(value)}: 'ros__parameters' stands below no node name"
                )
            for name, parameter in _parameters(value, ""):
                yield prefix, name, parameter
        else:
            if isinstance(value, yaml.ScalarNode | yaml.SequenceNode):
                raise ParameterFileError(
                    f"line {_line(value)}: {key!r} stands outside of 'ros__parameters'"
                )
            if (prefix and key.startswith("/")) or _WILD_WORD.search(key):
                raise ParameterFileError(f"line {_line(value)}: {key!r} names no node or namespace")
            yield from _nodes(value, f"{prefix}/{key.strip('/')}")


def _parameters(node: yaml.Node, prefix: str) -> Iterator[tuple[str, ParameterValue | None]]:
    for key, value in _entries(node, "'ros__parameters'"):
        name = f"{prefix}.{key}" if prefix else key
        if isinstance(value, yaml.MappingNode) and value.value:
            yield from _parameters(value, name)
        elif isinstance(value, yaml.MappingNode):
            yield name, None
        else:
            yield name, _value(value)


def _value(node: yaml.Node) -> ParameterValue | None:
    if isinstance(node, yaml.ScalarNode):
        return _scalar(node)
    if not isinstance(node, yaml.SequenceNode):
        raise ParameterFileError(f"line {_line(node)}: a value must be a scalar or a list")
    values: list[Any] = []
    for item in node.value:
        if not isinstance(item, yaml.ScalarNode):
            raise ParameterFileError(f"line {_line(item)}: a list holds scalars only")
        value = _scalar(item)
        if values and type(value) is not type(values[0]):
            raise ParameterFileError(
                "Sequence should be of same type. Value type "
                f"'{_TYPE_NAMES[type(value)]}' do not belong at line_num {_line(item)}"
            )
        values.append(value)
    return values or None


def _scalar(node: yaml.ScalarNode) -> bool | int | float | str:
    text: str = node.value
    explicit = node.tag.removeprefix("tag:yaml.org,2002:") if _has_explicit_tag(node) else ""
    if node.style in ("'", '"') or explicit == "str":
        return text
    if not text:
        raise ParameterFileError(f"No value at line {_line(node)}")
    if text in _TRUE:
        return True
    if text in _FALSE:
        return False
    if _INTEGER.fullmatch(text):
        digits = text.lstrip("+-")
        is_octal = len(digits) > 1 and digits[0] == "0" and digits[1] not in "xX"
        number = int(text, 8) if is_octal else int(text, 0)
        if -(2**63) <= number < 2**63:
            return number
    double = _double(text)
    return text if double is None else double


def _double(text: str) -> float | None:
    if _NO_NUMBER.fullmatch(text):
        return float("nan")
    if _INFINITY.fullmatch(text):
        return float(text.replace(".", ""))
    if _DECIMAL.fullmatch(text):
        double = float(text)
    elif _HEXADECIMAL.fullmatch(text):
        double = float.fromhex(text)
    else:
        return None
    # Too large or too small for a double: C says so, and rcl takes it for text.
    is_zero = not re.search(r"[1-9]", re.split("[eE]", text)[0])
    fits = double == 0.0 if is_zero else _SMALLEST_NORMAL <= abs(double) < float("inf")
    return double if fits else None


def _has_explicit_tag(node: yaml.ScalarNode) -> bool:
    """Whether the tag was written: the resolver would give plain text another one."""
    resolver: Any = yaml.SafeLoader("")
    return bool(node.tag != resolver.resolve(yaml.ScalarNode, node.value, (not node.style, False)))
