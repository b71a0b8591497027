"""What `bdt run` starts: nodes with their ROS arguments, folders, durations."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Any, Literal

from bdt_bringup.configuration import Configuration
from bdt_bringup.installed import PACKAGE_OF_NODE, missing_packages, node_module
from bdt_bringup.loop_state import MACHINES
from bdt_msgs_py.command_errors import BadInputError
from bdt_msgs_py.loop_namespace import namespace_arguments
from bdt_msgs_py.parameter_tables import ros_arguments
from bdt_msgs_py.topics import (
    CONTROLLER_NODE,
    DRIVER_NODE,
    PLANT_NODE,
    RECORDER_NODE,
    TWIN_NODE,
)

Processes = Literal["separate", "shared", "single"]
"""One for each node; one for driver and controller, one for each other node; one for all."""

CONTROLLED_DRIVER = "bdt_bringup.controlled_driver"
"""Module of the process that driver and controller share."""

DEFAULT_DURATION = 120.0
"""Simulated time of the paper's scenario [s], for a configuration that sets none."""


@dataclass(frozen=True)
class RunPlan:
    """A run of the loop.

    Attributes
    ----------
    configuration : Configuration
        The parameter file.
    mode : str
        ``lockstep`` or ``realtime``; that of a real machine is the latter.
    duration : float
        Simulated time, or the time for which a real machine is armed [s].
    processes : str
        ``separate``, ``shared`` or ``single``.
    output : Path
        Folder of the run: bag, logs, report.
    recorder : mapping of str, or None
        The recorder's parameters, save where the bag is: a matter of `output`. None records
        nothing.
    supervise : bool
        Whether nodes that died are started anew.
    plant : mapping of str
        Parameters of a simulated plant that go before those of the configuration and of the run.
    """

    configuration: Configuration
    mode: str
    duration: float
    processes: Processes
    output: Path
    recorder: Mapping[str, Any] | None
    supervise: bool = False
    plant: Mapping[str, Any] = field(default_factory=dict)

    @property
    def record(self) -> bool:
        """Whether a bag is written."""
        return self.recorder is not None

    @property
    def bag(self) -> Path:
        """Folder of the bag."""
        return self.output / "bag"

    @property
    def bags(self) -> list[Path]:
        """Folders of all bags there are: a recorder that is started anew begins another one."""
        return sorted(self.output.glob(f"{self.bag.name}*"))

    @property
    def nodes(self) -> list[str]:
        """Names of the nodes in the order of their start."""
        others = set(MACHINES) - {self.machine}
        left_out = others if self.record else others | {RECORDER_NODE}
        return [name for name in PACKAGE_OF_NODE if name not in left_out]

    @property
    def modules(self) -> dict[str, str]:
        """Modules that processes of their own run, by the names of their nodes, as they start.

        A driver that shares its process with the controller stands for both.
        """
        modules = {name: node_module(name) for name in self.nodes}
        if self.processes == "shared":
            del modules[CONTROLLER_NODE]
            modules[DRIVER_NODE] = CONTROLLED_DRIVER
        return modules

    @property
    def machine(self) -> str:
        """Name of the node that is the machine: ``plant`` or ``driver``."""
        return self.configuration.machine

    @property
    def is_real(self) -> bool:
        """Whether the machine is a real one."""
        return self.machine == DRIVER_NODE

    def ros_arguments(self, node: str, life: int = 1) -> list[str]:
        """Return what follows ``--ros-args`` on the command line of `node`.

        Parameters
        ----------
        node : str
            Name of the node.
        life : int
            1 at first, one more each time it is started anew.
        """
        arguments = namespace_arguments(self.configuration.namespace)
        if node in self.configuration.configured:
            arguments += ["--params-file", str(self.configuration.path)]
        return [*arguments, *ros_arguments(self._overrides(node, life))]

    def _overrides(self, node: str, life: int) -> dict[str, Any]:
        if node == PLANT_NODE:
            followers = [name for name in (TWIN_NODE, RECORDER_NODE) if name in self.nodes]
            return {
                "mode": self.mode,
                "duration": self.duration,
                "lockstep_followers": followers,
                **self.plant,
            }
        if node == RECORDER_NODE:
            bag = self.bag if life == 1 else self.bag.with_name(f"{self.bag.name}-{life}")
            return {**(self.recorder or {}), "bag": str(bag)}
        if node == DRIVER_NODE:
            return {}
        overrides: dict[str, Any] = {"use_sim_time": not self.is_real}
        if (
            node == TWIN_NODE
            and self.supervise
            and not self.configuration.value(node, "state_file")
        ):
            overrides["state_file"] = str((self.output / "twin_state.json").absolute())
        return overrides


def plan_run(
    configuration: Configuration,
    *,
    mode: str | None,
    duration: float | None,
    processes: Processes,
    output: Path | None,
    recorder: Mapping[str, Any] | None,
    supervise: bool = False,
) -> RunPlan:
    """Return a checked plan; what is None comes from the configuration.

    Raises
    ------
    BadInputError
        For a duration that is not positive, an output folder that already holds something, a node
        that is not installed, supervision in a single process, or a process that driver and
        controller share where there is no driver.
    """
    chosen = duration
    is_real = configuration.machine == DRIVER_NODE
    if is_real and mode == "lockstep":
        raise BadInputError("--mode lockstep: a real machine does not wait; must be realtime")
    if is_real and processes == "single":
        raise BadInputError(
            "--processes single: a real machine's driver waits for nobody but the controller; "
            "must be separate or shared"
        )
    if not is_real and processes == "shared":
        raise BadInputError("--processes shared: there is no driver, the machine is simulated")
    if chosen is None:
        in_file = None if is_real else configuration.value(PLANT_NODE, "duration")
        chosen = in_file or DEFAULT_DURATION
    if supervise and processes == "single":
        raise BadInputError("--supervise: needs processes of their own: --processes separate")
    if not 0 < chosen <= 1e9:
        raise BadInputError(f"--duration {chosen!r} s: must be above 0 and at most 1e9")
    if output is None:
        begun = datetime.now().astimezone().strftime("%Y%m%d-%H%M%S")
        name = f"{configuration.name}{configuration.namespace.replace('/', '-')}"
        output = Path("runs") / f"{begun}-{name}"
    if output.exists() and (not output.is_dir() or any(output.iterdir())):
        raise BadInputError(
            f"--output {output}: already holds a run, must be a new or empty folder"
        )
    plan = RunPlan(
        configuration=configuration,
        mode="realtime" if is_real else mode or configuration.value(PLANT_NODE, "mode"),
        duration=float(chosen),
        processes=processes,
        output=output,
        recorder=recorder,
        supervise=supervise,
    )
    if missing := missing_packages(plan.nodes):
        raise BadInputError(f"bdt run: needs the package {' and '.join(missing)}, install it")
    return plan
