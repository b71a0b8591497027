"""What `bdt run` starts: nodes with their modules and ROS arguments, folders, durations."""

from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path
from typing import Literal

from bdt_bringup.running.configuration import BadInputError, Configuration
from bdt_bringup.running.recorder_settings import RecorderSettings
from bdt_bringup.running.recording_options import recorder_parameters
from bdt_msgs_py.topics import CONTROLLER_NODE, PLANT_NODE, TWIN_NODE

DEFAULT_DURATION = 120.0
"""Simulated time of the paper's scenario [s], for a configuration that sets none."""

RECORDER = "recorder"
MODULES = {
    CONTROLLER_NODE: "bdt_controller.controller_node",
    TWIN_NODE: "bdt_twin.twin_node",
    RECORDER: "bdt_bringup.running.recorder_node",
    PLANT_NODE: "bdt_plant.plant_node",
}
"""Modules by node, in the order of their start: the plant, which drives the others, is last."""


@dataclass(frozen=True)
class RunPlan:
    """A run of the loop.

    Attributes
    ----------
    configuration : Configuration
        The parameter file.
    mode : str
        ``lockstep`` or ``realtime``.
    duration : float
        Simulated time [s].
    processes : str
        ``separate`` or ``single``.
    output : Path
        Folder of the run: bag, logs, report.
    record : bool
        Whether a bag is written.
    recorder : RecorderSettings
        How it is written; where is a matter of `output`.
    """

    configuration: Configuration
    mode: str
    duration: float
    processes: Literal["separate", "single"]
    output: Path
    record: bool
    recorder: RecorderSettings

    @property
    def bag(self) -> Path:
        """Folder of the bag."""
        return self.output / "bag"

    @property
    def nodes(self) -> list[str]:
        """Names of the nodes in the order of their start."""
        return [name for name in MODULES if self.record or name != RECORDER]

    def ros_arguments(self, node: str) -> list[str]:
        """Return what follows ``--ros-args`` on the command line of `node`."""
        arguments = []
        if self.configuration.path is not None and node != RECORDER:
            arguments += ["--params-file", str(self.configuration.path)]
        for name, value in self._overrides(node).items():
            arguments += ["-p", f"{name}:={value}"]
        return arguments

    def _overrides(self, node: str) -> dict[str, str]:
        if node == PLANT_NODE:
            followers = [name for name in (TWIN_NODE, RECORDER) if name in self.nodes]
            return {
                "mode": self.mode,
                "duration": repr(self.duration),
                "lockstep_followers": f"[{', '.join(followers)}]",
            }
        if node == RECORDER:
            return recorder_parameters(replace(self.recorder, bag=str(self.bag)))
        return {"use_sim_time": "true"}


def plan_run(
    configuration: Configuration,
    *,
    mode: str | None,
    duration: float | None,
    processes: Literal["separate", "single"],
    output: Path | None,
    record: bool,
    recorder: RecorderSettings,
) -> RunPlan:
    """Return a checked plan; what is None comes from the configuration.

    Raises
    ------
    BadInputError
        For a duration that is not positive or an output folder that already holds something.
    """
    chosen = duration
    if chosen is None:
        chosen = configuration.value(PLANT_NODE, "duration") or DEFAULT_DURATION
    if not 0 < chosen <= 1e9:
        raise BadInputError(f"--duration {chosen!r} s: must be above 0 and at most 1e9")
    if output is None:
        begun = datetime.now().astimezone().strftime("%Y%m%d-%H%M%S")
        output = Path("runs") / f"{begun}-{configuration.name}"
    if output.exists() and (not output.is_dir() or any(output.iterdir())):
        raise BadInputError(
            f"--output {output}: already holds a run, must be a new or empty folder"
        )
    return RunPlan(
        configuration=configuration,
        mode=mode or configuration.value(PLANT_NODE, "mode"),
        duration=float(chosen),
        processes=processes,
        output=output,
        record=record,
        recorder=recorder,
    )
