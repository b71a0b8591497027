"""Which estimator the twin uses: one of this package's, or anybody's by the name of its file."""

from dataclasses import dataclass

from bdt_msgs_py.quantities import quantity, validate
from bdt_plant.plant import PlantModel
from bdt_twin.evenly_sampled import EvenlySampled
from bdt_twin.inverse_filter import InverseFilterEstimator, InverseFilterSettings
from bdt_twin.output_error import OutputErrorEstimator
from bdt_twin.output_error_settings import OutputErrorSettings
from bdt_twin.user_estimator import UserEstimator, UserEstimatorError

KINDS = ("inverse_filter", "output_error")


@dataclass(frozen=True)
class EstimatorChoice:
    """The estimator of the backlash gap."""

    kind: str = quantity(
        "inverse_filter",
        "",
        "inverse_filter (the paper's, for signals without noise), output_error (fits the model to "
        "measured ones), or module:name of a class with restart() and update(batch)",
    )

    def __post_init__(self) -> None:
        validate(self)
        module, _, name = self.kind.partition(":")
        if self.kind not in KINDS and not (module and name):
            raise ValueError(
                f"EstimatorChoice.kind = {self.kind!r}: "
                f"must be one of {', '.join(KINDS)} or module:name"
            )


def create_estimator(
    choice: EstimatorChoice,
    model: PlantModel,
    inverse_filter: InverseFilterSettings,
    output_error: OutputErrorSettings,
) -> EvenlySampled:
    """Return the estimator of a choice, for telemetry as machines have it.

    Parameters
    ----------
    choice : EstimatorChoice
        Which one.
    model : PlantModel
        Constants of the mechanism, as the twin knows them.
    inverse_filter : InverseFilterSettings
        Settings of the paper's estimator; its sampling rate is that of the telemetry.
    output_error : OutputErrorSettings
        Settings of the estimator that fits the model.

    Raises
    ------
    ValueError
        If there is no such module or class, or if it fails, with one line that says where.
    """
    rate = inverse_filter.sampling_rate
    if choice.kind == "inverse_filter":
        return EvenlySampled(InverseFilterEstimator(model, inverse_filter), rate)
    if choice.kind == "output_error":
        return EvenlySampled(OutputErrorEstimator(model, output_error, rate), rate)
    try:
        return EvenlySampled(UserEstimator(choice.kind, model, rate), rate)
    except UserEstimatorError as error:
        raise ValueError(f"estimator.kind = {choice.kind!r}: {error}") from error
