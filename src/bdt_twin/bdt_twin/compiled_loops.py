"""Everything compiled that the fit of a window calls."""

from bdt_plant.quick_exponential import compiled_powers
from bdt_twin import (
    applied_voltage,
    fixed_order,
    innovation_filter,
    robust_sums,
    structure_responses,
)
from bdt_twin.cogging_waves import compiled_waves
from bdt_twin.window_loop import compiled_window

LOOPS = (
    compiled_window,
    compiled_waves,
    compiled_powers,
    *applied_voltage.COMPILED,
    *fixed_order.COMPILED,
    *innovation_filter.COMPILED,
    *robust_sums.COMPILED,
    *structure_responses.COMPILED,
)
"""What to call before the first data wait."""
