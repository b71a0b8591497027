"""Options of ``bdt run`` and ``bdt record`` about the bag, and the recorder's parameters."""

import argparse
import json
from dataclasses import asdict

from bdt_bringup.running.configuration import BadInputError
from bdt_bringup.running.recorder_settings import RecorderSettings

_OPTIONS = {
    "storage": "--storage",
    "compression": "--compression",
    "split_size": "--split-size",
    "split_duration": "--split-duration",
}


def add_recording_options(command: argparse.ArgumentParser) -> None:
    """Add the options; :func:`recorder_settings` reads and checks them."""
    default = RecorderSettings()
    command.add_argument(
        "--storage",
        default=default.storage,
        metavar="KIND",
        help="mcap or sqlite3 (default: %(default)s)",
    )
    command.add_argument(
        "--compression",
        default=default.compression,
        metavar="KIND",
        help="none or zstd (default: %(default)s)",
    )
    command.add_argument(
        "--split-size",
        type=int,
        default=default.split_size,
        metavar="BYTES",
        help="begin a new file from this size on",
    )
    command.add_argument(
        "--split-duration",
        type=float,
        default=default.split_duration,
        metavar="S",
        help="begin a new file after this wall time [s]",
    )


def recorder_settings(
    options: argparse.Namespace, bag: str = "bag", topics: str = ""
) -> RecorderSettings:
    """Return what the options say.

    Parameters
    ----------
    options : argparse.Namespace
        Parsed options.
    bag, topics : str
        See :class:`RecorderSettings`.

    Raises
    ------
    BadInputError
        With one line that names the option, the value and what is allowed.
    """
    values = {name: getattr(options, name) for name in _OPTIONS}
    try:
        return RecorderSettings(bag=bag, topics=topics, **values)
    except ValueError as error:
        text = str(error)
        for name, option in _OPTIONS.items():
            text = text.replace(f"RecorderSettings.{name} ", f"{option} ")
        raise BadInputError(text) from error


def recorder_parameters(settings: RecorderSettings) -> dict[str, str]:
    """Return the recorder's parameters as ``--ros-args -p`` takes them: YAML by name."""
    return {name: json.dumps(value) for name, value in asdict(settings).items()}
