"""``bdt tune``: options, files and output around :mod:`bdt_study.tuning.tune`."""

import argparse
import json
import math
from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import yaml
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from bdt_controller.parameters import PARAMETERS as CONTROLLER_PARAMETERS
from bdt_controller.pid import PidGains
from bdt_msgs_py.command_errors import BadInputError
from bdt_msgs_py.output_files import not_writable, prepare_output
from bdt_msgs_py.parameter_files import PARAMETERS_KEY
from bdt_msgs_py.parameter_tables import check_value, known_parameters, parameter_sets
from bdt_msgs_py.topics import CONTROLLER_NODE, DRIVER_NODE, PLANT_NODE, TWIN_NODE
from bdt_plant.plant import Sampling
from bdt_study.calibration.calibrated_configuration import nested
from bdt_study.calibration.start_values import Configuration, read_configuration, start_model
from bdt_study.engine.chosen_engine import chosen_engine
from bdt_study.tuning.mechanism_ranges import MechanismRanges, read_ranges
from bdt_study.tuning.targets import Targets
from bdt_study.tuning.tune import Tuner, Tuning
from bdt_study.tuning.tuning_table import candidates_table, verdict
from bdt_twin.decision_settings import DecisionSettings

FEWEST = 10
"""Smallest number of random loops that says anything."""
MOST = 1_000_000

HEADER = """\
# What `bdt tune` recommends: {name}, dead zone {ratio:g} times eq. 9 and a margin.
# {verdict}
"""


def run_tuning(options: argparse.Namespace) -> int:
    """Run the command and return its exit code.

    Raises
    ------
    BadInputError
        For options or files that are not as they must be.
    """
    for name in ("screening", "loops"):
        value = getattr(options, name)
        if not FEWEST <= value <= MOST:
            raise BadInputError(f"--{name} {value}: must be {FEWEST} to {MOST}")
    if not 0 <= options.seed <= MOST:
        raise BadInputError(f"--seed {options.seed}: must be 0 to {MOST}")
    targets = _targets(options.bandwidth, options.phase_margin)
    configuration = None if options.config is None else read_configuration(options.config)
    control_rate = _control_rate(configuration)
    ranges = _ranges(options.calibration, options.range)
    if options.output is not None:
        prepare_output("--output", options.output)
    nominal = start_model(configuration, {})
    if not nominal.is_piecewise_linear:
        raise BadInputError(f"--config {options.config}: the mechanism is not linear")
    with chosen_engine(options.workers) as engine, _progress() as progress:
        task = progress.add_task("", total=None)

        def tell(what: str, done: int, total: int) -> None:
            progress.update(task, description=what, completed=done, total=total)

        gains = _gains(configuration)
        tuner = Tuner(engine, nominal, ranges, gains, targets, control_rate, tell)
        result = tuner.tune(options.screening, options.loops, options.seed)
    if options.output is not None:
        try:
            options.output.write_text(tuned_text(configuration, result), encoding="utf-8")
        except OSError as error:
            raise not_writable("--output", options.output, error) from error
    if options.json:
        print(json.dumps(tuning_dictionary(result), indent=2))
    else:
        _print(result, options.output)
    return 0


def tuning_dictionary(result: Tuning) -> dict[str, Any]:
    """Return a result for JSON."""
    return {
        "ranges": asdict(result.ranges),
        "targets": asdict(result.targets),
        "control_rate": result.control_rate,
        "candidates": [
            {**one.to_dictionary(), "lacks": result.lacks(one)} for one in result.screened
        ],
        "as_it_is_nominal": result.baseline.to_dictionary(),
        "as_it_is": result.before.to_dictionary(),
        "recommended": {
            **result.recommended.to_dictionary(),
            "lacks": result.lacks(result.recommended),
        },
        "targets_met": result.is_met,
        "why": verdict(result),
    }


def tuned_text(configuration: Configuration | None, result: Tuning) -> str:
    """Return the configuration with what is recommended as the text of a ROS parameter file."""
    recommended = result.recommended.tried
    design, rule = recommended.design, recommended.dead_zone
    law = {
        **{f"pid.{name}": value for name, value in asdict(design.gains).items()},
        **{f"notch.{name}": value for name, value in asdict(design.notch).items()},
    }
    values = {node: dict(given) for node, given in (configuration or {}).items()}
    values.setdefault(CONTROLLER_NODE, {}).update(law)
    # A twin that simulates has to know what the controller has.
    values.setdefault(TWIN_NODE, {}).update(
        {
            **law,
            "decision.control_rate": result.control_rate,
            "dead_zone.ratio": rule.ratio,
            "dead_zone.margin": rule.margin,
        }
    )
    document = {
        f"/**/{node}": {PARAMETERS_KEY: nested(given)} for node, given in values.items() if given
    }
    header = HEADER.format(name=design.name, ratio=rule.ratio, verdict=verdict(result))
    return header + yaml.safe_dump(document, sort_keys=False, default_flow_style=None)


def _ranges(calibration: Path | None, by_hand: Sequence[str]) -> MechanismRanges:
    """Return the ranges of a calibration, else those of ``harsh``, with those by hand."""
    ranges = MechanismRanges() if calibration is None else read_ranges(calibration)
    for text in by_hand:
        name, _, number = text.partition("=")
        if name not in vars(ranges):
            raise BadInputError(
                f"--range {text}: must be NAME=SHARE with one of {', '.join(vars(ranges))}"
            )
        try:
            ranges = replace(ranges, **{name: float(number)})
        except ValueError as error:
            raise BadInputError(f"--range {text}: {error}") from error
    return ranges


def _targets(bandwidth: float | None, phase_margin: float | None) -> Targets:
    """Return what is asked for; `bandwidth` in rad/s, `phase_margin` in degrees."""
    asked = {} if bandwidth is None else {"bandwidth": bandwidth}
    if phase_margin is not None:
        asked["phase_margin"] = math.radians(phase_margin)
    try:
        return Targets(**asked)
    except ValueError as error:
        raise BadInputError(f"--bandwidth, --phase-margin: {error}") from error


def _control_rate(configuration: Configuration | None) -> float:
    """Return the rate of measurements [Hz]: the driver's, else that of the plant.

    Raises
    ------
    BadInputError
        For one that is not allowed.
    """
    default, described = known_parameters((("", DecisionSettings),))["control_rate"]
    for node in (DRIVER_NODE, PLANT_NODE):
        rate = (configuration or {}).get(node, {}).get("control_rate")
        if rate is not None:
            # What a twin takes that simulates this loop; the driver's section is not checked yet.
            check_value(f"--config: {node}: control_rate", rate, default, described)
            return float(rate)
    return Sampling().control_rate


def _gains(configuration: Configuration | None) -> PidGains:
    """Return the controller's gains so far."""
    values = (configuration or {}).get(CONTROLLER_NODE, {})
    try:
        sets = parameter_sets(CONTROLLER_PARAMETERS, values)
    except ValueError as error:
        raise BadInputError(f"--config: {error}") from error
    return next(one for one in sets if isinstance(one, PidGains))


def _print(result: Tuning, output: Path | None) -> None:
    console = Console()
    console.print(candidates_table(result))
    lines = [verdict(result)]
    if output is not None:
        lines.append(f"parameters: {output}")
    for line in lines:
        console.print(line, soft_wrap=True, highlight=False, markup=False)


def _progress() -> Progress:
    return Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
        console=Console(stderr=True),
        transient=True,
    )
