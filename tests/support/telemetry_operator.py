"""An operator who feeds a twin batch by batch and sets parameters of the nodes."""

import numpy as np
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.parameter_client import AsyncParameterClient
from std_msgs.msg import Float64MultiArray

from bdt_msgs_py.qos import qos_profile
from bdt_msgs_py.topics import TELEMETRY, TELEMETRY_COLUMNS
from bdt_msgs_py.writing import sample_message

SAMPLING_RATE = 5000
BATCH = 500


class Operator:
    """Sends telemetry at rest in place of a machine, and sets parameters.

    Attributes
    ----------
    node : rclpy.node.Node
        The operator's own.
    twin
        The twin that is fed; set by whoever starts it.
    """

    def __init__(self, ros):
        self.ros, self.samples = ros, 0
        self.node = ros.create(Node, "operator")
        self.telemetry = self.node.create_publisher(
            Float64MultiArray, TELEMETRY.name, qos_profile(TELEMETRY)
        )
        self.twin = None

    def set(self, node, name, value):
        client = AsyncParameterClient(self.node, node)
        self.ros.spin_until(client.services_are_ready)
        (result,) = self.ros.result(client.set_parameters([Parameter(name, value=value)])).results
        assert result.successful, result.reason

    def estimate(self):
        """Have the twin estimate once more."""
        before = self.health["estimates"]
        batch = np.zeros((BATCH, 3))
        batch[:, 0] = (self.samples + np.arange(BATCH)) / SAMPLING_RATE
        self.samples += BATCH
        self.telemetry.publish(sample_message(batch, TELEMETRY_COLUMNS))
        self.ros.spin_until(lambda: self.health["estimates"] > before)

    @property
    def health(self):
        """What the twin says of itself."""
        return self.twin._health().values
