"""Settings of a driver that cannot work are refused with what is allowed."""

import pytest

from bdt_driver.driver_settings import DriveLimits, DriverSettings


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"driver": "my_module"}, "driver = 'my_module': must be module:name"),
        ({"engage_time": 0.1}, r"engage_time = 0.1 s: must be at least 100 control periods"),
        ({"sampling_rate": -1.0}, r"sampling_rate = -1.0 Hz: must be 0 to 1e\+06 Hz"),
    ],
)
def test_settings(values, message):
    with pytest.raises(ValueError, match=message):
        DriverSettings(**values)


def test_travel():
    with pytest.raises(ValueError, match=r"highest_position = -0\.1 m: must be above"):
        DriveLimits(highest_position=-0.1)


def test_a_position_that_is_no_number_is_nowhere_allowed():
    assert DriveLimits().allow(0.05)
    assert not DriveLimits().allow(0.0501)
    assert not DriveLimits().allow(float("nan"))
