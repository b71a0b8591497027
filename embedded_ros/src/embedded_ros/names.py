"""Rules for names: validation, expansion and the mapping to DDS topics.

The validators return None, or the text and the position that rcl and rmw give for the fault.
"""

import re
from typing import Final

from embedded_ros.errors import InvalidServiceNameException, InvalidTopicNameException

__all__ = [
    "IS_INVALID",
    "expand",
    "expand_valid",
    "full_topic_name_error",
    "join",
    "namespace_error",
    "node_name_error",
    "topic_name_error",
]

_NODE_NAME_LIMIT = 255
_NAMESPACE_LIMIT = 245
_TOPIC_LIMIT = 247
#: Stands between a name and the reason in the texts of :func:`expand`.
IS_INVALID: Final = " is invalid: "

Fault = tuple[str, int]


def _end(name: str) -> int:
    """Position of the last character, in bytes as rcl counts."""
    return len(name.encode("utf-8", "surrogatepass")) - 1


def node_name_error(name: str) -> Fault | None:
    """Fault of a node name."""
    if not name:
        return "node name must not be empty", 0
    if bad := re.search(r"[^A-Za-z0-9_]", name):
        return (
            "node name must not contain characters other than alphanumerics or '_'",
            bad.start(),
        )
    if name[0].isdigit():
        return "node name must not start with a number", 0
    if len(name) > _NODE_NAME_LIMIT:
        return f"node name length should not exceed '{_NODE_NAME_LIMIT}'", _NODE_NAME_LIMIT - 1
    return None


def _absolute_name_error(name: str, what: str) -> Fault | None:
    if bad := re.search(r"[^A-Za-z0-9_/]", name):
        return (
            f"{what} must not contain characters other than alphanumerics, '_', or '/'",
            bad.start(),
        )
    if bad := re.search("//", name):
        return f"{what} must not contain repeated '/'", bad.start() + 1
    if bad := re.search(r"/[0-9]", name):
        return f"{what} must not have a token that starts with a number", bad.start() + 1
    return None


def namespace_error(namespace: str) -> Fault | None:
    """Fault of an absolute namespace."""
    if not namespace:
        return "namespace must not be empty", 0
    if namespace[0] != "/":
        return "namespace must be absolute, it must lead with a '/'", 0
    if namespace == "/":
        return None
    if namespace[-1] == "/":
        return "namespace must not end with a '/', unless only a '/'", _end(namespace)
    fault = _absolute_name_error(namespace, "namespace")
    if fault is None and len(namespace) > _NAMESPACE_LIMIT:
        return f"namespace should not exceed '{_NAMESPACE_LIMIT}'", _NAMESPACE_LIMIT - 1
    return fault


def full_topic_name_error(name: str) -> Fault | None:
    """Fault of an expanded topic or service name."""
    if not name:
        return "topic name must not be empty", 0
    if name[0] != "/":
        return "topic name must be absolute, it must lead with a '/'", 0
    if name[-1] == "/":
        return "topic name must not end with a '/'", _end(name)
    fault = _absolute_name_error(name, "topic name")
    if fault is None and len(name) > _TOPIC_LIMIT:
        return f"topic length should not exceed '{_TOPIC_LIMIT}'", _TOPIC_LIMIT - 1
    return fault


def topic_name_error(name: str) -> Fault | None:
    """Fault of a topic or service name as a user writes it."""
    if not name:
        return "topic name must not be empty string", 0
    if name[0].isdigit():
        return "topic name token must not start with a number", 0
    if name[-1] == "/":
        return "topic name must not end with a forward slash", _end(name)
    fault = _character_error(name)
    if fault is not None:
        return fault
    # rcl lets a single character behind the tilde pass.
    if re.match("~[^/].", name):
        return "topic name must not have a tilde '~' that is not followed by a forward slash '/'", 1
    if bad := re.search(r"/[0-9]", name):
        return "topic name token must not start with a number", bad.start() + 1
    return None


def _character_error(name: str) -> Fault | None:
    opened = -1
    in_substitution = (
        "substitution name must not contain characters other than alphanumerics or '_'"
    )
    unmatched = "topic name must not have unmatched (unbalanced) curly braces '{}'"
    for index, character in enumerate(name):
        if character == "_" or (character.isascii() and character.isalnum()):
            if character.isdigit() and opened >= 0 and index == opened + 1:
                return "substitution name must not start with a number", index
        elif character in "/{" and opened >= 0:
            return in_substitution, index
        elif character == "{":
            opened = index
        elif character == "}":
            if opened < 0:
                return unmatched, index
            opened = -1
        elif character == "~":
            if index:
                return "topic name must not have tilde '~' unless it is the first character", index
        elif character != "/":
            if opened >= 0:
                return in_substitution, index
            allowed = "alphanumerics, '_', '~', '{', or '}'"
            return f"topic name must not contain characters other than {allowed}", index
    return (unmatched, opened) if opened >= 0 else None


def join(namespace: str, name: str) -> str:
    """Fully qualified name of a node or topic in a namespace."""
    return f"{namespace.rstrip('/')}/{name}"


def expand(name: str, node_name: str, namespace: str) -> str:
    """Make a topic or service name absolute.

    Raises
    ------
    ValueError
        If one of the names is invalid or there is no such substitution. The text ends with the
        reason.
    """
    for what, value, fault in (
        ("topic name", name, topic_name_error(name)),
        ("node name", node_name, node_name_error(node_name)),
        ("node namespace", namespace, namespace_error(namespace)),
    ):
        if fault is not None:
            raise ValueError(f"{what} '{value}'{IS_INVALID}{fault[0]}")
    given = name
    if name.startswith("~"):
        name = join(namespace, node_name) + name[1:]
    for substitution, value in (
        ("{node}", node_name),
        ("{namespace}", namespace),
        ("{ns}", namespace),
    ):
        name = name.replace(substitution, value)
    if unknown := re.search(r"\{\w*\}", name):
        raise ValueError(f"topic name '{given}'{IS_INVALID}unknown substitution: {unknown[0]}")
    if name.startswith("/"):
        return name
    return join(namespace, name)


def expand_valid(name: str, node_name: str, namespace: str, *, is_service: bool = False) -> str:
    """Validate a name, expand it and validate the result.

    Raises
    ------
    InvalidTopicNameException, InvalidServiceNameException
    ValueError
        If there is no such substitution.
    """
    invalid = InvalidServiceNameException if is_service else InvalidTopicNameException
    fault = topic_name_error(name)
    if fault is not None:
        raise invalid(name, *fault)
    expanded = expand(name, node_name, namespace)
    fault = full_topic_name_error(expanded)
    if fault is not None:
        raise invalid(expanded, *fault)
    return expanded
