"""The conditions under which estimators are compared."""

from dataclasses import replace

import numpy as np

from bdt_controller.pid import PidGains
from bdt_controller.reference import ReferenceProfile
from bdt_plant.actuator import IDEAL_ACTUATOR, ActuatorParameters
from bdt_plant.gap_profile import GapProfile
from bdt_plant.plant import PlantModel, Sampling
from bdt_plant.sensor import SensorParameters
from bdt_study.evaluation.case import Case
from bdt_study.evaluation.machine_effects import with_effects
from bdt_study.evaluation.machines import MACHINES
from bdt_study.simulation.closed_loop import Scenario
from bdt_twin.link import LinkSettings

DURATION = 80.0
"""Duration of a run [s]."""


LABORATORY = Case(
    "laboratory",
    "1 um noise, 0.1 um quantization, k_B 5 % off",
    noise=1e-6,
    quantization=1e-7,
    gain_error=0.05,
)

CASES = (
    Case("clean", "simulated signals as they are"),
    LABORATORY,
    Case(
        "harsh",
        "5 um noise, 1 um quantization, k_B 5 %, m and k 2 %, c 20 % off",
        noise=5e-6,
        quantization=1e-6,
        gain_error=0.05,
        mechanics_error=0.02,
        damping_error=0.2,
    ),
    Case("exact_model", "5 um noise and nothing else, gap that ramps up", noise=5e-6, gap="ramp"),
    replace(
        LABORATORY,
        name="laboratory_loop",
        description="laboratory.yaml: with m and k 2 % off and 24 V",
        mechanics_error=0.02,
        voltage_limit=24.0,
    ),
    replace(
        LABORATORY,
        name="slow_link",
        description="laboratory, delay of 5 s",
        link=LinkSettings(communication_delay=5.0),
    ),
    replace(
        LABORATORY,
        name="lossy_link",
        description="laboratory, log-normal delays around 1 s, half of the requests lost",
        link=LinkSettings(delay_distribution="log_normal", delay_spread=0.7, request_loss=0.5),
    ),
    replace(
        LABORATORY,
        name="dropped_samples",
        description="laboratory, 1 % of the samples dropped",
        drop_probability=0.01,
    ),
    replace(
        LABORATORY,
        name="sampled_1000_hz",
        description="laboratory, telemetry at 1000 Hz",
        sampling_rate=1000.0,
    ),
    replace(
        LABORATORY, name="constant_gap", description="laboratory, gap that stays", gap="constant"
    ),
    replace(LABORATORY, name="ramp_gap", description="laboratory, gap that ramps up", gap="ramp"),
    replace(
        LABORATORY,
        name="table_gap",
        description="laboratory, gap that grows in fits and starts",
        gap="table",
    ),
    *MACHINES,
)
"""Every case, in the order of the table."""


def draw_scenario(case: Case, seed: int) -> Scenario:
    """Return a random scenario of a case.

    What the paper leaves open is drawn anew for each seed: amplitude (4 to 10 mm), length of the
    steps (5 to 12 s), profile of the gap (up to 15 to 30 degrees), sensor noise and the plant's
    deviations from the twin's model, which is ``PlantModel()``. A machine's effects are drawn apart
    from these.

    Parameters
    ----------
    case : Case
        The conditions.
    seed : int
        Number of the scenario.
    """
    generator = np.random.default_rng((seed, 20_220_601))
    reference = ReferenceProfile(
        first=float(generator.uniform(4e-3, 10e-3)), step_time=float(generator.uniform(5.0, 12.0))
    )
    gap = _draw_gap(case.gap, generator)
    model = _draw_model(case, generator)
    scenario = Scenario(
        duration=DURATION,
        reference=reference,
        gap=gap,
        model=model,
        gains=PidGains(),
        sampling=Sampling(sampling_rate=case.sampling_rate),
        sensor=SensorParameters(
            noise=case.noise,
            quantization=case.quantization,
            drop_probability=case.drop_probability,
            seed=seed,
        ),
        actuator=_actuator(case),
        voltage_limit=case.voltage_limit,
    )
    return with_effects(scenario, case.effects, seed)


def _actuator(case: Case) -> ActuatorParameters:
    if not case.voltage_limit:
        return IDEAL_ACTUATOR
    return ActuatorParameters(saturation=True, voltage_limit=case.voltage_limit)


def _draw_gap(kind: str, generator: np.random.Generator) -> GapProfile:
    kind = kind or str(generator.choice(["ramp", "power_law", "constant"]))
    final = float(np.deg2rad(generator.uniform(15.0, 30.0)))
    initial = float(np.deg2rad(generator.uniform(0.0, 10.0)))
    if kind == "constant":
        return GapProfile(kind="constant", initial=final)
    if kind == "table":
        times = np.concatenate([[0.0], np.sort(generator.uniform(0.0, DURATION, 4)), [DURATION]])
        gaps = np.concatenate([[initial], np.sort(generator.uniform(initial, final, 4)), [final]])
        return GapProfile(kind="table", table_times=tuple(times.tolist()), table_gaps=tuple(gaps))
    exponent = float(generator.uniform(1.0, 3.0))
    return GapProfile(
        kind=kind, initial=initial, final=final, growth_time=DURATION, exponent=exponent
    )


def _draw_model(case: Case, generator: np.random.Generator) -> PlantModel:
    """Return the plant: the twin's model with errors of the stated size and of either sign."""
    nominal = PlantModel()

    def off(value: float, error: float) -> float:
        return value * (1.0 + error * float(generator.choice([-1.0, 1.0])))

    structure = nominal.structure
    return replace(
        nominal,
        motor=replace(
            nominal.motor,
            back_emf_constant=off(nominal.motor.back_emf_constant, case.gain_error),
        ),
        structure=replace(
            structure,
            mass=off(structure.mass, case.mechanics_error),
            stiffness=off(structure.stiffness, case.mechanics_error),
            damping=off(structure.damping, case.damping_error),
        ),
    )
