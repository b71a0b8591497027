"""The whole loop in process: three nodes, one executor, compared with the cores alone."""

import numpy as np
import pytest
from rclpy.node import Node
from std_msgs.msg import Float64MultiArray

from bdt_controller.controller import ControllerSettings, DeadZoneController
from bdt_controller.controller_node import ControllerNode
from bdt_controller.pid import PidGains
from bdt_controller.reference import ReferenceProfile, reference_at
from bdt_msgs_py.qos import qos_profile
from bdt_msgs_py.reading import read_samples
from bdt_msgs_py.topics import TELEMETRY, TELEMETRY_COLUMNS
from bdt_plant.gap_profile import GapProfile
from bdt_plant.plant import PlantModel, Sampling
from bdt_plant.plant_node import PlantNode
from bdt_plant.plant_simulator import PlantSimulator
from bdt_twin.dead_zone_tolerance import tolerance_for_gap
from bdt_twin.inverse_filter import InverseFilterEstimator, InverseFilterSettings
from bdt_twin.twin_node import TwinNode

DURATION = 6.0
STEP_TIME = 2.0
DELAY = 0.33
GROWTH_TIME = 8.0


def offline_loop():
    """Return telemetry of the loop made of the cores alone, the link included."""
    plant = PlantSimulator(PlantModel(), GapProfile(growth_time=GROWTH_TIME), Sampling())
    controller = DeadZoneController(PidGains(), ControllerSettings())
    reference = ReferenceProfile(step_time=STEP_TIME)
    estimator = InverseFilterEstimator(PlantModel(), InverseFilterSettings())
    pitch = PlantModel().lead_screw.pitch
    rows, on_the_way = [], []
    for step in range(round(DURATION * 500)):
        while on_the_way and on_the_way[0][0] <= plant.nanoseconds:
            tolerance = on_the_way.pop(0)[1]
            controller.configure(PidGains(), ControllerSettings(dead_zone_tolerance=tolerance))
        voltage = controller.step(reference_at(reference, plant.time), plant.position)
        rows.append(plant.advance(voltage))
        if (step + 1) % 50 == 0:
            batch = np.concatenate(rows[-50:])
            estimates = estimator.estimates(batch[:, 1], batch[:, 2])
            if estimates:
                arrival = round((batch[-1, 0] + DELAY) * 1e9)
                on_the_way.append((arrival, tolerance_for_gap(estimates[-1].gap, pitch)))
    return np.concatenate(rows)


@pytest.fixture(scope="module")
def expected():
    return offline_loop()


def test_the_nodes_compute_what_the_cores_compute_bit_for_bit(ros, expected):
    received = []
    listener = ros.create(Node, "listener")
    listener.create_subscription(
        Float64MultiArray,
        TELEMETRY.name,
        lambda message: received.append(read_samples(message, TELEMETRY_COLUMNS).copy()),
        qos_profile(TELEMETRY),
    )
    ros.create(ControllerNode, use_sim_time=True, reference__step_time=STEP_TIME)
    twin = ros.create(TwinNode, use_sim_time=True, communication_delay=DELAY)
    plant = ros.create(
        PlantNode,
        duration=DURATION,
        gap__growth_time=GROWTH_TIME,
        lockstep_followers=["twin"],
    )
    ros.result(plant.finished, deadline=60.0)
    ros.spin_until(lambda: len(received) == round(DURATION * 10))
    np.testing.assert_array_equal(np.concatenate(received), expected)
    assert twin._health().values["reconfigurations"] > 5
