"""A namespace for a whole loop: two of them in one ROS domain do not meet."""

import re

from bdt_msgs_py.command_errors import BadInputError
from bdt_msgs_py.topics import CLOCK

NAMESPACE = re.compile(r"(/[A-Za-z_][A-Za-z0-9_]*)*")


def full_namespace(name: str | None) -> str:
    """Return the namespace that ``--namespace`` names: ``/left``; "" for that of the root.

    Raises
    ------
    BadInputError
        For what cannot be a namespace.
    """
    namespace = f"/{(name or '').strip('/')}".rstrip("/")
    if not NAMESPACE.fullmatch(namespace):
        raise BadInputError(
            f"--namespace {name}: must consist of letters, digits and _, with / between names, "
            "none of which begins with a digit"
        )
    return namespace


def namespace_arguments(namespace: str) -> list[str]:
    """Return what follows ``--ros-args`` for a node of a loop in a namespace.

    The clock is an absolute name, in rclpy as well: only a rule moves it, which therefore belongs
    to every node.

    Parameters
    ----------
    namespace : str
        From :func:`full_namespace`.
    """
    if not namespace:
        return []
    return ["-r", f"__ns:={namespace}", "-r", f"{CLOCK.name}:={CLOCK.name.lstrip('/')}"]
