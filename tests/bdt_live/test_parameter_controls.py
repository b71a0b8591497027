"""Controls from what nodes say of their parameters."""

import math

from hypothesis import given
from hypothesis import strategies as st

from bdt_live.parameter_controls import Description, control_of, slider_range

GAIN = Description("pid.proportional", "gain K_p [V/m]", "-1e+09 to 1e+09 V/m", False, -1e9, 1e9)


def test_a_number_is_a_slider_with_unit_and_text_of_its_description():
    control = control_of(GAIN, 3080.0)
    assert control["kind"] == "slider"
    assert (control["text"], control["unit"]) == ("gain K_p", "V/m")
    assert control["allowed"] == "-1e+09 to 1e+09 V/m"


def test_a_range_too_wide_to_drag_in_is_one_around_the_value():
    assert slider_range(GAIN, 3080.0) == (0.0, 6160.0)
    assert slider_range(GAIN, -308.4) == (-616.8, 0.0)


def test_a_useful_range_is_the_node_s_own():
    assert slider_range(Description("share", minimum=0.0, maximum=1.0), 0.25) == (0.0, 1.0)


numbers = st.floats(-1e12, 1e12)


@given(value=numbers, low=st.none() | numbers, high=st.none() | numbers)
def test_a_slider_has_the_value_in_it_and_asks_for_nothing_that_the_node_does_not_take(
    value, low, high
):
    least = -math.inf if low is None else min(low, value)
    most = math.inf if high is None else max(high, value)
    described = Description(
        "x", minimum=None if low is None else least, maximum=None if high is None else most
    )
    begin, end = slider_range(described, value)
    assert least <= begin <= value <= end <= most


def test_switches_choices_and_texts():
    assert control_of(Description("reconfigure"), True)["kind"] == "switch"
    choice = control_of(Description("gap.kind", constraints="one of constant, ramp"), "ramp")
    assert (choice["kind"], choice["choices"]) == ("choice", ["constant", "ramp"])
    assert control_of(Description("name"), "x")["kind"] == "text"


def test_what_is_read_only_a_list_or_of_ros_itself_is_not_offered():
    assert control_of(Description("mass", read_only=True), 5.2)["kind"] == "fixed"
    assert control_of(Description("use_sim_time"), True)["kind"] == "fixed"
    assert control_of(Description("table"), (1.0, 2.0)) == {
        "name": "table",
        "value": [1.0, 2.0],
        "unit": "",
        "text": "",
        "allowed": "",
        "kind": "fixed",
    }
