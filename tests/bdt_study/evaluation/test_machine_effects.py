"""Random machines: every effect within its size, and nothing that was not asked for."""

from dataclasses import fields, replace

import numpy as np
import pytest

from bdt_plant.plant import PlantModel
from bdt_study.evaluation.cases import CASES, draw_scenario
from bdt_study.evaluation.machine_effects import NO_EFFECTS, MachineEffects, with_effects
from bdt_study.simulation.closed_loop import Scenario

BY_NAME = {case.name: case for case in CASES}
SEEDS = range(200)


def sizes_of(scenario):
    """Return the size of each effect of a scenario, in the order of nothing in particular."""
    model, nominal = scenario.model, PlantModel()
    motor, structure = model.motor, model.structure
    static, coulomb = model.stribeck.static_friction, motor.coulomb_friction

    def error(part, name):
        return abs(getattr(getattr(model, part), name) / getattr(getattr(nominal, part), name) - 1)

    return {
        "friction": coulomb,
        "stribeck": static / coulomb - 1.0 if coulomb else 0.0,
        "friction_asymmetry": abs(model.stribeck.friction_asymmetry),
        "viscous_friction": motor.viscous_friction,
        "cogging": model.cogging.cogging_torque,
        "cubic_stiffness": model.beams.cubic_stiffness,
        "push": model.pushes.force,
        "delay": scenario.sensor.delay,
        "drift": abs(scenario.sensor.drift),
        "periodic_error": scenario.sensor.periodic_error,
        "offset": abs(scenario.actuator.offset),
        "resolution": scenario.actuator.resolution,
        "payload": model.structure.top_mass_ratio - 1.0,
        "lag": model.amplifier.lag,
        "thread_error": model.screw_mechanics.thread_error,
        "gain_error": error("motor", "back_emf_constant"),
        "resistance_error": error("motor", "resistance"),
        "mechanics_error": max(error("structure", "mass"), error("structure", "stiffness")),
        "damping_error": error("structure", "damping"),
        "load": bool(model.screw_mechanics.efficiency),
        "inertia": abs(motor.inertia / nominal.motor.inertia - 1),
        "screw": model.screw_mechanics.stiffness,
        "structure": 0.0 if structure else 1.0,
    }


@pytest.mark.parametrize("name", ["friction", "stribeck", "payload", "everyday", "unknown_machine"])
def test_each_size_is_drawn_evenly_up_to_the_largest(name):
    effects = BY_NAME[name].effects
    drawn = [sizes_of(with_effects(Scenario(), effects, seed)) for seed in SEEDS]
    for field in fields(MachineEffects):
        if field.name in ("least", "load", "resolution", "mechanics_error"):
            continue
        largest = getattr(effects, field.name)
        sizes = np.array([each[field.name] for each in drawn])
        assert (sizes >= effects.least * largest * (1 - 1e-9)).all()
        assert (sizes <= largest * (1 + 1e-9)).all()
        middle = 0.5 * (1.0 + effects.least) * largest
        assert np.mean(sizes) == pytest.approx(middle, rel=0.15)
    assert {each["load"] for each in drawn} == {effects.load}
    assert {each["resolution"] for each in drawn} == {effects.resolution}
    assert max(each["mechanics_error"] for each in drawn) <= effects.mechanics_error + 1e-9


@pytest.mark.parametrize(
    ("name", "effect"),
    [
        ("friction", "friction"),
        ("cogging", "cogging"),
        ("late_reading", "delay"),
        ("stiffening_beams", "cubic_stiffness"),
        ("pushes", "push"),
        ("drift", "drift"),
        ("amplifier_offset", "offset"),
        ("late_voltage", "lag"),
        ("thread", "thread_error"),
        ("payload", "payload"),
    ],
)
def test_a_case_of_one_effect_has_that_alone(name, effect):
    for seed in range(5):
        sizes = sizes_of(draw_scenario(BY_NAME[name], seed))
        assert {key for key, size in sizes.items() if size > 1e-12} == {effect}


def test_errors_that_have_a_sign_have_either():
    effects = BY_NAME["unknown_machine"].effects
    machines = [with_effects(Scenario(), effects, seed) for seed in range(20)]
    for sign in (
        [machine.actuator.offset for machine in machines],
        [machine.sensor.drift for machine in machines],
        [machine.model.stribeck.friction_asymmetry for machine in machines],
        [machine.model.motor.resistance - 12.0 for machine in machines],
    ):
        assert min(sign) < 0.0 < max(sign)


def test_another_effect_does_not_move_those_that_are_there():
    some = MachineEffects(friction=0.04, offset=0.05)
    more = replace(
        some, cogging=3e-3, stribeck=0.6, push=2.0, payload=0.5, lag=1e-3, thread_error=2e-6
    )
    one, other = (sizes_of(with_effects(Scenario(), each, 3)) for each in (some, more))
    assert one["friction"] == other["friction"]
    assert one["offset"] == other["offset"]


def test_without_effects_a_scenario_stays_as_it_is():
    scenario = Scenario()
    assert with_effects(scenario, NO_EFFECTS, 3) is scenario


def test_each_machine_that_nobody_described_is_a_case():
    assert [case.name for case in CASES if case.effects != NO_EFFECTS] == [
        "friction",
        "stribeck",
        "cogging",
        "late_reading",
        "stiffening_beams",
        "pushes",
        "drift",
        "amplifier_offset",
        "late_voltage",
        "thread",
        "payload",
        "everyday",
        "unknown_machine",
    ]


def test_a_bound_for_the_true_model_is_not_one_for_a_machine():
    assert not any(case.is_exact for case in CASES if case.effects != NO_EFFECTS)
