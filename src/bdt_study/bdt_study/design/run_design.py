"""``bdt design``: the PID design behind the default gains, as text, JSON and a figure."""

import dataclasses
import json
import math
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from bdt_msgs_py.output_files import PICTURES, not_writable, prepare_output
from bdt_plant.plant import PlantModel
from bdt_study.design.figures import design_figure
from bdt_study.design.loop_margins import LoopMargins
from bdt_study.design.pid_design import PidDesign, design_pid


def run_design(output: Path, *, as_json: bool) -> None:
    """Design the PID for the mechanism of table 1, print the result and draw it.

    Parameters
    ----------
    output : Path
        PNG, SVG or PDF file for Bode, Nyquist and step response.
    as_json : bool
        Print JSON instead of tables.

    Raises
    ------
    BadInputError
        If the file cannot be written.
    """
    prepare_output("--output", output, PICTURES)
    model = PlantModel()
    design = design_pid(model)
    figure = design_figure(model, design)
    try:
        figure.savefig(output)
    except OSError as error:
        raise not_writable("--output", output, error) from error
    if as_json:
        print(json.dumps(design_dictionary(design), indent=2))
        return
    console = Console()
    console.print(gains_table(design))
    console.print(margins_table(design))
    console.print(f"figure: {output}", soft_wrap=True, highlight=False)


def design_dictionary(design: PidDesign) -> dict[str, Any]:
    """Return gains and margins as what JSON can hold; angles in degrees."""
    return {
        "gains": dataclasses.asdict(design.gains),
        "continuous": _margins_dictionary(design.margins),
        "sampled": _margins_dictionary(design.sampled),
        "control_rate_hz": design.control_rate,
    }


def gains_table(design: PidDesign) -> Table:
    """Return a table of the gains of eq. 4."""
    table = Table("gain of eq. 4", "value", "unit")
    gains = design.gains
    table.add_row("K_p", f"{gains.proportional:.1f}", "V/m")
    table.add_row("K_i", f"{gains.integral:.0f}", "V/(m s)")
    table.add_row("K_d", f"{gains.derivative:.2f}", "V s/m")
    table.add_row("T_f", f"{gains.filter_time:.4f}", "s")
    return table


def margins_table(design: PidDesign) -> Table:
    """Return a table of the margins, continuous and as sampled."""
    table = Table("", "continuous", f"sampled at {design.control_rate:g} Hz")
    both = [_margins_dictionary(margins) for margins in (design.margins, design.sampled)]
    for key in both[0]:
        table.add_row(key, *(_text(margins[key]) for margins in both))
    return table


def _text(value: Any) -> str:
    if isinstance(value, list):
        return ", ".join(_text(item) for item in value)
    return f"{value:.3g}" if isinstance(value, float) else str(value)


def _margins_dictionary(margins: LoopMargins) -> dict[str, Any]:
    return {
        "stable": margins.stable,
        "first_gain_crossover_rad_s": margins.first_crossover,
        "bandwidth_3db_rad_s": margins.bandwidth,
        "phase_margins_deg": [math.degrees(item.phase_margin) for item in margins.crossovers],
        "smallest_phase_margin_deg": math.degrees(margins.smallest_phase_margin),
        "gain_margin": margins.gain_margin,
        "maximum_sensitivity": margins.maximum_sensitivity,
    }
