"""``bdt reproduce``: every simulation of the paper again, with figures, claims and sweeps."""

import json
import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from itertools import chain
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from rich.console import Console
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn
from rich.table import Table

from bdt_analysis.figures.figure_style import write_png
from bdt_analysis.figures.run_figures import overview_figure, residual_figure
from bdt_msgs_py.command_errors import BadInputError
from bdt_plant.plant import PlantModel
from bdt_study.engine.function_map import mapped
from bdt_study.engine.job import Engine
from bdt_study.limit_cycles.comparison import (
    LimitCycleComparison,
    compare_over_gap,
    compare_over_stiffness,
)
from bdt_study.limit_cycles.figure import limit_cycle_figure
from bdt_study.reproduction import (
    claim_robustness,
    dead_zone_sweep,
    decision_sweep,
    delay_sweep,
    figure_2,
    figure_6,
)
from bdt_study.reproduction.claims import CLAIMS, Claim
from bdt_study.reproduction.design_claims import design_claims
from bdt_study.reproduction.experiments import Choices, Experiment, run_paper
from bdt_study.reproduction.page import reproduction_page
from bdt_study.reproduction.sweep_settings import SweepSettings
from bdt_study.simulation.accuracy import Convergence, convergence_study

PAGE_FILE = "index.html"
CLAIMS_FILE = "claims.json"

STIFFNESS_GAP = math.radians(10.0)
"""Gap at which limit cycles are compared over the stiffness [rad]."""


@dataclass(frozen=True)
class Reproduction:
    """All that was computed.

    Attributes
    ----------
    claims : tuple of Claim
        In the order of the figures.
    figures : dict of str to Figure
        By file name.
    robustness_results : tuple of ClaimRobustness
        The claims again for other choices.
    limit_cycles : tuple of LimitCycleComparison
        Predicted and simulated, over the gap.
    accuracy : tuple of Convergence
        Errors of the kernel over the step size.
    """

    claims: tuple[Claim, ...]
    figures: dict[str, Figure]
    robustness_results: tuple[claim_robustness.ClaimRobustness, ...]
    limit_cycles: tuple[LimitCycleComparison, ...]
    accuracy: tuple[Convergence, ...]


def run_reproduction(
    engine: Engine, output: Path, size: SweepSettings | None = None, *, as_json: bool
) -> int:
    """Redo the paper, write figures, ``index.html`` and ``claims.json``, print the claims.

    Parameters
    ----------
    engine : Engine
        What works on the sweeps.
    output : Path
        Folder, created if necessary; results of an earlier run are replaced.
    size : SweepSettings, optional
        How much is tried beyond the figures of the paper; all by default.
    as_json : bool
        Print ``claims.json`` instead of a table.

    Returns
    -------
    int
        Number of claims that do not hold.

    Raises
    ------
    BadInputError
        If the folder cannot be written.
    """
    try:
        output.mkdir(parents=True, exist_ok=True)
        with _progress() as progress:
            result = reproduce(engine, Choices(), size or SweepSettings(), progress)
            task = progress.add_task("writing figures", total=None)
            write_reproduction(result, output)
            progress.remove_task(task)
    except OSError as error:
        reason = error.strerror or error
        raise BadInputError(f"--output {output}: cannot be written: {reason}") from error
    if as_json:
        print(claims_json(result.claims), end="")
    else:
        console = Console()
        console.print(claims_table(result.claims))
        console.print(f"page: {output / PAGE_FILE}", soft_wrap=True, highlight=False)
    return sum(not claim.holds for claim in result.claims)


def reproduce(
    engine: Engine, choices: Choices, size: SweepSettings, progress: Progress | None = None
) -> Reproduction:
    """Run all simulations and draw all figures.

    Parameters
    ----------
    engine : Engine
        What works on the sweeps.
    choices : Choices
        What the paper leaves open.
    size : SweepSettings
        How much is tried beyond the figures of the paper.
    progress : Progress, optional
        Told what is being computed.
    """

    @contextmanager
    def stage(name: str) -> Iterator[None]:
        task = None if progress is None else progress.add_task(name, total=None)
        yield
        if progress is not None and task is not None:
            progress.remove_task(task)

    with stage("figures 2 to 7"):
        response = figure_2.backlash_response()
        runs = run_paper(choices)
        angle = figure_6.screw_angle(runs)
        figures = {
            "figure_2.png": figure_2.figure_2(response),
            **_loop_figures("figure_3", runs.linear),
            **_loop_figures("figure_4", runs.fixed),
            "figure_6.png": figure_6.figure_6(runs, angle),
            **_loop_figures("figure_7", runs.reconfigured),
        }
    with stage("communication delays"):
        sweep = delay_sweep.sweep_delays(engine, choices, size.delays, size.random_delays)
        figures["delays.png"] = delay_sweep.delay_figure(sweep, choices.amplitude)
    with stage("dead-zone tolerances"):
        outcomes = dead_zone_sweep.sweep_tolerances(engine, choices, size.dead_zone_ratios)
        figures["dead_zone_widths.png"] = dead_zone_sweep.tolerance_figure(outcomes)
    with stage("decisions by simulation"):
        decided = decision_sweep.sweep_decisions(engine, choices, size.decision_gaps)
        figures["decisions.png"] = decision_sweep.decision_figure(decided)
    with stage("other choices"):
        robustness_results = claim_robustness.sweep_choices(engine, size.choices)
        figures["choices.png"] = claim_robustness.robustness_figure(robustness_results)
    with stage("limit cycles, predicted and simulated"):
        model = PlantModel()
        over_gap = compare_over_gap(model, choices.gains, np.array(size.gaps))
        compare = partial(compare_over_stiffness, model, choices.gains, STIFFNESS_GAP)
        factors = np.array(size.stiffness_factors).reshape(-1, 1)
        over_stiffness = tuple(chain.from_iterable(mapped(engine, compare, factors)))
        figures["limit_cycles.png"] = limit_cycle_figure(model, over_gap, over_stiffness)
    with stage("accuracy of the kernel"):
        accuracy = convergence_study()
    claims = [
        *design_claims(choices),
        figure_2.lost_motion_equals_gap(response),
        *(claim(runs) for claim in CLAIMS),
        figure_6.constant_input_matches(angle),
        figure_6.moving_input_differs(angle),
        delay_sweep.paper_delay_is_harmless(sweep),
        delay_sweep.delay_begins_to_matter(sweep),
        delay_sweep.random_delay_is_harmless(sweep),
        decision_sweep.decisions_are_stable(decided),
        decision_sweep.decisions_are_not_conservative(decided),
    ]
    claims.sort(key=lambda claim: claim.figure)
    return Reproduction(tuple(claims), figures, robustness_results, over_gap, accuracy)


def write_reproduction(result: Reproduction, output: Path) -> None:
    """Write figures, ``index.html`` and ``claims.json`` into an existing folder."""
    for name, figure in result.figures.items():
        write_png(figure, output / name)
    page = reproduction_page(
        result.claims,
        result.figures,
        result.robustness_results,
        result.limit_cycles,
        result.accuracy,
    )
    (output / PAGE_FILE).write_text(page, encoding="utf-8")
    (output / CLAIMS_FILE).write_text(claims_json(result.claims), encoding="utf-8")


def claims_json(claims: tuple[Claim, ...]) -> str:
    """Return the text of ``claims.json``."""
    entries = [claim.to_dictionary() for claim in claims]
    return json.dumps(entries, indent=2, allow_nan=False) + "\n"


def claims_table(claims: tuple[Claim, ...]) -> Table:
    """Return the claims as a table for the terminal."""
    table = Table("the paper says", "measured", "", "holds", show_lines=True)
    for claim in claims:
        holds = "yes" if claim.holds else "NO"
        table.add_row(claim.paper_says, f"{claim.measured:.3g}", claim.unit, holds)
    return table


def _loop_figures(name: str, run: Experiment) -> dict[str, Figure]:
    figures = {f"{name}.png": overview_figure(run.signals, run.steps, run.results)}
    residuals = residual_figure(run.signals, run.steps, run.results)
    if residuals is not None:
        figures[f"{name}_steps.png"] = residuals
    return figures


def _progress() -> Progress:
    return Progress(
        SpinnerColumn(),
        TextColumn("{task.description}"),
        TimeElapsedColumn(),
        console=Console(stderr=True),
        transient=True,
    )
