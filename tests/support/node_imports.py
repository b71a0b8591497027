"""What nodes import and compile before they run, for the processes that are forked from here."""

from importlib import import_module

from bdt_plant.compiled_period import compiled_hold_period
from bdt_twin.iir_filters import compiled_filters

for node in (
    "bdt_bags.recorder.recorder_node",
    "bdt_controller.controller_node",
    "bdt_driver.driver_node",
    "bdt_plant.plant_node",
    "bdt_twin.twin_node",
):
    import_module(node)
compiled_hold_period()
compiled_filters()
