"""Runs that are set side by side: loaded, named and analyzed."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from bdt_analysis.metrics.recording_holes import find_holes, hole_limits
from bdt_analysis.metrics.reference_steps import ReferenceStep, find_steps
from bdt_analysis.metrics.run_names import run_names
from bdt_analysis.metrics.summary import Summary, summarize
from bdt_bags.reading.recording import Recording, load_recording
from bdt_bags.reading.topic_selection import TopicSelection


@dataclass(frozen=True)
class ComparedRun:
    """One run of a comparison.

    Attributes
    ----------
    name : str
        Shortest name that tells it from the others.
    recording : Recording
        Its signals.
    steps : list of ReferenceStep
        Its steps.
    summary : Summary
        Its numbers.
    """

    name: str
    recording: Recording
    steps: list[ReferenceStep]
    summary: Summary


def load_runs(bags: Sequence[Path], selection: TopicSelection | None = None) -> list[ComparedRun]:
    """Load and analyze bags.

    Parameters
    ----------
    bags : sequence of Path
        The bags.
    selection : TopicSelection, optional
        Which loop and which topics are meant, in every bag.

    Raises
    ------
    BagError
        If one cannot be analyzed.
    """
    runs = []
    for name, bag in zip(run_names(bags), bags, strict=True):
        recording = load_recording(bag, selection)
        steps = find_steps(
            recording.reference,
            recording.telemetry,
            recording.sample_time,
            hole_limits(find_holes(recording)),
        )
        runs.append(ComparedRun(name, recording, steps, summarize(recording, steps)))
    return runs
