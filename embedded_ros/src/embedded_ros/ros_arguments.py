"""ROS command-line arguments: what stands between ``--ros-args`` and ``--``."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from embedded_ros import log_output
from embedded_ros.errors import RCLInvalidROSArgsError, UnknownROSArgsError
from embedded_ros.names import expand, join, namespace_error

# Most programs are given no parameters, and every program would wait for PyYAML: what reads YAML
# is imported with the first text to read.
if TYPE_CHECKING:
    from embedded_ros.yaml_values import ParameterValue

__all__ = [
    "NO_ARGUMENTS",
    "RosArguments",
    "parameter_overrides",
    "parse_arguments",
    "without_ros_arguments",
]

_LEVELS = {"unset": 0, "debug": 10, "info": 20, "warn": 30, "error": 40, "fatal": 50}
# rcl keeps names that begin with two underscores for itself.
_WORD = r"(?!__)[A-Za-z_][A-Za-z0-9_]*"
_NODE = re.compile(rf"(?:(?P<node>{_WORD}):)?(?P<rest>.*)", re.DOTALL)
_PARAMETER = re.compile(rf"/?{_WORD}(?:[./]{_WORD})*/?")
_NAME = re.compile(rf"(?:~/|/)?{_WORD}(?:/{_WORD})*")
_NAMESPACE = re.compile(rf"/|(?:/{_WORD})+")
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
    parameters: tuple[tuple[str, str, ParameterValue | None], ...] = ()
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

    def parameters_of(self, node: str, namespace: str) -> dict[str, ParameterValue | None]:
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
) -> dict[str, ParameterValue | None]:
    """Values that arguments give the parameters of a node; earlier arguments win over later."""
    overrides: dict[str, ParameterValue | None] = {}
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
    parameters: list[tuple[str, str, ParameterValue | None]] = []
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
                    parameters.append(_parameter(value))
                case "params file":
                    parameters.extend(_parameters_of_file(value))
                case "log level":
                    levels.append(_log_level(value))
                case "enclave name":
                    enclave = value
        except ValueError as error:
            raise RCLInvalidROSArgsError(
                f"Couldn't parse {what}: '{flag} {value}'. Error: {error}"
            ) from None
    if unknown:
        raise UnknownROSArgsError(repr(unknown))
    fault = namespace_error(enclave)
    if fault is not None:
        reason, place = fault[0].replace("namespace", "context name"), fault[1]
        raise RCLInvalidROSArgsError(
            f"Enclave name is not valid: '{reason}'. Invalid index: {place}"
        )
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
    """Arguments for ROS; what stands for one without saying so gets its flag."""
    words = []
    for word, meaning in _classified(arguments):
        if meaning == "remap rule":
            text = f"Found remap rule '{word}'. This syntax is deprecated. "
            hint = f"Use '--ros-args --remap {word}' instead."
            log_output.output(log_output.Record(30, "rcl", text + hint, "", "", 0))
            words.append("--remap")
        if meaning != "program":
            words.append(word)
    return words


def without_ros_arguments(arguments: Sequence[str]) -> list[str]:
    """Those arguments that are not ROS's, without ``--ros-args`` and its ``--``."""
    return [word for word, meaning in _classified(arguments) if meaning == "program"]


def _classified(arguments: Sequence[str]) -> Iterator[tuple[str, str]]:
    """Arguments, and whether each is for ``ROS``, the ``program`` or a bare ``remap rule``."""
    in_ros = False
    for argument in arguments:
        if argument == "--ros-args":
            in_ros = True
        elif not in_ros:
            yield argument, "remap rule" if _is_remap_rule(argument) else "program"
        elif argument == "--":
            in_ros = False
        else:
            yield argument, "ROS"


def _is_remap_rule(argument: str) -> bool:
    try:
        _remap(argument)
    except ValueError:
        return False
    return True


def _remap(rule: str) -> Remap:
    left, separator, target = rule.partition(":=")
    if not separator or not left or not target:
        raise ValueError("expected [node:]from:=to")
    node, source = _for_node(left)
    kind, expected = "name", _NAME
    match source:
        case "__node" | "__name":
            kind, expected = "__node", re.compile(_WORD)
        case "__ns":
            kind, expected = "__ns", _NAMESPACE
        case _:
            if "://" in source:
                scheme, _, source = source.partition("://")
                kind = {"rostopic": "topic", "rosservice": "service"}.get(scheme, "")
            if not kind or not _NAME.fullmatch(source):
                raise ValueError(f"{source!r} is not a name of a topic or service")
    if not expected.fullmatch(target):
        what = "must be absolute, it must lead with a '/'" if kind == "__ns" else "is not a name"
        raise ValueError(f"{target!r} {what}")
    return Remap(kind, node, source, target)


def _for_node(text: str) -> tuple[str, str]:
    """Name of the node that a rule is for, which may be empty, and what follows it."""
    found = _NODE.fullmatch(text)
    if found is None or found["rest"].startswith("//"):  # the colon of a scheme
        return "", text
    return found["node"] or "", found["rest"]


def _parameter(rule: str) -> tuple[str, str, ParameterValue | None]:
    from embedded_ros.yaml_values import ParameterFileError, typed_value

    left, separator, text = rule.partition(":=")
    node, name = _for_node(left)
    if not separator or not _PARAMETER.fullmatch(name):
        raise ValueError("expected [node:]name:=value, where the name begins with a letter or '_'")
    try:
        return f"/{node or '**'}", name, typed_value(text)
    except ParameterFileError as error:
        raise ValueError(f"value of {name!r}: {error}") from None


def _parameters_of_file(path: str) -> list[tuple[str, str, ParameterValue | None]]:
    from embedded_ros.yaml_values import read_parameter_file

    return read_parameter_file(path)


def _log_level(text: str) -> tuple[str, int]:
    logger, separator, level = text.rpartition(":=")
    if level.lower() not in _LEVELS or ":=" in logger or (separator and not logger):
        raise ValueError(f"{text!r} is not [logger:=]level, where level is {', '.join(_LEVELS)}")
    return logger, _LEVELS[level.lower()]
