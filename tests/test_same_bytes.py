"""The loop gives the same bytes with other versions of the libraries and on other processors.

The digests hold in every environment that the tests run in: with the versions of requirements.lock
on Python 3.11 and 3.12, and with those of `make test-noble`. Whoever changes a model or an
estimator changes them, to the same new ones everywhere; run as a program this file prints them.
"""

import json
import os
import subprocess
import sys
from hashlib import sha256
from pathlib import Path

import numpy as np
import pytest

from bdt_bringup.configuration import load_configuration
from bdt_controller.controller import ControllerSettings
from bdt_controller.parameters import PARAMETERS as CONTROLLER
from bdt_controller.pid import PidGains
from bdt_controller.reference import ReferenceProfile
from bdt_msgs_py.configuration_files import find_configuration
from bdt_msgs_py.parameter_tables import parameter_sets
from bdt_plant.actuator import ActuatorParameters
from bdt_plant.gap_profile import GapProfile
from bdt_plant.lead_screw import LeadScrewParameters
from bdt_plant.motor import MotorParameters
from bdt_plant.parameters import PARAMETERS as PLANT
from bdt_plant.plant import PlantModel, Sampling
from bdt_plant.sensor import SensorParameters
from bdt_plant.structure import StructureParameters
from bdt_study.simulation.closed_loop import Scenario
from bdt_study.simulation.twin_loop import simulate_with_twin
from bdt_twin.dead_zone_tolerance import DeadZoneSettings
from bdt_twin.estimator_choice import EstimatorChoice, create_estimator
from bdt_twin.inverse_filter import InverseFilterSettings
from bdt_twin.link import LinkSettings
from bdt_twin.output_error_settings import OutputErrorSettings
from bdt_twin.parameters import PARAMETERS as TWIN

DURATION = 30.0

HARSH = {
    "plant": {
        "gap.exponent": 1.7,
        "motor.coulomb_friction": 1e-3,
        "sensor.quantization": 0.0,
        "sensor.delay": 4e-4,
        "sensor.drop_probability": 0.01,
    },
    "controller": {},
    "twin": {"delay_distribution": "log_normal", "delay_spread": 0.3},
}
"""What is added to laboratory.yaml so that all that rounds has a part in the loop."""

CASES = {"paper": ("paper", {}), "laboratory": ("laboratory", {}), "harsh": ("laboratory", HARSH)}

DIGESTS = {
    "paper": "86982255de2973a01f084118fc8da64411f8282c6bf96c5512c1ee828a9d95f0",
    "laboratory": "1ac86f0d97655b9be305d6715ee80547b83862ade17556c9a75e020d56f23807",
    "harsh": "9cbd7a63ef3c24988ba73d7783e2ed04bb66cb025a73b2b33107b59d96b3e241",
}
"""SHA-256 of 30 simulated seconds: voltage, position, reading, dead zone and estimates."""

OLD_PROCESSOR = {
    "OPENBLAS_CORETYPE": "Prescott",
    "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4",
    # The names of numpy 1, then those of numpy 2; each warns of those of the other.
    "NPY_DISABLE_CPU_FEATURES": "AVX2 FMA3 AVX512F AVX512CD AVX512_SKX X86_V3 X86_V4 AVX512_ICL",
    "PYTHONWARNINGS": "ignore",
}
"""Makes the libraries calculate as on a processor that cannot multiply and add at once."""


def model_of(parameters):
    """Return the mechanism that a node's parameters describe."""
    return PlantModel(
        *(parameters[part] for part in (MotorParameters, LeadScrewParameters, StructureParameters))
    )


def digest_of(case):
    """Return the digest of a case."""
    name, changes = CASES[case]
    values = load_configuration(find_configuration(name)).values
    plant, controller, twin = (
        {type(each): each for each in parameter_sets(table, values[node] | changes.get(node, {}))}
        for node, table in (("plant", PLANT), ("controller", CONTROLLER), ("twin", TWIN))
    )
    settings = controller[ControllerSettings]
    scenario = Scenario(
        DURATION,
        controller[ReferenceProfile],
        plant[GapProfile],
        settings.dead_zone_tolerance,
        model_of(plant),
        controller[PidGains],
        plant[Sampling],
        plant[SensorParameters],
        plant[ActuatorParameters],
        settings.voltage_limit,
    )
    estimator = create_estimator(
        twin[EstimatorChoice],
        model_of(twin),
        twin[InverseFilterSettings],
        twin[OutputErrorSettings],
    )
    run = simulate_with_twin(scenario, estimator, twin[LinkSettings], twin[DeadZoneSettings])
    estimates = np.array(
        [
            (each.time, each.gap, each.uncertainty, each.growth, each.growth_uncertainty)
            for each in run.estimates
        ]
    )
    assert len(np.unique(run.tolerances)) > 5
    signals = (run.loop.u, run.loop.q3, run.loop.measured, run.tolerances, estimates)
    return sha256(b"".join(signal.tobytes() for signal in signals)).hexdigest()


@pytest.mark.parametrize("case", CASES)
def test_the_bytes_are_those_of_every_other_environment(case):
    assert digest_of(case) == DIGESTS[case]


def test_the_bytes_are_the_same_on_an_old_processor():
    # The folders of tests beside this file have the names of the packages.
    program = [sys.executable, "-P", str(Path(__file__))]
    ended = subprocess.run(
        program, env=os.environ | OLD_PROCESSOR, capture_output=True, text=True, check=True
    )
    assert json.loads(ended.stdout) == DIGESTS


if __name__ == "__main__":
    print(json.dumps({case: digest_of(case) for case in CASES}, indent=4))
