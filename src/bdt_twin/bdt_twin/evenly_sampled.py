"""An estimator that gets even samples, whatever the telemetry is like."""

import numpy as np
from numpy.typing import NDArray

from bdt_twin.estimator import Estimate, Estimator
from bdt_twin.even_samples import EvenSamples, Sampling
from bdt_twin.machine_recollection import MachineRecollection
from bdt_twin.next_fit import AcceptedFit, last_fit_of


class EvenlySampled:
    """Brings telemetry to even samples before an estimator gets it.

    Parameters
    ----------
    estimator : Estimator
        Gets the samples.
    sampling_rate : float
        Sampling rate that it expects [Hz].

    Attributes
    ----------
    estimator : Estimator
        The same.
    """

    def __init__(self, estimator: Estimator, sampling_rate: float) -> None:
        self.estimator = estimator
        self._samples = EvenSamples(sampling_rate)

    @property
    def sampling(self) -> Sampling:
        """What was made of the stamps."""
        return self._samples.sampling

    @property
    def last_fit(self) -> AcceptedFit | None:
        """The estimator's last fit; None for one that has none."""
        return last_fit_of(self.estimator)

    @property
    def recollection(self) -> MachineRecollection | None:
        """What is worth keeping of the machine; None from an estimator that does not look at it."""
        found: MachineRecollection | None = getattr(self.estimator, "recollection", None)
        return found

    def recall(self, kept: MachineRecollection, age: float) -> None:
        """Tell the estimator what one before knew of the machine some time [s] ago."""
        recall = getattr(self.estimator, "recall", None)
        if recall is not None:
            recall(kept, age)

    def restart(self) -> None:
        """Forget everything: another run begins."""
        self._samples.restart()
        self.estimator.restart()

    def update(self, batch: NDArray[np.float64], *, newest_only: bool = False) -> Estimate | None:
        """Take the next batch; see :meth:`bdt_twin.estimator.Estimator.update`."""
        rows = self._samples.take(batch)
        if len(batch) and not len(rows):
            return None
        return self.estimator.update(rows, newest_only=newest_only)
