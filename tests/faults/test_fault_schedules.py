"""Loops under schedules of faults: killed and stopped nodes, messages that are lost and garbled."""

import math

import numpy as np
import pytest
from fault_relay import garbled
from fault_schedule import (
    CHANNELS,
    FIRST,
    KINDS,
    LAST,
    NODES,
    Fault,
    line_of,
    schedule_from,
    schedule_of,
    shrunk,
)
from hypothesis import given
from hypothesis import strategies as st
from lockstep_loop import (
    DURATION,
    STEP_TIME,
    LockstepLoop,
    loop_without_faults,
    undisturbed,
    verdict_on,
)

from bdt_msgs_py.message_checks import check_position, check_telemetry_times, check_telemetry_values
from bdt_msgs_py.rejection import MessageRejectedError
from bdt_msgs_py.writing import platform_position
from bdt_study.simulation.closed_loop import simulate

SHORT = ("1.5 loss command 0.5 0.3; 2 hostile twin 0 1; 2.5 kill controller 0 1; 3 kill twin 0 1",)
"""What `make test` runs; `make soak` runs as many seeds as there is time for."""


@pytest.mark.parametrize("line", SHORT)
def test_a_loop_is_back_to_what_it_is_without_faults_ten_seconds_after_the_last_one(
    line, claim_domain
):
    verdict = LockstepLoop(schedule_from(line), claim_domain()).judge()
    replay = f'python tests/faults/soak.py --schedule "{line}"'
    assert verdict.outcome == "recovered", f"{verdict.reason}: {replay}"


LATER_STEPS = [STEP_TIME * number for number in range(1, round(DURATION / STEP_TIME))]


@pytest.mark.parametrize("begin", LATER_STEPS)
def test_a_loop_that_is_as_without_faults_is_back(begin):
    times, positions = undisturbed()
    rows = np.stack([times, 0.0 * times, positions], axis=1)
    assert verdict_on(rows, begin).outcome == "recovered"


@pytest.mark.parametrize("begin", LATER_STEPS)
def test_a_loop_whose_dead_zone_got_lost_is_not_back(begin):
    loop = simulate(loop_without_faults(), ("q3",))
    rows = np.stack([loop.t, 0.0 * loop.t, loop.q3], axis=1)
    assert verdict_on(rows, begin).outcome == "failed"


@given(st.integers(0, 10**9))
def test_a_seed_gives_a_schedule_that_can_be_written_and_read(seed):
    schedule = schedule_of(seed)
    assert schedule == schedule_of(seed)
    assert schedule_from(line_of(schedule)) == schedule
    for fault in schedule:
        assert fault.kind in KINDS
        assert fault.target in (*NODES, *CHANNELS)
        assert FIRST <= fault.time <= LAST


def test_seeds_reach_every_kind_of_fault_and_every_target():
    faults = [fault for seed in range(300) for fault in schedule_of(seed)]
    assert {fault.kind for fault in faults} == set(KINDS)
    assert {fault.target for fault in faults} == {*NODES, *CHANNELS}


@pytest.mark.parametrize(
    "line", ["1 kill", "1 kill moon 0 1", "1 explode twin 0 1", "x kill twin 0 1"]
)
def test_a_line_that_is_no_schedule_is_refused(line):
    with pytest.raises(ValueError, match=r"must be|expected|convert"):
        schedule_from(line)


@given(st.sets(st.integers(0, 9), min_size=1), st.data())
def test_a_failing_schedule_shrinks_to_the_faults_that_make_it_fail(numbers, data):
    culprits = data.draw(st.sets(st.sampled_from(sorted(numbers)), min_size=1))
    schedule = tuple(Fault(float(number), "kill", "twin") for number in sorted(numbers))

    def fails(shorter):
        return culprits <= {int(fault.time) for fault in shorter}

    assert {int(fault.time) for fault in shrunk(schedule, fails)} == culprits


def test_a_garbled_message_is_one_that_nodes_reject():
    with pytest.raises(MessageRejectedError):
        check_position(garbled("measurement", platform_position(0, 1e-3)))
    from std_msgs.msg import Float64MultiArray, MultiArrayDimension, MultiArrayLayout

    dimensions = [MultiArrayDimension(label="", size=2, stride=6)]
    dimensions += [MultiArrayDimension(label="t[s],u[V],q3[m]", size=3, stride=3)]
    layout = MultiArrayLayout(dim=dimensions)
    message = garbled("telemetry", Float64MultiArray(layout=layout, data=[0.0] * 3 + [1.0] * 3))
    assert sum(map(math.isnan, message.data)) == 1
    with pytest.raises(MessageRejectedError):
        check_telemetry_values(check_telemetry_times(message))
