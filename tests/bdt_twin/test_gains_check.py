"""A twin that simulates looks whether the controller is the one that it simulates."""

import pytest
from telemetry_operator import Operator

from bdt_controller.controller_node import ControllerNode
from bdt_msgs_py.diagnostics import PERIOD
from bdt_twin.twin_node import TwinNode

SIMULATES = {"decision__kind": "simulate", "communication_delay": 0.0}


@pytest.fixture
def loop(ros):
    operator = Operator(ros)
    operator.start = lambda **parameters: setattr(
        operator, "twin", ros.create(TwinNode, **parameters)
    )
    return operator


def has_asked(loop):
    return loop.twin._gains_check._is_answered


def test_a_controller_with_other_gains_is_a_warning_that_names_them(ros, loop):
    ros.create(ControllerNode, pid__integral=20000.0)
    loop.start(**SIMULATES)
    ros.spin_until(lambda: not loop.twin._health().ok)
    own = loop.twin.get_parameter("pid.integral").value
    assert loop.twin._health().summary == (
        f"the controller has pid.integral = 20000, the twin {own:g}: "
        "what it decides is for another controller"
    )


def test_the_same_gains_are_none(ros, loop):
    ros.create(ControllerNode, pid__integral=20000.0)
    loop.start(**SIMULATES, pid__integral=20000.0)
    ros.spin_until(lambda: has_asked(loop))
    assert loop.twin._health().ok


def test_gains_that_a_twin_before_may_have_set_are_none(ros, loop):
    ros.create(ControllerNode, pid__integral=20000.0)
    redesign = {"decision__reconfigure_gains": True, "redesign__integral": 20000.0}
    loop.start(**SIMULATES, **redesign)
    ros.spin_until(lambda: has_asked(loop))
    assert loop.twin._health().ok


def test_equation_9_needs_no_gains(ros, loop):
    ros.create(ControllerNode, pid__integral=20000.0)
    loop.start()
    ros.spin_for(2.5 * PERIOD)
    assert loop.twin._health().ok
