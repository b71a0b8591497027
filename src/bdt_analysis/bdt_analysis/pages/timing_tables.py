"""Timing of the loop and log of the reconfigurations as tables."""

from collections.abc import Sequence

import numpy as np

from bdt_analysis.metrics.loop_timing import StreamTiming
from bdt_analysis.metrics.reconfigurations import reconfiguration_log
from bdt_analysis.metrics.summary import Summary
from bdt_analysis.pages.table import Column, Row, Table, number
from bdt_bags.run_signals import RunSignals

MOST_LOGGED = 1000
"""Number of reconfigurations that a page shows."""

STREAM_COLUMNS = (
    Column("topic", text=True),
    Column("messages"),
    Column("repeated"),
    Column("gaps"),
    Column("longest gap", "ms"),
    Column("it begins at", "s"),
    Column("period", "ms"),
    Column("stamp jitter, rms", "ms"),
    Column("largest", "ms"),
    Column("arrival period", "ms"),
    Column("arrival jitter, rms", "ms"),
    Column("largest", "ms"),
)
LATENCY_COLUMNS = (
    Column("measurements answered"),
    Column("not answered"),
    Column("latency, median", "ms"),
    Column("99 %", "ms"),
    Column("largest", "ms"),
)
DELAY_COLUMNS = (
    Column("from estimates"),
    Column("from elsewhere"),
    Column("estimates not applied"),
    Column("delay, smallest", "s"),
    Column("median", "s"),
    Column("largest", "s"),
    Column("oldest gap", "s"),
    Column("longest pause", "s"),
)
RUN_COLUMN = Column("run", text=True)
CLOCKS = (
    "Stamps are on the clock of the data, arrivals and latency on the recorder's wall clock: in "
    "lockstep these tell the pace of the simulation, not of a controller."
)


def timing_tables(runs: Sequence[tuple[str, Summary]]) -> list[Table]:
    """Return timing of the topics, latency and delays of reconfigurations.

    Parameters
    ----------
    runs : sequence of (str, Summary)
        Names and numbers of the runs; the tables name them if there are several.
    """
    several = len(runs) > 1
    streams, latencies, delays = [], [], []
    for name, summary in runs:
        own = (name,) if several else ()
        timing, delay = summary.timing, summary.reconfiguration_delay
        for topic in ("measurement", "command", "telemetry"):
            stream: StreamTiming = getattr(timing, topic)
            if stream.messages:
                streams.append(Row((*own, topic, *_stream_cells(stream)), alarm=stream.gaps > 0))
        latency = timing.latency
        if latency.answered:
            cells = (str(latency.answered), str(latency.unanswered))
            waits = (latency.median_s, latency.p99_s, latency.max_s)
            latencies.append(Row((*own, *cells, *(number(x, ".3f", 1e3) for x in waits))))
        if delay.from_estimates or delay.from_elsewhere:
            counts = (delay.from_estimates, delay.from_elsewhere, delay.estimates_not_applied)
            times = (delay.min_s, delay.median_s, delay.max_s, delay.max_gap_age_s)
            pause = delay.longest_pause_s
            numbers = (*map(str, counts), *(number(x, ".4f") for x in (*times, pause)))
            delays.append(Row((*own, *numbers)))
    first = (RUN_COLUMN,) if several else ()
    tables = (
        Table("timing", "Timing of the loop", (*first, *STREAM_COLUMNS), streams, note=CLOCKS),
        Table("latency", "From measurement to command", (*first, *LATENCY_COLUMNS), latencies),
        Table("delays", "Delays of reconfigurations", (*first, *DELAY_COLUMNS), delays),
    )
    return [table for table in tables if table.rows]


def reconfiguration_table(run: RunSignals) -> Table | None:
    """Return every dead zone with the estimate behind it; None when none was ever set.

    Parameters
    ----------
    run : RunSignals
        The run.
    """
    log = reconfiguration_log(run)
    if len(log) < 2:
        return None
    degrees = float(np.rad2deg(1.0))
    rows = [
        Row(
            (
                number(entry.time_s, ".4f"),
                number(entry.dead_zone_m, ".4f", 1e6),
                number(entry.change_m, ".4f", 1e6),
                number(entry.estimate_rad, ".4f", degrees),
                number(entry.estimate_time_s, ".4f"),
                number(entry.delay_s, ".4f"),
                number(entry.gap_age_s, ".4f"),
            )
        )
        for entry in log[:MOST_LOGGED]
    ]
    hidden = len(log) - len(rows)
    return Table(
        key="reconfigurations",
        title="Log of reconfigurations",
        columns=(
            Column("time", "s"),
            Column("dead zone ε", "µm"),
            Column("change", "µm"),
            Column("estimate behind it", "deg"),
            Column("stated for", "s"),
            Column("delay", "s"),
            Column("age of the gap", "s"),
        ),
        rows=rows,
        note=f"{hidden} more are in the bag." if hidden else "",
    )


def _stream_cells(stream: StreamTiming) -> list[str]:
    times = (
        stream.period_s,
        stream.stamp_jitter_rms_s,
        stream.stamp_jitter_max_s,
        stream.arrival_period_s,
        stream.arrival_jitter_rms_s,
        stream.arrival_jitter_max_s,
    )
    return [
        str(stream.messages),
        str(stream.repeated),
        str(stream.gaps),
        number(stream.longest_gap_s, ".3f", 1e3),
        number(stream.longest_gap_begins_s, ".4f"),
        *(number(time, ".3f", 1e3) for time in times),
    ]
