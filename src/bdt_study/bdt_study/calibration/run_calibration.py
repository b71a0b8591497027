"""``bdt calibrate``: options, files and output around :mod:`bdt_study.calibration.calibrate`."""

import argparse
import json
import math
from pathlib import Path

from rich.box import SIMPLE
from rich.console import Console
from rich.table import Table

from bdt_analysis.commands.topic_options import topic_selection
from bdt_msgs_py.command_errors import BadInputError
from bdt_msgs_py.output_files import not_writable, prepare_output, real_path
from bdt_study.calibration.calibrate import Calibration, calibrate
from bdt_study.calibration.calibrated_configuration import (
    calibrated_configuration,
    configuration_text,
)
from bdt_study.calibration.calibration_data import SHORTEST
from bdt_study.calibration.constant_rows import constant_rows, hints
from bdt_study.calibration.start_values import model_values, read_configuration

LONGEST = 600.0
"""Longest telemetry that is looked at [s]."""
REPORT_FILE = "report.html"


def run_calibration(options: argparse.Namespace) -> int:
    """Run the command and return its exit code."""
    if not SHORTEST <= options.seconds <= LONGEST:
        raise BadInputError(f"--seconds {options.seconds:g}: must be {SHORTEST:g} to {LONGEST:g}")
    configuration = None if options.config is None else read_configuration(options.config)
    report = None if options.report is None else options.report / REPORT_FILE
    for option, path in (("--output", options.output), ("--report", report)):
        if path is not None:
            _refuse_bag(option, path, options.bag)
            prepare_output(option, path)
    result = calibrate(
        options.bag,
        configuration,
        seconds=options.seconds,
        selection=topic_selection(options),
        run=options.run,
        known=options.known,
    )
    if options.output is not None:
        found = calibrated_configuration(
            configuration, model_values(result.start), result.constants
        )
        text = configuration_text(found, options.bag.name, result.constants)
        _write("--output", options.output, text)
    if report is not None:
        # Nothing else here needs the plotting library.
        from bdt_study.calibration.report import render_report  # noqa: PLC0415

        _write("--report", report, render_report(result, options.bag.name))
    if options.json:
        print(json.dumps(result.to_dictionary(), indent=2))
    else:
        _print(result, options.output, report)
    return 0


def _refuse_bag(option: str, path: Path, bag: Path) -> None:
    if real_path(path).is_relative_to(real_path(bag)):
        raise BadInputError(f"{option} {path}: is the bag, which is left as it is")


def _write(option: str, path: Path, text: str) -> None:
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise not_writable(option, path, error) from error


def _print(result: Calibration, output: Path | None, report: Path | None) -> None:
    console = Console()
    table = Table(title="the machine that was found", box=SIMPLE, padding=(0, 1, 0, 0))
    table.add_column("constant", no_wrap=True)
    for name in ("found", "±", "± given *"):
        table.add_column(name, justify="right", no_wrap=True)
    table.add_column("unit", no_wrap=True)
    table.add_column("told", no_wrap=True)
    for row in constant_rows(result):
        told = "given *" if row.given else "yes"
        table.add_row(
            row.name,
            row.value,
            row.uncertainty,
            row.given_only,
            row.unit,
            told if row.determined else "no",
        )
    console.print(table)
    degrees, doubt = math.degrees(result.gap), math.degrees(result.gap_uncertainty)
    fitted, validated = 1e6 * result.residual.rms, 1e6 * result.validation.rms
    lines = [
        "* if the constants that are not told have their start values; --known says that they do",
        f"gap: {degrees:.3f} deg ± {doubt:.2g} deg at {result.gap_time:.2f} s",
        f"residual: {fitted:.3g} um rms; second half, machine of the first: {validated:.3g} um",
        *([result.unexplained] if result.unexplained else []),
        *(f"not told: {hint}" for hint in hints(result)),
    ]
    for label, path in (("parameters", output), ("report", report)):
        if path is not None:
            lines.append(f"{label}: {path}")
    for line in lines:
        console.print(line, soft_wrap=True, highlight=False, markup=False)
