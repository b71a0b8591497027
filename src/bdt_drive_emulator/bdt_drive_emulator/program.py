"""The program ``drive_emulator``, as ``ros2 run`` starts it: ``bdt drive-emulator`` without bdt."""

import sys
from argparse import ArgumentParser

from bdt_drive_emulator.commands.drive_emulator import COMMAND
from bdt_msgs_py.command_errors import BAD_INPUT, BadInputError, complain


def main() -> None:
    """Run the emulator and end the process with its exit code."""
    parser = ArgumentParser(prog="drive_emulator", description=COMMAND.description)
    COMMAND.add_arguments(parser)
    try:
        sys.exit(COMMAND.run(parser.parse_args()))
    except BadInputError as error:
        sys.exit(complain(error, BAD_INPUT))
