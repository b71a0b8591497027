"""The tables of a report."""

import math
from collections.abc import Iterable

from bdt_analysis.metrics.lead_screw_pitch import lead_screw_pitch
from bdt_analysis.metrics.reference_steps import ReferenceStep
from bdt_analysis.metrics.step_analysis import StepSummary
from bdt_analysis.metrics.summary import Summary
from bdt_analysis.pages.table import Column, Row, Table, number
from bdt_bags.reading.recording import Recording

MOST_ROWS = 200
"""Number of steps that the table shows."""

STEP_COLUMNS = (
    Column("step"),
    Column("begins", "s"),
    Column("r", "mm"),
    Column("residual, peak to peak", "µm"),
    Column("bias", "µm"),
    Column("bias", "% of amplitude"),
    Column("settling time", "s"),
    Column("limit cycle", text=True),
    Column("limit cycle amplitude", "µm"),
    Column("limit cycle frequency", "Hz"),
)


def steps_table(summary: Summary, steps: list[ReferenceStep]) -> Table:
    """Return the steps; a click on one leads the plots there."""
    shown = summary.steps[:MOST_ROWS]
    notes = []
    if len(shown) < len(summary.steps):
        notes.append(f"{len(summary.steps) - len(shown)} more steps are in summary.json.")
    if steps and steps[-1].cut:
        notes.append("The end of the recording cuts the last step too short to be judged.")
    holed = [str(k) for k, step in enumerate(steps, start=1) if step.holed]
    if holed:
        which = f"step {holed[0]}" if len(holed) == 1 else f"steps {', '.join(holed[:20])}"
        more = " and more" if len(holed) > 20 else ""
        notes.append(f"Not judged because a part of the recording is missing: {which}{more}.")
    return Table(
        key="steps",
        title="Steps",
        columns=STEP_COLUMNS,
        rows=[
            Row(step_cells(k, step), alarm=bool(step.limit_cycle), step=k)
            for k, step in enumerate(shown, start=1)
        ],
        note=" ".join(notes),
        empty="No reference holds during the telemetry.",
    )


def step_cells(index: int, step: StepSummary) -> list[str]:
    """Return what stands in the columns of a step.

    Parameters
    ----------
    index : int
        Number of the step, from 1.
    step : StepSummary
        The step.
    """
    return [
        str(index),
        number(step.t_start_s, ".6g"),
        number(step.reference_m, ".4g", 1e3),
        number(step.residual_peak_to_peak_m, ".2f", 1e6),
        number(step.bias_m, ".2f", 1e6),
        number(step.bias_percent_of_amplitude, ".3f"),
        number(step.settling_time_s, ".2f"),
        {None: "", False: "no", True: "yes"}[step.limit_cycle],
        number(step.limit_cycle_amplitude_m, ".2f", 1e6),
        number(step.limit_cycle_frequency_hz, ".2f"),
    ]


def detail_tables(recording: Recording, summary: Summary) -> Iterable[Table]:
    """Return what stands below the steps in two columns.

    The page shows whatever is here, in this order.
    """
    return (_estimate_table(recording, summary), _message_table(summary))


def _estimate_table(recording: Recording, summary: Summary) -> Table:
    degrees, errors = math.degrees(1), summary.estimate
    final = summary.dead_zone_final_m
    angle = None if final is None else final / lead_screw_pitch(recording)
    gap = None if recording.truth is None else float(recording.truth[-1, 3])
    rows = (
        ("estimates", str(len(recording.estimates)), ""),
        (
            "gap error where stated, root mean square",
            number(errors.stated_rms_error_rad, ".3f", degrees),
            "deg",
        ),
        (
            "gap error where stated, largest",
            number(errors.stated_max_error_rad, ".3f", degrees),
            "deg",
        ),
        (
            "shortfall until the next estimate, largest",
            number(errors.max_shortfall_rad, ".3f", degrees),
            "deg",
        ),
        ("worst lag of the dead zone", number(errors.worst_lag_s, ".3f"), "s"),
        ("reconfigurations", number(summary.reconfigurations, ".0f"), ""),
        ("dead zone at the end", number(final, ".2f", 1e6), "µm"),
        ("dead zone at the end, as a gap", number(angle, ".2f", degrees), "deg"),
        (
            "voltage offset asked for last",
            number(errors.voltage_offset_v, ".1f", 1e3),
            "mV",
        ),
        ("true gap at the end", number(gap, ".2f", degrees), "deg"),
    )
    return Table(
        key="estimate",
        title="Estimate and reconfiguration",
        columns=(Column("quantity", text=True), Column("value"), Column("unit", text=True)),
        rows=[Row(row) for row in rows],
    )


def _message_table(summary: Summary) -> Table:
    left_out = sum(summary.messages_left_out.values())
    counts = [
        *summary.messages.items(),
        ("lost", summary.lost_messages),
        ("lost in the recorder's queue", summary.lost_in_queue),
        ("left out", left_out),
    ]
    return Table(
        key="messages",
        title="Messages",
        columns=(Column("topic", text=True), Column("messages")),
        rows=[Row((topic, str(count))) for topic, count in counts],
    )
