"""Settings of the twin node: defaults and refusals."""

import pytest

from bdt_twin.twin_settings import TwinSettings


def test_the_twin_reconfigures_the_controller_after_the_paper_s_second():
    settings = TwinSettings()
    assert settings.reconfigure is True
    assert settings.communication_delay == 1.0
    assert settings.controller_node == "controller"


@pytest.mark.parametrize(
    ("fault", "text"),
    [
        ({"reconfigure": 1}, r"reconfigure = 1: must be true or false"),
        ({"reconfigure": "yes"}, r"reconfigure = 'yes': must be true or false"),
        ({"communication_delay": -0.1}, r"communication_delay = -0\.1 s: must be 0 to 10000 s"),
        ({"communication_delay": float("nan")}, r"communication_delay = nan s: must be 0 to"),
        ({"controller_node": 3}, r"controller_node = 3: must be a text"),
        ({"service_timeout": 0.0}, r"service_timeout = 0\.0 s: must be 0\.01 to 10000 s"),
        ({"service_timeout": float("inf")}, r"service_timeout = inf s: must be 0\.01 to 10000 s"),
    ],
)
def test_a_fault_is_named_with_its_value_and_what_is_allowed(fault, text):
    with pytest.raises(ValueError, match=r"^TwinSettings\." + text):
        TwinSettings(**fault)
