"""Whether the controller has the gains with which the twin simulates it."""

from rclpy.node import Node

from bdt_msgs_py.topics import DEAD_ZONE_PARAMETER
from bdt_twin.controller_account import Account, ControllerAccount
from bdt_twin.decision import ControllerGains


class GainsCheck:
    """Asks the controller for its gains, once it says that it is there.

    Parameters
    ----------
    node : rclpy.node.Node
        The twin.
    controller : str
        Name of the controller's node.
    timeout : float
        Wall time [s] after which a question without an answer is dropped, and asked again.
    known : tuple of ControllerGains
        Those that the controller may have: the twin's own, and those that it may have set.

    Attributes
    ----------
    fault : str
        Which gain is another one; empty if none is, or none is known.
    """

    def __init__(
        self, node: Node, controller: str, timeout: float, known: tuple[ControllerGains, ...]
    ) -> None:
        self._node, self._is_answered = node, False
        self._known = [dict(gains.by_name()) for gains in known]
        self.fault = ""
        names = (DEAD_ZONE_PARAMETER, *self._known[0])
        self._account = ControllerAccount(
            node, controller, timeout, names, lambda _set_by: not self._is_answered, self._compare
        )

    def close(self) -> None:
        """Take no answer any more: the node is about to go."""
        self._account.close()

    def _compare(self, account: Account) -> None:
        self._is_answered = True
        faults = [_first_difference(account.values, gains) for gains in self._known]
        if all(faults):
            self.fault = f"{faults[0]}: what it decides is for another controller"
            self._node.get_logger().warning(self.fault)


def _first_difference(values: dict[str, float], gains: dict[str, float]) -> str:
    """Return which of the gains that a controller has is another one; empty for none."""
    for name, value in gains.items():
        if values.get(name, value) != value:
            return f"the controller has {name} = {values[name]:g}, the twin {value:g}"
    return ""
