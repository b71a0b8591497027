"""From a bag to a report: load, analyze, write."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from bdt_analysis.export import FOLDER, export
from bdt_analysis.figures.figure_style import svg_text, write_png
from bdt_analysis.figures.run_figures import overview_figure, residual_figure
from bdt_analysis.metrics.recording_holes import find_holes, hole_limits
from bdt_analysis.metrics.reference_steps import ReferenceStep, find_steps
from bdt_analysis.metrics.summary import Summary, summarize
from bdt_analysis.pages.report import render_report
from bdt_analysis.re_estimation.estimator_setup import estimator_setup
from bdt_analysis.re_estimation.re_estimation import ReEstimation, re_estimate
from bdt_bags.bag_error import BagError
from bdt_bags.reading.recording import Recording, load_recording
from bdt_bags.reading.topic_selection import TopicSelection
from bdt_msgs_py.output_files import real_path

SUMMARY_FILE = "summary.json"
REPORT_FILE = "report.html"
FIGURE_FILE = "figure.png"


def analyze(
    bag: Path,
    output: Path | None = None,
    selection: TopicSelection | None = None,
    formats: Sequence[str] = (),
    settings: Mapping[str, Any] | None = None,
    run: int | None = None,
) -> Summary:
    """Analyze a bag and write ``report.html``, ``summary.json`` and ``figure.png``.

    Parameters
    ----------
    bag : Path
        A rosbag2 folder or a bare ``.mcap`` or ``.db3`` file; it is not changed.
    output : Path, optional
        Folder for the results, created if necessary; results of an earlier analysis are
        replaced. None writes nothing.
    selection : TopicSelection, optional
        Which loop and which topics are meant where the bag does not tell.
    formats : sequence of str
        What is exported beside the report; see :mod:`bdt_analysis.export`.
    settings : mapping of str, optional
        Estimate the gap again, with these parameters of the twin; see
        :func:`bdt_analysis.re_estimation.estimator_setup.given_settings`. None does not.
    run : int, optional
        Which run is meant, from 1, of a bag that holds several.

    Returns
    -------
    Summary
        The numbers.

    Raises
    ------
    BagError
        If the bag cannot be analyzed or the folder cannot be written.
    BadInputError
        If the gap cannot be estimated with these settings.
    """
    recording = load_recording(Path(bag), selection, run)
    steps = find_steps(
        recording.reference,
        recording.telemetry,
        recording.sample_time,
        hole_limits(find_holes(recording)),
    )
    re_estimation = None
    if settings is not None:
        re_estimation = re_estimate(recording, estimator_setup(recording, settings))
    summary = summarize(recording, steps, re_estimation.summary if re_estimation else None)
    if output is not None:
        _prepare(Path(output), Path(bag))
        _write(Path(output), recording, steps, summary, formats, re_estimation)
    return summary


def _prepare(output: Path, bag: Path) -> None:
    """Create the folder; refuse one that is a bag or lies in it."""
    try:
        folder, source = real_path(output), real_path(bag)
        if folder.is_relative_to(source) or (folder / "metadata.yaml").exists():
            raise BagError(f"output {output}: is a bag, which is left as it is: must be elsewhere")
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise _not_writable(output, error) from None


def _write(
    output: Path,
    recording: Recording,
    steps: list[ReferenceStep],
    summary: Summary,
    formats: Sequence[str],
    re_estimation: ReEstimation | None,
) -> None:
    overview = overview_figure(recording, steps, summary.steps, re_estimation)
    residuals = residual_figure(recording, steps, summary.steps)
    report = render_report(
        recording,
        steps,
        summary,
        svg_text(overview, "overview"),
        svg_text(residuals, "residuals") if residuals is not None else None,
        re_estimation,
    )
    try:
        (output / SUMMARY_FILE).write_text(summary.to_json(), encoding="utf-8")
        (output / REPORT_FILE).write_text(report, encoding="utf-8")
        write_png(overview, output / FIGURE_FILE)
        if formats:
            figures = {"overview": overview} | ({"residuals": residuals} if residuals else {})
            export(output / FOLDER, formats, recording, summary.steps, figures, re_estimation)
    except OSError as error:
        raise _not_writable(output, error) from None


def _not_writable(output: Path, error: OSError) -> BagError:
    return BagError(f"output {output}: cannot be written: {error.strerror or error}")
