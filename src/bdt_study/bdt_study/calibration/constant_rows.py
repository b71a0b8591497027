"""Rows of the table of constants, for the terminal and for the page."""

from dataclasses import dataclass

from bdt_study.calibration.calibrate import Calibration
from bdt_study.calibration.constant import GAP, Constant
from bdt_study.calibration.finding import MOTION_OF
from bdt_study.calibration.start_values import model_values
from bdt_twin.gap_doubt import UNSEEN_YIELDING


@dataclass(frozen=True)
class ConstantRow:
    """A constant as texts.

    Attributes
    ----------
    name, unit : str
        Name and unit.
    start, value : str
        Start value, "" for what has none, and value that was found.
    uncertainty, given_only : str
        Standard uncertainty with and without the doubt about what it is stated for.
    determined : bool
        Whether the data tell it.
    given : tuple of str
        Constants for whose start values it is stated.
    """

    name: str
    unit: str
    start: str
    value: str
    uncertainty: str
    given_only: str
    determined: bool
    given: tuple[str, ...]


def constant_rows(result: Calibration) -> list[ConstantRow]:
    """Return a row for each constant, those that the data tell first."""
    start = model_values(result.start)
    rows = [
        ConstantRow(
            name,
            each.unit,
            f"{start[name]:.4g}" if name in start else "",
            f"{each.value:.5g}",
            f"{each.standard_uncertainty:.2g}",
            f"{each.standard_uncertainty_given:.2g}" if each.given else "",
            each.determined,
            each.given,
        )
        for name, each in result.constants.items()
    ]
    return sorted(rows, key=lambda row: not row.determined)


def hints(result: Calibration) -> list[str]:
    """Return for each constant that the data do not tell what would tell it.

    Whether friction yields is no constant as long as it is not known, but may be what makes the gap
    unsure.
    """
    start, doubt = model_values(result.start), result.found.friction_doubt
    untold = [
        (_kept(name, each, start.get(name, each.value)), each.revealed_by)
        for name, each in result.constants.items()
        if not each.determined
    ]
    if doubt > UNSEEN_YIELDING:
        unsure = f"whether friction yields, which leaves {GAP} unsure by {doubt:.2g} rad"
        untold.insert(0, (unsure, MOTION_OF["yield_angle"]))
    return [f"{what}; would be told by {motion}" for what, motion in untold]


def _kept(name: str, constant: Constant, start: float) -> str:
    """Return a constant that is not told, with what it is then: no gap is believed in before."""
    if name == GAP:
        return name
    is_start = constant.value == start
    return f"{name}, {'keeps' if is_start else 'is at most'} {constant.value:.4g} {constant.unit}"
