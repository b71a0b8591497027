"""Stribeck friction against its formula; its motion is in test_machine.py."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bdt_plant.motor import MotorParameters
from bdt_plant.stribeck import StribeckParameters, friction_law, friction_size

K_T = 0.8
MOTOR = MotorParameters(coulomb_friction=0.01)


@given(
    st.floats(-100, 100).filter(bool), st.floats(0.01, 0.1), st.floats(0.1, 10.0), st.floats(-1, 1)
)
def test_the_torque_is_that_of_the_formula(speed, static, stribeck_speed, asymmetry):
    law = friction_law(MOTOR, StribeckParameters(static, stribeck_speed, asymmetry))
    factor = law.forward if speed > 0 else law.backward
    expected = 0.01 + (static - 0.01) * math.exp(-((speed / stribeck_speed) ** 2))
    expected *= 1 + asymmetry * math.copysign(1, speed)
    assert K_T * factor * friction_size(speed, law) == pytest.approx(expected, rel=1e-12)


@given(st.floats(0.0, 0.01), st.floats(-10, 10))
def test_a_static_friction_below_coulomb_s_counts_as_coulomb_s(static, speed):
    law = friction_law(MOTOR, StribeckParameters(static))
    assert friction_size(speed, law) == 0.01 / K_T


def test_by_default_it_is_coulomb_s_friction_alone():
    law = friction_law(MOTOR, StribeckParameters())
    assert (law.excess, law.forward, law.backward) == (0.0, 1.0, 1.0)


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("static_friction", -1e-3),
        ("stribeck_speed", 0.0),
        ("friction_asymmetry", 1.1),
        ("friction_asymmetry", np.nan),
    ],
)
def test_what_no_friction_does_is_refused(field, value):
    with pytest.raises(ValueError, match=rf"^StribeckParameters\.{field} = .*: must be"):
        StribeckParameters(**{field: value})
