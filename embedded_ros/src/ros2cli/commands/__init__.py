"""What can be typed after ``ros2``: one table a command."""

from ros2cli.commands.bag import BAG_COMMAND
from ros2cli.commands.interface import INTERFACE_COMMAND
from ros2cli.commands.node import NODE_COMMAND
from ros2cli.commands.param import PARAM_COMMAND
from ros2cli.commands.plain import PLAIN_COMMANDS
from ros2cli.commands.service import SERVICE_COMMAND
from ros2cli.commands.topic import TOPIC_COMMAND
from ros2cli.grammar import Command, Verb

__all__ = ["COMMANDS"]

COMMANDS: tuple[Verb | Command, ...] = (
    BAG_COMMAND,
    INTERFACE_COMMAND,
    NODE_COMMAND,
    PARAM_COMMAND,
    *PLAIN_COMMANDS,
    SERVICE_COMMAND,
    TOPIC_COMMAND,
)
