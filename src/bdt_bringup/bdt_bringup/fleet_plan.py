"""What `bdt twins` starts: a twin with its ROS arguments for each machine, and in which process."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from bdt_bringup.configuration import Configuration, load_configuration
from bdt_bringup.installed import missing_packages
from bdt_msgs_py.command_errors import BadInputError
from bdt_msgs_py.configuration_files import find_configuration
from bdt_msgs_py.loop_namespace import full_namespace, namespace_arguments
from bdt_msgs_py.parameter_tables import ros_arguments
from bdt_msgs_py.topics import PLANT_NODE, TWIN_NODE

MOST_WORKERS = 1024


@dataclass(frozen=True)
class FleetTwin:
    """The twin of a machine.

    Attributes
    ----------
    namespace : str
        Namespace of the machine's nodes, for example ``/left``.
    arguments : tuple of str
        What follows ``--ros-args`` on the command line of its node.
    """

    namespace: str
    arguments: tuple[str, ...]

    @property
    def name(self) -> str:
        """Full name of the node."""
        return f"{self.namespace}/{TWIN_NODE}"


def plan_fleet(
    machines: Sequence[str],
    *,
    config: str | None = None,
    states: Path | None = None,
    use_sim_time: bool = False,
) -> list[FleetTwin]:
    """Return the twins of a fleet, each with parameters that were checked.

    Parameters
    ----------
    machines : sequence of str
        ``NAMESPACE``, or ``NAMESPACE=CONFIG`` for a machine with a configuration of its own.
    config : str, optional
        Name or file of the configuration of all others; None for the defaults.
    states : Path, optional
        Folder in which each twin keeps its state.
    use_sim_time : bool
        Whether the machines are simulated and publish a clock, each in its namespace.

    Raises
    ------
    BadInputError
        For a namespace that is none or comes twice, a configuration that is not as it must be, a
        state file that twins would share, or a twin that is not installed.
    """
    if missing := missing_packages([TWIN_NODE]):
        raise BadInputError(f"bdt twins: needs the package {' and '.join(missing)}, install it")
    configurations = [_configuration(machine, config) for machine in machines]
    _refuse_twice("machine", [each.namespace or "/" for each in configurations])
    if states is None:
        files = [each.value(TWIN_NODE, "state_file") for each in configurations]
        _refuse_twice("state_file", [file for file in files if file])
    return [_twin(each, states, use_sim_time=use_sim_time) for each in configurations]


def shared_out(twins: Sequence[FleetTwin], workers: int) -> list[list[FleetTwin]]:
    """Return which twins each process has, as evenly as it goes.

    Parameters
    ----------
    twins : sequence of FleetTwin
        All twins.
    workers : int
        Most processes.

    Raises
    ------
    BadInputError
        If that is not a number of processes.
    """
    if not 1 <= workers <= MOST_WORKERS:
        raise BadInputError(f"--workers {workers}: must be 1 to {MOST_WORKERS}")
    return [list(twins[first::workers]) for first in range(min(workers, len(twins)))]


def _configuration(machine: str, config: str | None) -> Configuration:
    name, has_own, own = machine.partition("=")
    # Which machine a file has besides is nothing to its twin.
    return load_configuration(
        find_configuration(own if has_own else config), full_namespace(name), PLANT_NODE
    )


def _twin(configuration: Configuration, states: Path | None, *, use_sim_time: bool) -> FleetTwin:
    namespace = configuration.namespace
    arguments = namespace_arguments(namespace)
    if TWIN_NODE in configuration.configured:
        arguments += ["--params-file", str(configuration.path)]
    overrides: dict[str, object] = {"use_sim_time": True} if use_sim_time else {}
    if states is not None:
        # A dot is in no namespace, so no two of them have the same file.
        name = f"{namespace}/{TWIN_NODE}".lstrip("/").replace("/", ".")
        overrides["state_file"] = str(states.absolute() / f"{name}.json")
    return FleetTwin(namespace, (*arguments, *ros_arguments(overrides)))


def _refuse_twice(what: str, values: Sequence[str]) -> None:
    for value, count in Counter(values).items():
        if count > 1:
            raise BadInputError(f"{what} {value}: comes {count} times, each twin needs its own")
