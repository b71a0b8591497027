"""The operators of eqs 13 and 14 on samples made by hand and against their definition in numpy."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bdt_twin.contact import ContactSums, add_contacts, compiled_sums, contact_sums, gap_from_sums


def sums_of(differences, directions, rounding):
    """Return the sums of samples in contact with given angle differences [deg]."""
    theta_m = np.concatenate([[0.0], np.cumsum(directions)])
    theta_d = theta_m - np.deg2rad(np.concatenate([[0.0], differences]))
    return contact_sums(theta_m, theta_d, 1.0, 0.01, rounding, len(differences))[0]


def test_forward_differences_are_rounded_up_to_multiples_of_half_l():
    differences, ahead = [5.0125, 5.0375, 4.9875], [1.0, 1.0, 1.0]
    assert sums_of(differences, ahead, 0.1) == ContactSums(3, 0, 101 + 101 + 100, 0)


def test_backward_differences_are_rounded_down_to_multiples_of_half_l():
    differences, back = [-5.0125, -5.0375, -4.9875], [-1.0, -1.0, -1.0]
    assert sums_of(differences, back, 0.1) == ContactSums(0, 3, 0, -101 - 101 - 100)


def test_rounding_is_away_from_the_screw_so_the_gap_is_never_underestimated():
    sums = sums_of([5.01, -5.01], [1.0, -1.0], 0.1)
    assert math.degrees(gap_from_sums(sums, 0.1)) == pytest.approx(10.1, abs=1e-12)


def test_the_means_of_the_two_directions_weigh_the_same():
    sums = ContactSums(1, 9, 200, -900)
    assert math.degrees(gap_from_sums(sums, 0.1)) == pytest.approx(15.0, abs=1e-12)


@pytest.mark.parametrize(
    "sums", [ContactSums(0, 0, 0, 0), ContactSums(5, 0, 9, 0), ContactSums(0, 5, 0, -9)]
)
def test_one_direction_alone_has_no_gap(sums):
    assert gap_from_sums(sums, 0.1) is None


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(("speed", "count"), [(0.0999, 0), (0.1001, 4)])
def test_a_screw_slower_than_the_threshold_is_not_in_contact(sign, speed, count):
    theta_m = sign * np.arange(5.0)
    [sums] = contact_sums(theta_m, speed * 0.01 * theta_m, 0.01, 0.1, 0.1, 4)
    assert (sums.forward, sums.backward) == ((count, 0) if sign > 0 else (0, count))


@pytest.mark.parametrize("sign", [1, -1])
def test_a_screw_that_turns_against_the_motor_is_not_in_contact(sign):
    """The inverse filter smears a reversal over a few samples, in which this seems to happen."""
    theta_m = sign * np.arange(5.0)
    assert contact_sums(theta_m, -theta_m, 0.01, 0.1, 0.1, 4) == [ContactSums(0, 0, 0, 0)]


def test_a_motor_at_rest_belongs_to_no_direction():
    sums = contact_sums(np.zeros(5), np.arange(5.0), 0.01, 0.1, 0.1, 4)
    assert sums == [ContactSums(0, 0, 0, 0)]


@given(st.integers(1, 6), st.integers(1, 8))
def test_the_sums_of_blocks_add_up_to_the_sums_of_all(count, block):
    random = np.random.default_rng(8)
    theta_m, theta_d = random.normal(size=(2, 1 + count * block)).cumsum(axis=1)
    blocks = contact_sums(theta_m, theta_d, 0.01, 0.1, 0.1, block)
    [everything] = contact_sums(theta_m, theta_d, 0.01, 0.1, 0.1, count * block)
    assert len(blocks) == count
    assert ContactSums(*(sum(column) for column in zip(*blocks, strict=True))) == everything


@given(st.integers(0, 2**32 - 1), st.integers(1, 40), st.floats(1e-3, 5.0))
def test_the_sums_are_those_of_the_sets_of_eq_13(seed, count, rounding):
    random = np.random.default_rng(seed)
    theta_m, theta_d = random.normal(size=(2, 1 + count)).cumsum(axis=1)
    turned, driven = np.diff(theta_m), np.diff(theta_d)
    difference = np.rad2deg(theta_m[1:] - theta_d[1:]) / (0.5 * rounding)
    ahead, back = (driven > 1e-3) & (turned > 0), (driven < -1e-3) & (turned < 0)
    assert contact_sums(theta_m, theta_d, 0.01, 0.1, rounding, count) == [
        ContactSums(
            ahead.sum(),
            back.sum(),
            np.ceil(difference[ahead]).sum(),
            np.floor(difference[back]).sum(),
        )
    ]


def test_the_compiled_sums_are_those_of_plain_python():
    theta_m, theta_d = np.random.default_rng(9).normal(size=(2, 1001)).cumsum(axis=1)
    plain, compiled = np.zeros((2, 4, 10), dtype=np.int64)
    add_contacts(theta_m, theta_d, 0.1, 0.05, 100, plain)
    compiled_sums()(theta_m, theta_d, 0.1, 0.05, 100, compiled)
    assert plain.all()
    assert (plain == compiled).all()


def test_angles_that_cannot_be_written_to_are_read():
    theta_m = np.arange(5.0)
    theta_m.flags.writeable = False
    assert contact_sums(theta_m, theta_m, 0.01, 0.1, 0.1, 4) == [ContactSums(4, 0, 0, 0)]


def test_no_block_has_no_sums():
    assert contact_sums(np.zeros(1), np.zeros(1), 0.01, 0.1, 0.1, 4) == []
