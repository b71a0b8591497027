"""What a force on the screw is for the motor, against the balance of work."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bdt_plant.screw_load import ScrewMechanics, backward_load, forward_load, screw_load

PITCH, K_T = 1.6e-4, 0.8
forces = st.floats(-1e3, 1e3)


def torques(force, efficiency, *, contact=1, gap=0.0):
    """Return the torques to drive the screw forward and backward [N m]."""
    load = screw_load(ScrewMechanics(efficiency), PITCH, K_T)
    return tuple(K_T * each(force, contact, gap, load) for each in (forward_load, backward_load))


@given(forces, st.floats(0.5, 1.0))
def test_the_work_done_on_a_load_is_the_efficiency_times_that_of_the_motor_and_back(force, eta):
    forward, backward = torques(force, eta)
    against, along = PITCH * abs(force) / eta, -PITCH * abs(force) * eta
    expected = (against, along) if force > 0 else (along, against)
    assert (forward, backward) == pytest.approx(expected, rel=1e-12)


@given(forces, st.floats(0.01, 0.499))
def test_a_thread_below_one_half_is_self_locking(force, eta):
    assert min(torques(force, eta)) == 0.0
    assert max(torques(force, eta)) == pytest.approx(PITCH * abs(force) / eta, rel=1e-12)


@given(forces, st.floats(0.01, 1.0))
def test_a_thread_never_gives_more_than_it_takes(force, eta):
    assert sum(torques(force, eta)) >= -1e-15


@given(st.floats(0.1, 1e3), st.floats(0.01, 1.0))
def test_with_a_gap_the_motor_only_feels_what_it_pushes(force, eta):
    against = PITCH * force / eta
    assert torques(force, eta, contact=1, gap=0.1) == pytest.approx((against, 0.0))
    assert torques(-force, eta, contact=1, gap=0.1) == (0.0, 0.0)
    assert torques(-force, eta, contact=-1, gap=0.1) == pytest.approx((0.0, against))
    assert torques(force, eta, contact=-1, gap=0.1) == (0.0, 0.0)
    assert torques(force, eta, contact=0, gap=0.1) == (0.0, 0.0)


def test_by_default_the_motor_feels_nothing_as_in_the_paper():
    load = screw_load(ScrewMechanics(), PITCH, K_T)
    assert load == (0.0, 0.0)
    assert ScrewMechanics().stiffness == 0.0  # rigid


@pytest.mark.parametrize(
    ("field", "value"), [("efficiency", 1.1), ("efficiency", -0.1), ("stiffness", -1.0)]
)
def test_what_no_screw_does_is_refused(field, value):
    with pytest.raises(ValueError, match=rf"^ScrewMechanics\.{field} = .*: must be"):
        ScrewMechanics(**{field: value})
