"""ROS command-line arguments: what stands between ``--ros-args`` and ``--``."""

import re
from collections.abc import Sequence
from dataclasses import dataclass

from embedded_ros.errors import RCLInvalidROSArgsError, UnknownROSArgsError
from embedded_ros.names import expand, join
from embedded_ros.yaml_values import (
    ParameterFileError,
    ParameterValue,
    read_parameter_file,
    typed_value,
)

__all__ = [
    "NO_ARGUMENTS",
    "RosArguments",
    "parameter_overrides",
    "parse_arguments",
    "without_ros_arguments",
]

_LEVELS = {"debug": 10, "info": 20, "warn": 30, "error": 40, "fatal": 50}
_SWITCHES = {
    f"--{state}-{output}"
    for state in ("enable", "disable")
    for output in ("rosout-logs", "stdout-logs", "external-lib-logs")
}


@dataclass(frozen=True)
class Remap:
    """A remapping rule.

    Attributes
    ----------
    kind : str
        ``name``, ``topic``, ``service``, ``__node`` or ``__ns``.
    node : str
        The rule is for this node only; empty: for all.
    source, target : str
        Names as written.
    """

    kind: str
    node: str
    source: str
    target: str


@dataclass(frozen=True)
class RosArguments:
    """Parsed arguments, in the order in which they were given."""

    remaps: tuple[Remap, ...] = ()
    parameters: tuple[tuple[str, str, ParameterValue], ...] = ()
    log_levels: tuple[tuple[str, int], ...] = ()
    switches: frozenset[str] = frozenset()
    enclave: str = "/"

    def node_name(self, name: str) -> str | None:
        """Name that replaces a node's name, if a rule does."""
        return self._special("__node", name)

    def namespace(self, name: str) -> str | None:
        """Namespace that replaces that of a node, if a rule does."""
        return self._special("__ns", name)

    def _special(self, kind: str, name: str) -> str | None:
        for rule in self.remaps:
            if rule.kind == kind and rule.node in ("", name):
                return rule.target
        return None

    def remap(self, full_name: str, node: str, namespace: str, *, is_service: bool) -> str | None:
        """Name that replaces an expanded topic or service name; None if no rule matches."""
        for rule in self.remaps:
            if rule.kind not in ("name", "service" if is_service else "topic"):
                continue
            if rule.node in ("", node) and expand(rule.source, node, namespace) == full_name:
                return expand(rule.target, node, namespace)
        return None

    def parameters_of(self, node: str, namespace: str) -> dict[str, ParameterValue]:
        """Overrides for a node; of several for one parameter the last one counts."""
        full_name = join(namespace, node)
        return {
            name: value
            for pattern, name, value in self.parameters
            if _pattern(pattern).fullmatch(full_name)
        }


NO_ARGUMENTS = RosArguments()


def parameter_overrides(
    arguments: Sequence[RosArguments], node: str, namespace: str
) -> dict[str, ParameterValue]:
    """Values that arguments give the parameters of a node; earlier arguments win over later."""
    overrides: dict[str, ParameterValue] = {}
    for each in reversed(arguments):
        overrides |= each.parameters_of(node, namespace)
    return overrides


def _pattern(text: str) -> re.Pattern[str]:
    """Regular expression of a node pattern: ``*`` is one token, ``**`` any number of them."""
    tokens = []
    for token in text.strip("/").split("/"):
        match token:
            case "**":
                tokens.append("(?:/[^/]+)*")
            case "*":
                tokens.append("/[^/]+")
            case _:
                tokens.append(f"/{re.escape(token)}")
    return re.compile("".join(tokens))


def parse_arguments(arguments: Sequence[str]) -> RosArguments:
    """Parse the ROS arguments among command-line arguments.

    Raises
    ------
    RCLInvalidROSArgsError
        If one is malformed or a parameter file is.
    UnknownROSArgsError
        If there is no such argument.
    """
    remaps: list[Remap] = []
    parameters: list[tuple[str, str, ParameterValue]] = []
    levels: list[tuple[str, int]] = []
    switches: set[str] = set()
    unknown: list[str] = []
    enclave = "/"
    words = iter(ros_words(arguments))
    for flag in words:
        if flag in _SWITCHES:
            switches.add(flag)
            continue
        if flag not in _FLAGS:
            unknown.append(flag)
            continue
        what = _FLAGS[flag]
        value = next(words, None)
        if value is None:
            raise RCLInvalidROSArgsError(f"Couldn't parse trailing {flag} flag. No {what} found.")
        try:
            match what:
                case "remap rule":
                    remaps.append(_remap(value))
                case "parameter override rule":
                    parameters.extend(_parameter(value))
                case "params file":
                    parameters.extend(read_parameter_file(value))
                case "log level":
                    levels.append(_log_level(value))
                case "enclave name":
                    enclave = value if value.startswith("/") else f"/{value}"
        except ValueError as error:
            raise RCLInvalidROSArgsError(
                f"Couldn't parse {what}: '{flag} {value}'. Error: {error}"
            ) from None
    if unknown:
        raise UnknownROSArgsError(repr(unknown))
    return RosArguments(
        tuple(remaps), tuple(parameters), tuple(levels), frozenset(switches), enclave
    )


_FLAGS = {
    "-r": "remap rule",
    "--remap": "remap rule",
    "-p": "parameter override rule",
    "--param": "parameter override rule",
    "--params-file": "params file",
    "--log-level": "log level",
    "-e": "enclave name",
    "--enclave": "enclave name",
}


def ros_words(arguments: Sequence[str]) -> list[str]:
    """Those arguments that stand between ``--ros-args`` and ``--``."""
    return [word for word, is_ros in _classified(arguments) if is_ros]


def without_ros_arguments(arguments: Sequence[str]) -> list[str]:
    """Those arguments that are not ROS's, without ``--ros-args`` and its ``--``."""
    return [word for word, is_ros in _classified(arguments) if not is_ros]


def _classified(arguments: Sequence[str]) -> list[tuple[str, bool]]:
    words = []
    in_ros = False
    for argument in arguments:
        if not isinstance(argument, str):
            raise TypeError(f"an argument must be a str, not {argument!r}")
        argument.encode()  # rcl takes UTF-8 only
        if argument == "--ros-args":
            in_ros = True
        elif in_ros and argument == "--":
            in_ros = False
        else:
            words.append((argument, in_ros))
    return words


def _remap(rule: str) -> Remap:
    left, separator, target = rule.partition(":=")
    if not separator or not left or not target:
        raise ValueError("expected [node:]from:=to")
    kind, node = "name", ""
    for scheme in ("rostopic", "rosservice"):
        if left.startswith(f"{scheme}://"):
            kind, left = scheme.removeprefix("ros"), left.removeprefix(f"{scheme}://")
    target = re.sub(r"^ros(topic|service)://", "", target)
    if ":" in left:
        node, _, left = left.partition(":")
    if left in ("__node", "__name", "__ns"):
        kind = "__ns" if left == "__ns" else "__node"
        if kind == "__ns" and not target.startswith("/"):
            raise ValueError("a namespace must be absolute, it must lead with a '/'")
    if not re.fullmatch(r"[\w/~{}]+", left + target):
        raise ValueError("a name holds letters, digits and '_', '/', '~', '{', '}' only")
    return Remap(kind, node, left, target)


def _parameter(rule: str) -> list[tuple[str, str, ParameterValue]]:
    left, separator, text = rule.partition(":=")
    if not separator or not left:
        raise ValueError("expected [node:]name:=value")
    node, colon, name = left.rpartition(":")
    if not re.fullmatch(r"[A-Za-z_][\w./]*", name) or (colon and not node):
        raise ValueError("expected [node:]name:=value, where the name begins with a letter or '_'")
    try:
        value = typed_value(text)
    except ParameterFileError as error:
        raise ValueError(f"value of {name!r}: {error}") from None
    # rcl drops an empty list, whose type nobody knows.
    return [] if value is None else [(f"/{(node or '**').strip('/')}", name, value)]


def _log_level(text: str) -> tuple[str, int]:
    logger, _, level = text.rpartition(":=")
    if level.lower() not in _LEVELS:
        raise ValueError(f"{level!r} is not one of {', '.join(_LEVELS)}")
    return logger, _LEVELS[level.lower()]
