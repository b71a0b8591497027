"""Messages as YAML and CSV, in the shape that ``ros2 topic echo`` gives them."""

import array
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
import yaml

__all__ = ["TextStyle", "to_csv", "to_yaml"]


@dataclass(frozen=True)
class TextStyle:
    """How much of a message is written.

    Attributes
    ----------
    truncate_length : int or None
        Length after which arrays and strings are cut.
    no_arr, no_str : bool
        Whether only the lengths of arrays and strings are written.
    flow_style : bool
        Whether YAML sequences are written in one line.
    """

    truncate_length: int | None = None
    no_arr: bool = False
    no_str: bool = False
    flow_style: bool = False


class _Dumper(yaml.Dumper):
    """Keeps mappings in block style even where sequences are in flow style, as Jazzy does."""


_Dumper.add_representer(
    dict,
    lambda dumper, values: yaml.MappingNode(
        "tag:yaml.org,2002:map",
        [(dumper.represent_data(key), dumper.represent_data(item)) for key, item in values.items()],
    ),
)


def to_yaml(message: Any, style: TextStyle) -> str:
    """Write a message as YAML."""
    return str(
        yaml.dump(
            _plain(message, "", style),
            Dumper=_Dumper,
            allow_unicode=True,
            width=sys.maxsize,
            default_flow_style=style.flow_style,
        )
    )


def to_csv(message: Any, style: TextStyle) -> str:
    """Write all fields of a message in one line, separated by commas.

    Like Jazzy's this puts no comma after empty fields at the beginning of a message.
    """
    return _csv(message, "", style)


def _is_array(value: Any) -> bool:
    return isinstance(value, list | tuple | array.array | np.ndarray)


def _summary(value: Any, type_name: str) -> str:
    """What stands for an array, from a field type such as ``sequence<double, 3>``."""
    if not type_name.startswith("sequence<"):
        return f"<array type: {type_name.replace('/', '/msg/')}>"
    element, _, limit = type_name.removeprefix("sequence<").removesuffix(">").partition(", ")
    element = "string" if element.startswith("string") else element.replace("/", "/msg/")
    bound = f"[{limit}]" if limit else ""
    return f"<sequence type: {element}{bound}, length: {len(value)}>"


def _scalar(value: Any, style: TextStyle) -> Any:
    limit = style.truncate_length
    if isinstance(value, bytes):
        value = "".join(map(chr, value))
    elif isinstance(value, str) and style.no_str:
        return f"<string length: <{len(value)}>>"
    if isinstance(value, str) and limit is not None and len(value) > limit:
        return f"{value[:limit]}..."
    return value.item() if isinstance(value, np.generic) else value


def _plain(value: Any, type_name: str, style: TextStyle) -> Any:
    if hasattr(value, "get_fields_and_field_types"):
        types = value.get_fields_and_field_types()
        return {name: _plain(getattr(value, name), types[name], style) for name in types}
    if not _is_array(value):
        return _scalar(value, style)
    if style.no_arr:
        return _summary(value, type_name)
    items = [_plain(item, "", style) for item in value[: style.truncate_length]]
    return items if len(items) == len(value) else [*items, "..."]


def _csv(value: Any, type_name: str, style: TextStyle) -> str:
    if hasattr(value, "get_fields_and_field_types"):
        types = value.get_fields_and_field_types()
        return _joined(_csv(getattr(value, name), types[name], style) for name in types)
    if not _is_array(value):
        return str(value if isinstance(value, bytes) else _scalar(value, style))
    if style.no_arr and type_name:
        return _summary(value, type_name)
    items = value[: style.truncate_length]
    dots = ["..."] * (len(items) < len(value))
    return _joined((*(_csv(item, "", style) for item in items), *dots))


def _joined(texts: Iterable[str]) -> str:
    line = ""
    for text in texts:
        line = f"{line},{text}" if line else text
    return line
