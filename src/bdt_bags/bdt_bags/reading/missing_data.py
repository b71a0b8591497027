"""What a bag lacks for the analysis of its run."""

from bdt_bags.reading.bag_reader import RawBag
from bdt_bags.reading.sample_rows import SampleRows
from bdt_msgs_py.topics import (
    BACKLASH_ESTIMATE,
    COMMAND,
    DIAGNOSTICS,
    MEASUREMENT,
    PARAMETER_EVENTS,
    REFERENCE,
    TELEMETRY,
    TRUTH,
)

WITHOUT = {
    TELEMETRY: "samples are those of measurement and command",
    MEASUREMENT: "the timing of the loop is that of telemetry",
    COMMAND: "latency unknown",
    REFERENCE: "no step is judged",
    TRUTH: "error of the estimate unknown",
    BACKLASH_ESTIMATE: "delay of reconfigurations unknown",
}
"""What the analysis says when a topic is missing."""


def missing_data(bag: RawBag, samples: SampleRows) -> tuple[str, ...]:
    """Return what a bag lacks, each with what follows from it.

    Parameters
    ----------
    bag : RawBag
        The bag.
    samples : SampleRows
        Its samples.
    """
    lines = [
        f"no {topic.name}: {text}" for topic, text in WITHOUT.items() if topic not in bag.topics
    ]
    if not has_parameter_events(bag):
        known = DIAGNOSTICS in bag.topics
        lines.append(
            "no parameter_events: number of reconfigurations unknown"
            if known
            else "neither parameter events nor diagnostics: dead zone unknown"
        )
    lost = len(samples.times) - len(samples.rows)
    if lost:
        lines.append(f"{lost} of {len(samples.times)} samples are not finite")
    for name, times in sorted(bag.left_out.items()):
        one = len(times) == 1
        what, why = (
            ("message", "is left out: it fits") if one else ("messages", "are left out: they fit")
        )
        lines.append(f"{len(times)} {what} of {name} {why} into no run")
    return tuple(lines)


def has_parameter_events(bag: RawBag) -> bool:
    """Tell whether the topic was recorded, be it without a message."""
    return PARAMETER_EVENTS in bag.topics or PARAMETER_EVENTS.name in bag.message_counts
