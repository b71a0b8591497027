"""What a page asks for, done with the parameters of the nodes."""

import math
from collections.abc import Callable, Mapping
from typing import Any

from bdt_bringup.configuration import Configuration, load_configuration
from bdt_bringup.installed import parameter_table
from bdt_live.page_requests import PageRequest, ParameterValue
from bdt_live.remote_parameters import RemoteParameters
from bdt_msgs_py.command_errors import BadInputError
from bdt_msgs_py.configuration_files import find_configuration
from bdt_msgs_py.parameter_tables import known_parameters
from bdt_msgs_py.topics import CONTROLLER_NODE, PLANT_NODE, TWIN_NODE

NEVER = 1e9
"""Simulated time [s] at which no plant pauses."""

STEP = 0.04
"""Simulated time of a single step [s]: what one batch of telemetry shows."""

WORN = math.radians(30.0)
WEAR_TIME = 60.0
"""The gap [rad] to which a wear that is started goes, and the time [s] that it takes."""

OF_TIME = ("pace", "pause_at")
"""Parameters that a preset leaves alone."""

SETS_DEAD_ZONE = "reconfigure"
"""Parameter of a twin: whether it sets the controller's dead zone."""

Answer = Callable[[str | None], None]


class LoopControl:
    """Sets parameters of a loop's nodes.

    Parameters
    ----------
    parameters : mapping of str to RemoteParameters
        Those of each node.
    time : callable
        Returns simulated time [s].
    gap : callable
        Returns the gap [rad]; None while nobody knows it.
    """

    def __init__(
        self,
        parameters: Mapping[str, RemoteParameters],
        time: Callable[[], float],
        gap: Callable[[], float | None],
    ) -> None:
        self._parameters, self._time, self._gap = parameters, time, gap

    @property
    def is_paused(self) -> bool:
        """Whether the plant waits for a user; in the middle of a step, too."""
        pause_at = self._plant_value("pause_at")
        return pause_at is not None and pause_at <= self._time() + 2.0 * STEP

    @property
    def pace(self) -> float | None:
        """Simulated seconds in a second at most; 0 for no limit, None where there is no pace."""
        mode = self._parameters[PLANT_NODE].values.get("mode")
        return self._plant_value("pace") if mode == "lockstep" else None

    def do(self, request: PageRequest, answer: Answer) -> None:
        """Do what a page asks for, of what parameters can do, and call `answer`.

        It gets a reason why it was not done; None once it is.
        """
        time = self._time()
        if request.action == "set":
            self._parameters[request.node].set(dict(request.values), answer)
        elif request.action == "preset":
            self._use_preset(request.preset, answer)
        elif request.action == "wear":
            gap: dict[str, ParameterValue] = {
                "gap.kind": "ramp",
                "gap.initial": min(self._gap() or 0.0, WORN),
                "gap.final": WORN,
                "gap.begin_time": time,
                "gap.growth_time": WEAR_TIME,
            }
            self._parameters[PLANT_NODE].set(gap, answer)
        else:
            changes: dict[str, dict[str, ParameterValue]] = {
                "pause": {"pause_at": 0.0},
                "resume": {"pause_at": NEVER},
                "step": {"pause_at": time + 1.5 * STEP},
                "pace": {"pace": request.amount},
            }
            self._parameters[PLANT_NODE].set(changes[request.action], answer)

    def _plant_value(self, name: str) -> float | None:
        value = self._parameters[PLANT_NODE].values.get(name)
        return value if isinstance(value, float) else None

    def _use_preset(self, name: str, answer: Answer) -> None:
        try:
            configuration = load_configuration(find_configuration(name))
            changes = {node: self._changes(configuration, node) for node in configuration.values}
        except BadInputError as error:
            answer(str(error))
            return
        changes[PLANT_NODE]["gap.begin_time"] = self._time()
        twin = changes[TWIN_NODE]
        # Meanwhile the twin leaves the dead zone alone: it would set another one than the figure
        # begins with, and warn of somebody else who sets it.
        steps = [
            (TWIN_NODE, {**twin, SETS_DEAD_ZONE: False} if twin else {}),
            (CONTROLLER_NODE, changes[CONTROLLER_NODE]),
            (PLANT_NODE, changes[PLANT_NODE]),
            (TWIN_NODE, {SETS_DEAD_ZONE: True} if twin.get(SETS_DEAD_ZONE) else {}),
        ]
        self._set_in_turn([(node, values) for node, values in steps if values], answer)

    def _set_in_turn(self, steps: list[tuple[str, dict[str, Any]]], answer: Answer) -> None:
        """Set parameters of one node after the other; the answer is the first reason why not."""
        reasons: list[str] = []

        def go_on(reason: str | None) -> None:
            if reason is not None:
                reasons.append(reason)
            if not steps:
                answer(reasons[0] if reasons else None)
                return
            node, values = steps.pop(0)
            self._parameters[node].set(values, go_on)

        go_on(None)

    def _changes(self, configuration: Configuration, node: str) -> dict[str, Any]:
        known = known_parameters(parameter_table(node))
        return {
            name: configuration.value(node, name)
            for name in self._parameters[node].reconfigurable
            if name in known and name not in OF_TIME
        }
