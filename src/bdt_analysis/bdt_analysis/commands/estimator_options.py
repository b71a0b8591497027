"""Options of ``bdt analyze`` about estimating the gap again."""

import argparse


def add_estimator_options(command: argparse.ArgumentParser) -> None:
    """Add the options, which ``bdt_analysis.re_estimation.estimator_setup`` checks."""
    command.add_argument(
        "--estimator",
        metavar="KIND",
        help="estimate the gap again from the recorded telemetry: inverse_filter, output_error, or "
        "module:name of a function (model, sampling rate) -> estimator",
    )
    command.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="estimate again with another value of a parameter of the twin, such as "
        "output_error.window=10.0 (repeatable); what is not set is as the bag's parameter events "
        "tell of the twin, else the default",
    )
