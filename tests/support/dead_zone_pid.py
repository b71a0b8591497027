"""The dead-zone PID of eqs 5, 7 and 8 alone: the controller's law without all that is optional."""

from bdt_controller.control_law import INITIAL_CONTROL, ControlLaw, unlimited_step
from bdt_controller.notch import NO_NOTCH, discretize_notch


def dead_zone_pid_step(state, error, tolerance, step):
    """Return state and voltage of a PID, from `discretize_pid`, after a control period."""
    law = ControlLaw(step, discretize_notch(NO_NOTCH, step.period), 0.0)
    before = INITIAL_CONTROL._replace(pid=state)
    following, _, voltage = unlimited_step(before, error, tolerance, law, 0.0)
    return following, voltage
