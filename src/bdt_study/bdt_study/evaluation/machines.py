"""The cases of machines: effects that the paper leaves out and the twin is not told of."""

from dataclasses import replace

from bdt_study.evaluation.case import Case
from bdt_study.evaluation.machine_effects import MachineEffects

MEASURED = Case("measured", "1 um noise, 0.1 um quantization", noise=1e-6, quantization=1e-7)
"""What the cases of single effects have besides the effect."""

LIMITED = replace(MEASURED, voltage_limit=24.0)
"""The same with an amplifier of 24 V."""

TWELVE_BITS = 48.0 / 2**12
"""Step between two voltages of an amplifier of 12 bits from -24 to 24 V [V]."""

PER_RUN = 1.0 / 120.0
"""Makes a drift [m/s] of what it is over the paper's run of 120 s [m]."""

MACHINES = (
    replace(
        MEASURED,
        name="friction",
        description="up to 40 mN m of Coulomb friction",
        effects=MachineEffects(friction=0.04),
    ),
    replace(
        MEASURED,
        name="stribeck",
        description="up to 20 mN m of friction, up to 1.6 times that at rest",
        effects=MachineEffects(friction=0.02, stribeck=0.6),
    ),
    replace(
        MEASURED,
        name="cogging",
        description="up to 3 mN m of cogging",
        effects=MachineEffects(cogging=3e-3),
    ),
    replace(
        MEASURED,
        name="late_reading",
        description="readings up to 1 ms late",
        effects=MachineEffects(delay=1e-3),
    ),
    replace(
        MEASURED,
        name="stiffening_beams",
        description="up to 2e6 N/m^3 of cubic stiffness",
        effects=MachineEffects(cubic_stiffness=2e6),
    ),
    replace(
        MEASURED,
        name="pushes",
        description="pushes of up to 2 N for 50 ms every 7 s",
        effects=MachineEffects(push=2.0),
    ),
    replace(
        MEASURED,
        name="drift",
        description="a sensor that drifts by up to 20 um in 120 s",
        effects=MachineEffects(drift=20e-6 * PER_RUN),
    ),
    replace(
        MEASURED,
        name="amplifier_offset",
        description="an offset of up to 50 mV, without friction",
        effects=MachineEffects(offset=0.05),
    ),
    replace(
        MEASURED,
        name="late_voltage",
        description="an amplifier that lags by up to 2 ms",
        effects=MachineEffects(lag=2e-3),
    ),
    replace(
        MEASURED,
        name="thread",
        description="a screw whose travel is off by up to 2 um in each turn",
        effects=MachineEffects(thread_error=2e-6),
    ),
    replace(
        LIMITED,
        name="payload",
        description="up to half of the top platform's mass on it",
        decision="simulate",
        effects=MachineEffects(payload=0.5),
    ),
    replace(
        LIMITED,
        name="everyday",
        description="a bit of everything: workshop.yaml, each effect by half or more",
        decision="simulate",
        effects=MachineEffects(
            least=0.5,
            friction=8e-3,
            stribeck=0.25,
            viscous_friction=1e-5,
            cogging=1e-3,
            load=True,
            delay=2e-4,
            drift=5e-6 * PER_RUN,
            periodic_error=2e-7,
            offset=0.02,
            resolution=TWELVE_BITS,
            gain_error=0.04,
            resistance_error=0.08,
            mechanics_error=0.02,
            damping_error=0.1,
        ),
    ),
    replace(
        LIMITED,
        name="unknown_machine",
        description="all effects and all errors of the constants, from nothing to much",
        decision="simulate",
        effects=MachineEffects(
            friction=0.04,
            stribeck=0.6,
            friction_asymmetry=0.2,
            viscous_friction=2e-5,
            cogging=3e-3,
            load=True,
            cubic_stiffness=2e6,
            push=1.0,
            delay=1e-3,
            drift=20e-6 * PER_RUN,
            periodic_error=5e-7,
            offset=0.05,
            resolution=TWELVE_BITS,
            gain_error=0.05,
            resistance_error=0.08,
            mechanics_error=0.02,
            damping_error=0.15,
        ),
    ),
)
"""Machines that nobody described to the twin."""
