"""The fit of all data of a calibration at once: the estimator's own, in two halves.

Noise of the machine is told from noise of the reading at the end only: as long as the model is
wrong, any deviation would be taken for the machine's, and the fit would stay where it is.
"""

from bdt_twin.fit_result import Fit
from bdt_twin.output_error_fit import WindowFit
from bdt_twin.unknowns import Unknowns

ROUGH, FINE = 8, 12
"""Largest numbers of steps of the fit to all samples, before and after noise is told apart."""
MOST_REPEATS = 8
"""Largest number of times that the fit before is begun anew, from where it ended."""
SETTLED = 0.98
"""Ratio of two residuals above which it has come to an end."""


def fit_whole(problem: WindowFit, start: Unknowns) -> Fit:
    """Return the fit of the data that begins with `start`."""
    near = fit_reading_noise(problem, start)
    return fit_machine_noise(problem, fit_machine_noise(problem, near))


def fit_reading_noise(problem: WindowFit, start: Unknowns) -> Fit:
    """Return the fit for which all that is not explained is noise of the reading."""
    near = problem.solve(start, ROUGH, 3 * ROUGH)
    for _ in range(MOST_REPEATS):
        before = near.residual
        near = problem.solve(near.unknowns, ROUGH, 3 * ROUGH)
        if near.residual > SETTLED * before:
            break
    return near


def fit_machine_noise(problem: WindowFit, before: Fit) -> Fit:
    """Return the fit that goes on from another one, with the noise that this one has found."""
    return problem.solve(before.unknowns, FINE, 3 * FINE, levels=before.levels)
