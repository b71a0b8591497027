"""Settings of the twin node: defaults and refusals."""

import pytest

from bdt_twin.twin_settings import TwinSettings


def test_the_twin_reconfigures_the_controller():
    settings = TwinSettings()
    assert settings.reconfigure is True
    assert settings.controller_node == "controller"


@pytest.mark.parametrize(
    ("fault", "text"),
    [
        ({"reconfigure": 1}, r"reconfigure = 1: must be true or false"),
        ({"reconfigure": "yes"}, r"reconfigure = 'yes': must be true or false"),
        ({"controller_node": 3}, r"controller_node = 3: must be a text"),
        ({"service_timeout": 0.0}, r"service_timeout = 0\.0 s: must be 0\.01 to 10000 s"),
        ({"service_timeout": float("inf")}, r"service_timeout = inf s: must be 0\.01 to 10000 s"),
    ],
)
def test_a_fault_is_named_with_its_value_and_what_is_allowed(fault, text):
    with pytest.raises(ValueError, match=r"^TwinSettings\." + text):
        TwinSettings(**fault)
