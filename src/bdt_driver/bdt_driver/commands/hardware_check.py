"""The command ``bdt hardware-check``: does a drive keep the contract with the driver node."""

import json
from argparse import ArgumentParser, Namespace
from collections.abc import Mapping, Sequence
from typing import Any

from bdt_driver.parameters import PARAMETERS
from bdt_msgs_py.command_errors import FAILED, BadInputError, complain
from bdt_msgs_py.commands import Command

OPTION_PREFIX = "drive."
MOVING_LIMITS = ("limits.voltage", "limits.lowest_position", "limits.highest_position")
"""Parameters without which nothing is moved."""


def _add_arguments(parser: ArgumentParser) -> None:
    parser.add_argument("driver", metavar="MODULE:NAME", help="class of the drive")
    parser.add_argument(
        "-p",
        "--param",
        dest="parameters",
        action="append",
        default=[],
        metavar="NAME:=VALUE",
        help="parameter of the driver node, as for `ros2 run`: control_rate, sampling_rate, "
        "limits.*, and drive.* for the arguments of the class",
    )
    parser.add_argument(
        "--yes",
        action="store_true",
        help="move the machine, by a twentieth of its travel at a time; needs "
        f"{', '.join(MOVING_LIMITS)} as -p",
    )
    parser.add_argument("--json", action="store_true", help="print all results as JSON")


def _run(options: Namespace) -> int:
    # The list of commands needs no numpy.
    from bdt_driver.hardware_check.drive_stand import DriveStand  # noqa: PLC0415
    from bdt_driver.hardware_check.report import (  # noqa: PLC0415
        as_json,
        result_lines,
        summary_line,
    )
    from bdt_driver.hardware_check.runner import run_checks  # noqa: PLC0415
    from bdt_driver.hardware_check.steady_clock import ComputerClock  # noqa: PLC0415

    given = parameters_given(options.parameters)
    missing = [name for name in MOVING_LIMITS if name not in given]
    if options.yes and missing:
        raise BadInputError(f"--yes: needs the limits of the motion: -p {missing[0]}:=...")
    settings, limits, arguments = _settings(options.driver, given)
    stand = DriveStand(arguments, settings, limits, ComputerClock())
    results = []
    try:
        for result in run_checks(stand, may_move=options.yes):
            results.append(result)
            if not options.json:
                print("\n".join(result_lines(result)), flush=True)
    finally:
        faults = stand.end()
    print(json.dumps(as_json(results), indent=2) if options.json else summary_line(results))
    if faults:
        return complain(f"the drive does not end: {faults[0]}", FAILED)
    return FAILED if as_json(results)["failed"] else 0


def parameters_given(texts: Sequence[str]) -> dict[str, Any]:
    """Return the values of ``NAME:=VALUE`` by name.

    Raises
    ------
    BadInputError
        For a text that is none.
    """
    # The list of commands needs no YAML parser.
    import yaml  # noqa: PLC0415

    given = {}
    for text in texts:
        name, separator, value = text.partition(":=")
        try:
            if not (separator and name):
                raise BadInputError(f"-p {text}: must be NAME:=VALUE")
            given[name] = yaml.safe_load(value)
        except yaml.YAMLError as error:
            raise BadInputError(f"-p {text}: is not YAML: {error}") from error
    return given


def _settings(driver: str, given: Mapping[str, Any]) -> tuple[Any, Any, dict[str, Any]]:
    """Return the driver's settings, its limits, and the arguments of the class."""
    from bdt_msgs_py.parameter_files import checked_parameters  # noqa: PLC0415
    from bdt_msgs_py.parameter_tables import in_parameter_names, parameter_sets  # noqa: PLC0415

    arguments = {
        name.removeprefix(OPTION_PREFIX): value
        for name, value in given.items()
        if name.startswith(OPTION_PREFIX)
    }
    own = {name: value for name, value in given.items() if not name.startswith(OPTION_PREFIX)}
    values = checked_parameters("-p", {**own, "driver": driver}, PARAMETERS, for_all=False)
    try:
        settings, limits, _ = parameter_sets(PARAMETERS, values)
    except ValueError as error:
        raise BadInputError(in_parameter_names(str(error), PARAMETERS)) from error
    return settings, limits, arguments


COMMAND = Command(
    summary="check a drive of your own against what the driver relies on",
    description="Check point by point whether a drive keeps the contract with the driver node. "
    "Without --yes nothing is moved.",
    add_arguments=_add_arguments,
    run=_run,
)
