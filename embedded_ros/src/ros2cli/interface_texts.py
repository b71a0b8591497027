"""Definitions of message and service types as text, in the ``.msg`` and ``.srv`` formats.

With ROS 2 they are read from the ``share`` folders of the packages, comments included. Without,
they come from rosbags' type store and the services of ``embedded_ros``, which hold no comments.
"""

import importlib
import os
import re
from collections.abc import Iterator
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from ros2cli.errors import CommandError, did_you_mean

__all__ = ["definition_lines", "definition_with_dependencies", "interface_names", "nested_type"]

_PRIMITIVES = frozenset(
    {"bool", "byte", "char", "float32", "float64", "string", "wstring"}
    | {f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)}
)
_SEPARATOR = "=" * 80


def definition_lines(type_name: str) -> list[str]:
    """Lines of the definition of a type such as ``std_msgs/msg/String``."""
    package, kind, name = _parts(type_name)
    for prefix in _prefixes():
        path = prefix / "share" / package / kind / f"{name}.{kind}"
        if path.is_file():
            return [line.rstrip() for line in path.read_text(encoding="utf-8").splitlines()]
    lines = _embedded_definition(package, kind, name)
    if lines is None:
        raise CommandError(f"Unknown type '{type_name}'{did_you_mean(type_name, _type_names())}")
    return lines


def _parts(type_name: str) -> list[str]:
    parts = type_name.split("/")
    if len(parts) == 3 and all(parts):
        return parts
    near = did_you_mean(type_name, _type_names())
    raise CommandError(f"'{type_name}' is no type such as std_msgs/msg/String{near}")


def _type_names() -> Iterator[str]:
    for kind in ("msg", "srv", "action"):
        for package, names in interface_names(kind).items():
            yield from (f"{package}/{kind}/{name}" for name in names)


def definition_with_dependencies(type_name: str) -> str:
    """Definition of a message followed by those of all types it holds, as bags carry it."""
    texts = {type_name: "\n".join(definition_lines(type_name))}
    waiting = [type_name]
    while waiting:
        current = waiting.pop(0)
        for line in definition_lines(current):
            nested = nested_type(line, current.split("/")[0])
            if nested and nested not in texts:
                texts[nested] = "\n".join(definition_lines(nested))
                waiting.append(nested)
    main, *others = texts
    sections = [
        f"{_SEPARATOR}\nMSG: {name.replace('/msg/', '/')}\n{texts[name]}" for name in others
    ]
    return "\n".join([texts[main], *sections])


def nested_type(line: str, package: str) -> str | None:
    """Message type of the field in a line; None if there is none or it is a primitive."""
    words = line.partition("#")[0].split()
    if len(words) < 2:
        return None
    base = re.split(r"[\[<]", words[0], maxsplit=1)[0]
    if base in _PRIMITIVES:
        return None
    owner, _, name = base.rpartition("/")
    return f"{owner or package}/msg/{name}"


def interface_names(kind: str) -> dict[str, list[str]]:
    """Names of the types of a kind (``msg``, ``srv`` or ``action``) by their packages, sorted."""
    found: dict[str, set[str]] = {}
    for package, name in (*_indexed_names(kind), *_embedded_names(kind)):
        found.setdefault(package, set()).add(name)
    return {package: sorted(found[package]) for package in sorted(found)}


def _prefixes() -> list[Path]:
    prefixes = os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)
    return [Path(prefix) for prefix in prefixes if prefix]


def _indexed_names(kind: str) -> Iterator[tuple[str, str]]:
    """What the packages of a ROS 2 installation register."""
    for prefix in _prefixes():
        index = prefix / "share" / "ament_index" / "resource_index" / "rosidl_interfaces"
        for path in index.iterdir() if index.is_dir() else ():
            for line in path.read_text(encoding="utf-8").splitlines():
                folder, _, file = line.partition("/")
                if folder == kind and file.endswith(".idl"):
                    yield path.name, file.removesuffix(".idl")


@cache
def _store() -> Any:
    from rosbags.typesys import Stores, get_typestore

    return get_typestore(Stores.ROS2_JAZZY)


@cache
def _embedded_services() -> dict[str, str]:
    """Service definitions of embedded_ros: its counterpart of the ``share`` folders."""
    if find_spec("embedded_ros") is None:
        return {}
    from embedded_ros.service_definitions import SERVICE_DEFINITIONS

    return SERVICE_DEFINITIONS


def _embedded_names(kind: str) -> Iterator[tuple[str, str]]:
    if find_spec("embedded_ros") is None or kind not in ("msg", "srv"):
        return
    known = (*_store().fielddefs, *_embedded_services())
    for package in {name.split("/")[0] for name in known}:
        if find_spec(package) and find_spec(f"{package}.{kind}"):
            module = importlib.import_module(f"{package}.{kind}")
            yield from ((package, name) for name in dir(module))


def _embedded_definition(package: str, kind: str, name: str) -> list[str] | None:
    type_name = f"{package}/{kind}/{name}"
    service = _embedded_services().get(type_name)
    if service is not None:
        return [_relative(line, package) for line in service.strip("\n").splitlines()]
    if kind != "msg" or type_name not in _store().fielddefs or not find_spec(package):
        return None
    message_class = getattr(importlib.import_module(f"{package}.msg"), name, None)
    if message_class is None:
        return None
    text, _ = _store().generate_msgdef(type_name, ros_version=2)
    message = message_class()
    lines = text.partition(_SEPARATOR)[0].strip("\n").splitlines()
    return [_relative(line, package) + _default(line, message) for line in lines]


def _relative(line: str, package: str) -> str:
    """Line without the package where it is the type's own, as definitions are written."""
    return line.removeprefix(f"{package}/")


def _default(line: str, message: Any) -> str:
    """What follows the name of a field whose default is not zero; rosbags drops it."""
    value = getattr(message, line.rsplit(maxsplit=1)[-1], None)
    if isinstance(value, bool | int | float) and value and "=" not in line:
        return f" {value:g}"
    return ""
