"""One row of a data set as a full run of the nodes, with a bag and a report."""

from argparse import ArgumentParser
from importlib.metadata import entry_points
from pathlib import Path

import yaml

from bdt_msgs_py.command_errors import BadInputError
from bdt_msgs_py.commands import COMMAND_GROUP, Command
from bdt_msgs_py.output_files import not_writable
from bdt_msgs_py.parameter_files import PARAMETERS_KEY
from bdt_msgs_py.topics import CONTROLLER_NODE, PLANT_NODE, TWIN_NODE
from bdt_study.calibration.calibrated_configuration import nested
from bdt_study.sweep.run_batch import changes_of
from bdt_study.sweep.study import Study
from bdt_study.sweep.sweep_table import open_study, read_run

FOLDER = "replays"
"""Folder of the runs within that of a sweep, where nothing else is asked for."""
RUN_COMMAND = "run"

HEADER = """\
# Run {run} of the sweep {name}: written by bdt sweep replay.
"""


def replay(folder: Path, run: int, output: Path | None, *, as_json: bool) -> int:
    """Run the nodes with the parameters of a row, and return the exit code.

    Parameters
    ----------
    folder : Path
        Folder of the sweep.
    run : int
        Number of the run.
    output : Path or None
        Folder for bag and report; None for one in that of the sweep.
    as_json : bool
        Whether to print the summary of the run.

    Raises
    ------
    BadInputError
        If there is no such run, or the package that runs nodes is not installed.
    """
    study = open_study(folder)
    text = run_configuration(study, read_run(folder, run))
    points = entry_points(group=COMMAND_GROUP, name=RUN_COMMAND)
    if not points:
        raise BadInputError("bdt sweep replay: needs the package bdt_bringup, install it")
    output = output or folder / FOLDER / f"run-{run}"
    configuration = output.with_name(f"{output.name}.yaml")
    try:
        configuration.parent.mkdir(parents=True, exist_ok=True)
        configuration.write_text(text, encoding="utf-8")
    except OSError as error:
        raise not_writable("--output", configuration, error) from error
    (point,) = points
    command: Command = point.load()
    parser = ArgumentParser()
    command.add_arguments(parser)
    arguments = ["--config", str(configuration), "--output", str(output)]
    return command.run(parser.parse_args([*arguments, *(["--json"] if as_json else [])]))


def run_configuration(study: Study, row: dict[str, object]) -> str:
    """Return a row as the text of a ROS parameter file.

    Parameters
    ----------
    study : Study
        The study.
    row : dict
        The row by the names of its columns.
    """
    values = study.node_values()
    for (node, name), value in changes_of(
        study.axes, [row[axis.name] for axis in study.axes]
    ).items():
        values.setdefault(node, {})[name] = value
    values.setdefault(PLANT_NODE, {}).update(
        {"duration": study.duration, "sensor.seed": row["seed"]}
    )
    values.setdefault(CONTROLLER_NODE, {})["use_sim_time"] = True
    values.setdefault(TWIN_NODE, {}).update({"use_sim_time": True, "link_seed": row["seed"]})
    if not study.has_twin:
        values[TWIN_NODE]["reconfigure"] = False
    document = {
        f"/**/{node}": {
            PARAMETERS_KEY: nested(
                {
                    name: list(value) if isinstance(value, tuple) else value
                    for name, value in given.items()
                }
            )
        }
        for node, given in values.items()
    }
    body = yaml.safe_dump(document, sort_keys=False, default_flow_style=None)
    return HEADER.format(run=row["run"], name=study.name) + body
