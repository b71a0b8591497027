"""Gains that ``bdt tune`` recommends for the mechanism of table 1 within the ranges of ``harsh``.

A test of the design says whether they still are what comes out.
"""

from bdt_controller.notch import NO_NOTCH
from bdt_controller.pid import PidGains
from bdt_twin.decision import ControllerGains

INTEGRAL_TIME = 0.5
"""T_i = K_p / K_i for which they were designed [s]."""

TUNED_GAINS = ControllerGains(PidGains(6284.7, 12569.0, -868.39, 0.11636), NO_NOTCH)
"""Largest sensitivity 3.6 over these ranges, where the default gains have 5.1."""
