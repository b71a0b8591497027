"""A control period compiled gives the floats of the plain one."""

import numpy as np
import pytest
from interrupted_calls import end_of_interrupted

from bdt_plant import compilation
from bdt_plant.actuator import ActuatorParameters
from bdt_plant.compiled_period import compiled_hold_period
from bdt_plant.gap_profile import GapProfile
from bdt_plant.lead_screw import LeadScrewParameters
from bdt_plant.motor import MotorParameters
from bdt_plant.plant import PlantModel, Sampling, hold_period
from bdt_plant.plant_simulator import PlantSimulator
from bdt_plant.sensor import IDEAL_SENSOR, SensorParameters

PLANTS = {
    "paper": (PlantModel(), GapProfile(), IDEAL_SENSOR),
    "friction and a pitch that is an int": (
        PlantModel(
            motor=MotorParameters(coulomb_friction=0.05, viscous_friction=1e-4),
            lead_screw=LeadScrewParameters(pitch=1),
        ),
        GapProfile(kind="constant", initial=0.2),
        IDEAL_SENSOR,
    ),
    "sensor": (
        PlantModel(),
        GapProfile(growth_time=3.0),
        SensorParameters(
            noise=1e-6, quantization=1e-7, delay=7e-4, drop_probability=0.1, bias=1e-6
        ),
    ),
}


@pytest.mark.parametrize("plant", PLANTS)
def test_the_compiled_period_gives_the_floats_of_the_plain_one(plant):
    model, profile, sensor = PLANTS[plant]
    voltages = 30 * np.random.default_rng(3).standard_normal(600)
    runs = []
    for period in (hold_period, compiled_hold_period()):
        simulator = PlantSimulator(
            model,
            profile,
            Sampling(),
            sensor,
            ActuatorParameters(saturation=True, voltage_limit=24.0),
            period,
        )
        rows = np.concatenate([simulator.advance(voltage) for voltage in voltages])
        runs.append((rows.tobytes(), simulator.truth(), simulator.saturated_steps))
    assert runs[0] == runs[1]
    assert 0 < runs[0][2] < len(voltages)


def test_without_numba_the_period_is_the_plain_one(monkeypatch):
    monkeypatch.setattr(compilation, "find_spec", lambda _: None)
    period = compiled_hold_period.__wrapped__()
    simulators = [
        PlantSimulator(PlantModel(), GapProfile(), Sampling(), period=one)
        for one in (hold_period, period)
    ]
    rows = [simulator.advance(12.0).tobytes() for simulator in simulators]
    assert rows[0] == rows[1]


PERIOD = """
from bdt_plant.cogging import CoggingParameters
from bdt_plant.compiled_period import compiled_period_of
from bdt_plant.gap_profile import GapProfile
from bdt_plant.plant import PlantModel, Sampling
from bdt_plant.plant_simulator import PlantSimulator
model = PlantModel({effect})
period = compiled_period_of(model)
simulator = PlantSimulator(model, GapProfile(), Sampling(), period=period)
"""


@pytest.mark.parametrize("effect", ["", "cogging=CoggingParameters(3e-3)"])
def test_ctrl_c_in_a_compiled_period_is_an_exception_as_anywhere(effect):
    """A node, a notebook and a worker go on from there; where numba made a state they crashed."""
    pytest.importorskip("numba")
    assert end_of_interrupted(PERIOD.format(effect=effect), "simulator.advance(9.0)") == (0, "")
