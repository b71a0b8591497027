"""What a twin keeps beyond its end, as the node sees it: recalled once, noted with each change."""

import time
from pathlib import Path
from typing import Any

from bdt_plant.plant import PlantModel
from bdt_twin.estimation_record import EstimationRecord
from bdt_twin.evenly_sampled import EvenlySampled
from bdt_twin.link import Reconfiguration
from bdt_twin.state_file import StateFileError, StoredState, read_state
from bdt_twin.state_writer import StateWriter
from bdt_twin.twin_settings import TwinSettings
from bdt_twin.twin_state import TwinState, mechanism_of, remembered_gap


class KeptState:
    """The state file of a twin; without one nothing is kept.

    Parameters
    ----------
    settings : TwinSettings
        Where the file is, and how old it may be.
    controller : str
        Name of the controller's node with its namespace.
    kind : str
        The estimator's kind.
    model : PlantModel
        Constants of the mechanism, as the twin knows them.
    logger : logger of a node
        Gets one line about a file that is of no use.

    Raises
    ------
    ValueError
        If a file of that name cannot be.

    Attributes
    ----------
    recalled : StoredState or None
        What the twin before has kept; None for nothing.
    """

    def __init__(
        self,
        settings: TwinSettings,
        controller: str,
        kind: str,
        model: PlantModel,
        logger: Any,
    ) -> None:
        self._controller, self._mechanism = controller, mechanism_of(kind, model)
        self._path, self._logger = settings.state_file, logger
        self.recalled: StoredState | None = None
        self._writer: StateWriter | None = None
        self._told_error, self._recalled_at = "", time.monotonic()
        if not settings.state_file:
            return
        path = Path(settings.state_file).absolute()
        if path.is_dir() or not path.parent.is_dir():
            raise ValueError(
                f"state_file = {settings.state_file!r}: must be a file in a folder that exists"
            )
        is_foreign = False
        try:
            self.recalled = read_state(
                path, controller, self._mechanism, time.time(), settings.state_longest_age
            )
        except StateFileError as error:
            is_foreign = error.is_foreign
            logger.warning(f"state_file {path}: {error}")
        if not is_foreign:
            self._writer = StateWriter(path)

    def recall_machine(self, estimator: EvenlySampled) -> None:
        """Tell an estimator what the one before knew of the machine, if it wants to know."""
        if self.recalled is None:
            return
        state, age = self.recalled
        if state.machine is not None:
            estimator.recall(state.machine, age + state.machine_age)

    def note(
        self,
        in_force: Reconfiguration | None,
        lives: tuple[str, ...],
        record: EstimationRecord,
    ) -> None:
        """Have it written what is in force and what is known, as soon as it is its turn.

        Parameters
        ----------
        in_force : Reconfiguration or None
            What the controller was asked for; None for nothing, which is not worth a file.
        lives : tuple of str
            Identifiers of the controllers that have it.
        record : EstimationRecord
            What has come of the telemetry.
        """
        if self._writer is None or in_force is None:
            return
        gap = remembered_gap(record.estimate, record.telemetry_end * 1e-9)
        machine, machine_age = record.machine, 0.0
        if self.recalled is not None:
            # Until something new is known, what was known before is kept with its age.
            since, before = self._age_of_recalled(), self.recalled.state
            if gap is None and before.gap is not None:
                gap = before.gap.aged(since)
            if machine is None:
                machine, machine_age = before.machine, before.machine_age + since
        self._writer.put(
            TwinState(
                self._controller,
                self._mechanism,
                in_force.tolerance,
                in_force.voltage_offset,
                in_force.gains,
                lives,
                gap,
                machine,
                machine_age,
            )
        )

    def values(self) -> dict[str, object]:
        """Return what the diagnostics say; nothing without a state file."""
        if not self._path:
            return {}
        error = self._writer.error if self._writer is not None else "somebody else's file"
        told: dict[str, object] = {"state_file": self._path, "state_file_error": error}
        if self.recalled is not None:
            told["recalled_age_s"] = self._age_of_recalled()
            if self.recalled.state.gap is not None:
                gap = self.recalled.state.gap.aged(self._age_of_recalled())
                told["recalled_gap_rad"] = gap.gap
                told["recalled_gap_uncertainty_rad"] = gap.grown_uncertainty
        return told

    def _age_of_recalled(self) -> float:
        age = 0.0 if self.recalled is None else self.recalled.age
        return age + time.monotonic() - self._recalled_at

    def fault(self) -> str:
        """Return why nothing is kept although it should be; empty if it is."""
        error = self._writer.error if self._writer is not None else ""
        if error and error != self._told_error:
            self._logger.warning(f"state_file {error}")
        self._told_error = error
        return f"the twin's state is not kept: {error}" if error else ""

    def close(self) -> None:
        """Write what is left to write."""
        if self._writer is not None:
            self._writer.close()
