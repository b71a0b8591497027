"""The command ``bdt drive-emulator``: a serial drive where there is none."""

import threading
from argparse import ArgumentParser, Namespace
from pathlib import Path

from bdt_drive_emulator.emulator_settings import EmulatorSettings
from bdt_msgs_py.command_errors import BadInputError
from bdt_msgs_py.commands import Command
from bdt_msgs_py.quantity_options import add_quantity_options, quantities_from_options

OPTIONS = ("clock_error", "jitter", "frame_rate", "seed")
"""Settings that are options."""


def add_arguments(parser: ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument(
        "--config",
        metavar="NAME|FILE",
        default="workshop",
        help="configuration whose plant is the mechanism (default: %(default)s)",
    )
    parser.add_argument(
        "--link", type=Path, metavar="PATH", help="symbolic link to the port, for a name that stays"
    )
    add_quantity_options(parser, EmulatorSettings, OPTIONS)


def run(options: Namespace) -> int:
    """Run the emulator until Ctrl-C or SIGTERM."""
    # The list of commands needs no numpy.
    from bdt_drive_emulator.drive_emulator import DriveEmulator  # noqa: PLC0415
    from bdt_drive_emulator.mechanism import load_mechanism  # noqa: PLC0415
    from bdt_msgs_py.configuration_files import find_configuration  # noqa: PLC0415
    from bdt_msgs_py.stop_signals import StopSignals  # noqa: PLC0415

    settings = quantities_from_options(EmulatorSettings, options, OPTIONS)
    mechanism = load_mechanism(find_configuration(options.config), settings.frame_rate)
    ended = threading.Event()
    with StopSignals(on_request=ended.set):
        try:
            emulator = DriveEmulator(mechanism, settings, options.link)
        except OSError as error:
            raise BadInputError(f"--link {options.link}: {error.strerror or error}") from error
        try:
            print(f"port: {options.link or emulator.port}", flush=True)
            emulator.run(ended)
        finally:
            emulator.close()
    return 0


COMMAND = Command(
    summary="emulate a serial drive behind a pseudo-terminal",
    description="Run a simulated mechanism in real time behind a pseudo-terminal that speaks the "
    "serial protocol, until Ctrl-C.",
    add_arguments=add_arguments,
    run=run,
)
