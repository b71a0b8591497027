"""What is wrong with a machine, drawn at random: effects that no estimator was told of."""

from dataclasses import dataclass, replace

import numpy as np

from bdt_plant.actuator import ActuatorParameters
from bdt_plant.amplifier_lag import AmplifierLag
from bdt_plant.cogging import CoggingParameters
from bdt_plant.motor import MotorParameters
from bdt_plant.plant import PlantModel
from bdt_plant.pushes import PushParameters
from bdt_plant.screw_load import ScrewMechanics
from bdt_plant.sensor import SensorParameters
from bdt_plant.stiffening_tower import BeamParameters
from bdt_plant.stribeck import StribeckParameters
from bdt_plant.structure import StructureParameters
from bdt_study.simulation.closed_loop import Scenario

STREAM = 20_260_801
"""Sets the draws of effects apart from those of the scenario around them."""


@dataclass(frozen=True)
class MachineEffects:
    """Largest size of each effect; 0 for none. Each size is drawn evenly up to the largest.

    Attributes
    ----------
    least : float
        Least share of the largest size that is drawn.
    friction : float
        Coulomb friction of the motor [N m].
    stribeck : float
        What friction at rest is more than at speed, as a fraction.
    friction_asymmetry : float
        Share by which friction is larger in one direction, of either sign.
    viscous_friction : float
        Viscous friction of the motor [N m s/rad].
    cogging : float
        Cogging torque [N m], 12, 24 or 36 times a turn.
    load : bool
        Whether the motor feels the structure, through a screw with an efficiency of 0.2 to 0.9.
    cubic_stiffness : float
        Stiffening of the beams [N/m^3].
    push : float
        Force of pushes of 50 ms every 7 s on platform 2 or 3 [N].
    delay : float
        Age of a reading [s].
    drift : float
        Drift of the sensor [m/s], of either sign.
    periodic_error : float
        Error of the sensor that repeats every 20 um [m].
    offset : float
        Offset of the amplifier [V], of either sign.
    resolution : float
        Step between two voltages [V], which is not drawn.
    payload : float
        Mass on the top platform, as a fraction of the platform's.
    lag : float
        Time constant with which the amplifier follows its command [s].
    thread_error : float
        Error of the screw's travel that repeats with each turn [m].
    gain_error, resistance_error, mechanics_error, damping_error : float
        Deviation of k_B, of R, of m and k, and of c, as fractions of either sign.
    """

    least: float = 0.0
    friction: float = 0.0
    stribeck: float = 0.0
    friction_asymmetry: float = 0.0
    viscous_friction: float = 0.0
    cogging: float = 0.0
    load: bool = False
    cubic_stiffness: float = 0.0
    push: float = 0.0
    delay: float = 0.0
    drift: float = 0.0
    periodic_error: float = 0.0
    offset: float = 0.0
    resolution: float = 0.0
    payload: float = 0.0
    lag: float = 0.0
    thread_error: float = 0.0
    gain_error: float = 0.0
    resistance_error: float = 0.0
    mechanics_error: float = 0.0
    damping_error: float = 0.0


NO_EFFECTS = MachineEffects()
"""A mechanism as the paper has it."""


class Draws:
    """Random sizes of effects.

    Parameters
    ----------
    generator : numpy.random.Generator
        What they are drawn from.
    least : float
        Least share of the largest size that is drawn.
    """

    def __init__(self, generator: np.random.Generator, least: float) -> None:
        self._generator = generator
        self._least = least

    def size(self, largest: float) -> float:
        """Return a size from the least to the largest."""
        return largest * float(self._generator.uniform(self._least, 1.0))

    def signed(self, largest: float) -> float:
        """Return a size of either sign."""
        return self.size(largest) * float(self._generator.choice([-1.0, 1.0]))

    def between(self, low: float, high: float) -> float:
        """Return a number between two others."""
        return float(self._generator.uniform(low, high))

    def one_of(self, *choices: int) -> int:
        """Return one of some numbers."""
        return int(self._generator.choice(choices))


def with_effects(scenario: Scenario, effects: MachineEffects, seed: int) -> Scenario:
    """Return a scenario with a machine whose effects are drawn.

    Parameters
    ----------
    scenario : Scenario
        A scenario with the paper's mechanism.
    effects : MachineEffects
        Largest sizes.
    seed : int
        Number of the scenario.
    """
    if effects == NO_EFFECTS:
        return scenario
    # Each is drawn whether it is used or not: an effect does not move the others.
    draws = Draws(np.random.default_rng((seed, STREAM)), effects.least)
    model = _draw_mechanism(scenario.model, effects, draws)
    pushes = _draw_pushes(effects, draws, seed)
    sensor = _draw_sensor(scenario.sensor, effects, draws)
    actuator = _draw_actuator(scenario.actuator, effects, draws)
    laden = replace(model.structure, top_mass_ratio=1.0 + draws.size(effects.payload))
    screw = replace(model.screw_mechanics, thread_error=draws.size(effects.thread_error))
    amplifier = AmplifierLag(draws.size(effects.lag))
    model = replace(
        model, structure=laden, screw_mechanics=screw, pushes=pushes, amplifier=amplifier
    )
    return replace(scenario, model=model, sensor=sensor, actuator=actuator)


def _draw_mechanism(model: PlantModel, effects: MachineEffects, draws: Draws) -> PlantModel:
    motor, structure = model.motor, model.structure
    coulomb = draws.size(effects.friction)
    stribeck = StribeckParameters(
        static_friction=coulomb * (1.0 + draws.size(effects.stribeck)),
        stribeck_speed=draws.between(1.0, 4.0),
        friction_asymmetry=draws.signed(effects.friction_asymmetry),
    )
    efficiency = draws.between(0.2, 0.9)
    return PlantModel(
        _draw_motor(motor, effects, draws, coulomb),
        model.lead_screw,
        _draw_structure(structure, effects, draws),
        stribeck,
        CoggingParameters(draws.size(effects.cogging), draws.one_of(12, 24, 36)),
        ScrewMechanics(efficiency if effects.load else 0.0),
        BeamParameters(draws.size(effects.cubic_stiffness)),
    )


def _draw_motor(
    motor: MotorParameters, effects: MachineEffects, draws: Draws, coulomb: float
) -> MotorParameters:
    return replace(
        motor,
        coulomb_friction=coulomb,
        viscous_friction=draws.size(effects.viscous_friction),
        back_emf_constant=motor.back_emf_constant * (1.0 + draws.signed(effects.gain_error)),
        resistance=motor.resistance * (1.0 + draws.signed(effects.resistance_error)),
    )


def _draw_structure(
    structure: StructureParameters, effects: MachineEffects, draws: Draws
) -> StructureParameters:
    return replace(
        structure,
        mass=structure.mass * (1.0 + draws.signed(effects.mechanics_error)),
        stiffness=structure.stiffness * (1.0 + draws.signed(effects.mechanics_error)),
        damping=structure.damping * (1.0 + draws.signed(effects.damping_error)),
    )


def _draw_pushes(effects: MachineEffects, draws: Draws, seed: int) -> PushParameters:
    force, platform = draws.size(effects.push), draws.one_of(2, 3)
    return PushParameters(force, duration=0.05, period=7.0, platform=platform, seed=seed)


def _draw_sensor(
    sensor: SensorParameters, effects: MachineEffects, draws: Draws
) -> SensorParameters:
    return replace(
        sensor,
        delay=draws.size(effects.delay),
        drift=draws.signed(effects.drift),
        periodic_error=draws.size(effects.periodic_error),
        periodic_length=2e-5,
    )


def _draw_actuator(
    actuator: ActuatorParameters, effects: MachineEffects, draws: Draws
) -> ActuatorParameters:
    offset = draws.signed(effects.offset)
    return replace(actuator, offset=offset, resolution=effects.resolution)
