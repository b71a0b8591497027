"""``bdt sweep report``: from a data set to a page and to JSON."""

import json
from dataclasses import asdict
from pathlib import Path

from rich.console import Console

from bdt_msgs_py.output_files import not_writable, prepare_output
from bdt_study.sweep.sweep_answers import answers_of
from bdt_study.sweep.sweep_page import page_description, sweep_page
from bdt_study.sweep.sweep_table import open_study, read_runs

PAGE = "report.html"


def report(folder: Path, output: Path | None, *, as_json: bool) -> int:
    """Write the page of a sweep and return the exit code.

    Parameters
    ----------
    folder : Path
        Folder of the sweep, which may still grow.
    output : Path or None
        The page; None for ``report.html`` in the folder.
    as_json : bool
        Whether to print what the page shows.

    Raises
    ------
    BadInputError
        If the folder holds no sweep or no runs, or the page cannot be written.
    """
    study = open_study(folder)
    path = output or folder / PAGE
    prepare_output("--output", path, (".html",))
    answers = answers_of(read_runs(folder, study))
    try:
        path.write_text(sweep_page(answers, folder), encoding="utf-8")
    except OSError as error:
        raise not_writable("--output", path, error) from error
    if not as_json:
        Console().print(f"report: {path}", soft_wrap=True, highlight=False)
        return 0
    told = {
        "study": study.name,
        "runs": int(answers.table.runs.size),
        "of": study.runs,
        "margins": [asdict(one) for one in answers.margins],
        "worst": [{"run": run, **values} for run, values in answers.worst],
        **page_description(answers),
    }
    print(json.dumps(told, indent=2))
    return 0
