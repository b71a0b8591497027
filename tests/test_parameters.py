"""The parameter tables of all nodes, each in its package's `parameters.py`."""

from dataclasses import fields

import pytest

from bdt_bringup.installed import PACKAGE_OF_NODE, parameter_table
from bdt_msgs_py.parameter_tables import known_parameters
from bdt_msgs_py.quantities import quantities_of

TABLES = {node: parameter_table(node) for node in PACKAGE_OF_NODE}

with_each_dataclass = pytest.mark.parametrize(
    "declared",
    sorted(
        {kind for table in TABLES.values() for _, kind in table}, key=lambda kind: kind.__name__
    ),
    ids=lambda declared: declared.__name__,
)


@pytest.mark.parametrize("node", TABLES)
def test_no_two_parameters_of_a_node_share_a_name(node):
    names = [(prefix, name) for prefix, kind in TABLES[node] for name, _, _ in quantities_of(kind)]
    assert len(set(names)) == len(names)
    prefixes = {prefix for prefix, _ in names if prefix}
    assert not prefixes & {name for prefix, name in names if not prefix}


@with_each_dataclass
def test_every_field_is_a_described_quantity(declared):
    described = {name: quantity for name, _, quantity in quantities_of(declared)}
    assert list(described) == [field.name for field in fields(declared)]
    assert all(quantity.description for quantity in described.values())


@with_each_dataclass
def test_the_defaults_are_allowed(declared):
    assert declared() == declared()


@with_each_dataclass
def test_every_number_has_both_bounds(declared):
    """A descriptor range of ROS and a message that says what is allowed both need them."""
    for name, default, quantity in quantities_of(declared):
        first = default[0] if isinstance(default, tuple) else default
        if isinstance(first, (int, float)) and not isinstance(first, bool):
            assert quantity.minimum is not None, name
            assert quantity.maximum is not None, name


def reconfigurable(node):
    known = known_parameters(TABLES[node])
    return {name for name, (_, quantity) in known.items() if quantity.reconfigurable}


def test_what_tunes_the_running_loop_can_be_reconfigured():
    assert reconfigurable("controller") == {
        "dead_zone_tolerance",
        "voltage_offset",
        "reference.first",
        "reference.second",
        "reference.step_time",
        "pid.proportional",
        "pid.integral",
        "pid.derivative",
        "pid.filter_time",
        "notch.frequency",
        "notch.zero_damping",
        "notch.pole_damping",
    }


def test_what_the_twin_knows_of_plant_and_controller_stays_while_it_runs():
    assert reconfigurable("twin") == {"reconfigure", "compensate_offset", "communication_delay"}
