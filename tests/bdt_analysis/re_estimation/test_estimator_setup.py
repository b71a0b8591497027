"""Which estimator looks at a recording again: the command line, the bag, the defaults."""

from dataclasses import replace

import numpy as np
import pytest

from bdt_analysis.re_estimation.estimator_setup import (
    estimator_setup,
    given_settings,
    sampling_rate,
)
from bdt_bags.reading.recording import load_recording
from bdt_bringup.cli import run_command
from bdt_msgs_py.command_errors import BadInputError
from bdt_twin.inverse_filter import InverseFilterEstimator
from bdt_twin.output_error import OutputErrorEstimator


@pytest.fixture(scope="module")
def recording(small_loop, tmp_path_factory):
    return load_recording(small_loop.write(tmp_path_factory.mktemp("setup") / "bag"))


def test_nothing_given_is_nothing_to_estimate():
    assert given_settings(None, []) is None


def test_values_have_the_types_of_the_parameters():
    given = given_settings(
        "output_error",
        ["output_error.window = 10.0", "structure.mass=53e-1", "estimator.delay=3"],
    )
    assert given == {
        "estimator.kind": "output_error",
        "output_error.window": 10.0,
        "structure.mass": 5.3,
        "estimator.delay": 3,
    }
    assert given_settings(None, ["estimator.kind=module:name"]) == {"estimator.kind": "module:name"}
    twice = ["estimator.window=3.0", "estimator.window=4.0"]
    assert given_settings(None, twice) == {"estimator.window": 4.0}


@pytest.mark.parametrize(
    ("estimator", "assignment", "message"),
    [
        ("kalman", None, "--estimator = 'kalman': must be one of inverse_filter, output_error or"),
        (None, "estimator.kind=kalman", "--set estimator.kind = 'kalman': must be one of inverse"),
        ("output_error", "estimator.kind=inverse_filter", "must not stand beside --estimator"),
        (None, "estimator.window", "--set 'estimator.window': must be KEY=VALUE"),
        (None, "estimator.windw=1.0", "of the twin; did you mean estimator.window?"),
        (None, "gap.final=1.0", "--set gap.final = '1.0': is not a parameter of the twin"),
        (None, "estimator.window=4", "--set estimator.window = 4: must be written with a decimal"),
        (None, "estimator.window=long", "--set estimator.window = 'long': must be a number, 0.001"),
        (None, "estimator.window=", "--set estimator.window = None: must be a number"),
        (None, "estimator.window={", "--set estimator.window = '{': must be a number"),
        (None, "estimator.window=.nan", "--set estimator.window = nan s: must be 0.001 to 10000 s"),
        (None, "estimator.delay=2.5", "--set estimator.delay = 2.5: must be an integer, 1 to 1000"),
        (None, "structure.mass=-1.0", "--set structure.mass = -1.0 kg: must be "),
    ],
)  # fmt: skip
def test_what_is_not_allowed_is_one_line_and_exit_code_2_before_the_bag_is_read(
    estimator, assignment, message, capsys
):
    options = [] if estimator is None else ["--estimator", estimator]
    options += [] if assignment is None else ["--set", assignment]
    assert run_command(["analyze", "/no/such/bag", *options]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1
    assert message in lines[0]


def test_the_default_is_the_twin_s_at_the_sampling_rate_of_the_recording(recording):
    setup = estimator_setup(recording, {"structure.mass": 5.3})
    assert setup.kind == "inverse_filter"
    assert setup.sampling_rate == 500.0
    assert setup.model.structure.mass == 5.3
    assert setup.model.structure.stiffness == 1e4
    assert isinstance(setup.create().estimator, InverseFilterEstimator)


def test_the_command_line_comes_before_the_bag_and_the_bag_before_the_defaults(recording):
    told = {
        "estimator.kind": "output_error",
        "estimator.sampling_rate": 7.0,
        "output_error.window": 12.0,
        "output_error.knot_spacing": 2.0,
        "output_error.update_period": 1.0,
        "motor.resistance": 1.5,
        "communication_delay": 3.0,
        "use_sim_time": True,
    }
    setup = estimator_setup(replace(recording, twin_parameters=told), {"output_error.window": 15.0})
    assert isinstance(setup.create().estimator, OutputErrorEstimator)
    assert (setup.output_error.window, setup.output_error.knot_spacing) == (15.0, 2.0)
    assert setup.model.motor.resistance == 1.5
    assert setup.sampling_rate == 500.0
    assert setup.recorded == {
        "estimator.kind": "output_error",
        "output_error.knot_spacing": 2.0,
        "motor.resistance": 1.5,
    }


def test_the_twin_s_parameters_are_read_from_the_bag(small_loop, tmp_path):
    messages = small_loop.without()
    messages.parameter(0.0, "/twin", "structure.mass", 5.5, initial=True)
    messages.parameter(0.5, "/twin", "structure.mass", 5.6)
    messages.parameter(0.0, "/plant", "structure.mass", 9.9, initial=True)
    messages.parameter(0.0, "/other/twin", "structure.mass", 9.9, initial=True)
    recording = load_recording(messages.write(tmp_path / "bag"))
    assert estimator_setup(recording, {"motor.inertia": 1e-4}).model.structure.mass == 5.6


def test_the_twin_of_the_loop_s_own_namespace_counts(loop_messages, tmp_path):
    messages = loop_messages(duration=0.6, sampling_rate=500.0, control_rate=50.0, namespace="/a")
    messages.parameter(0.0, "/a/twin", "structure.mass", 5.5, initial=True)
    messages.parameter(0.0, "/twin", "structure.mass", 9.9, initial=True)
    recording = load_recording(messages.write(tmp_path / "bag"))
    assert recording.twin_parameters == {"structure.mass": 5.5}


def test_a_bag_with_a_value_that_is_not_allowed_is_named(recording):
    odd = replace(recording, twin_parameters={"motor.resistance": -1.0})
    with pytest.raises(
        BadInputError, match=r"^bag .*: parameter motor.resistance of the twin = -1"
    ):
        estimator_setup(odd, {"structure.mass": 5.3})
    assert estimator_setup(odd, {"motor.resistance": 1.0}).model.motor.resistance == 1.0


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"estimator.window": 2.05}, r"estimator.window = 2.05 s: must be a multiple of update_p"),
        ({"output_error.knot_spacing": 30.0}, r"output_error.knot_spacing = 30.0 s: must be at mo"),
        (
            {"estimator.kind": "output_error", "output_error.update_period": 0.0015},
            r"output_error.update_period = 0.0015 s: must be a whole number of samples at 500 Hz",
        ),
        ({"estimator.kind": "no_such_module:name"}, "estimator.kind = 'no_such_module:name': No m"),
    ],
)
def test_values_that_do_not_go_together_are_named_as_ros_names_them(recording, given, message):
    with pytest.raises(BadInputError, match=f"^re-estimation: {message}"):
        estimator_setup(recording, given).create()


@pytest.mark.parametrize(
    ("kind", "names"),
    [
        ("inverse_filter", ("output_error.window", "dead_zone.coverage_factor")),
        ("output_error", ("estimator.window", "dead_zone.coverage_factor")),
        (
            "module:name",
            ("estimator.window", "output_error.window", "dead_zone.coverage_factor"),
        ),
    ],
)
def test_settings_without_effect_are_told(recording, kind, names):
    given = {
        "estimator.kind": kind,
        "estimator.sampling_rate": 500.0,
        "estimator.window": 4.0,
        "output_error.window": 10.0,
        "lead_screw.pitch": 1e-4,
        "dead_zone.coverage_factor": 2.0,
    }
    assert estimator_setup(recording, given).without_effect == names


@pytest.mark.parametrize("rate", [5000.0, 1000.0 / 3.0])
def test_the_sampling_rate_is_that_of_the_samples_without_holes(recording, rate):
    time = np.delete(np.arange(6000) / rate, slice(100, 4000, 7))
    rows = np.column_stack([time, np.zeros((len(time), 2))])
    assert sampling_rate(replace(recording, telemetry=rows)) == pytest.approx(rate, rel=1e-12)


def test_the_sampling_rate_of_samples_that_come_in_bunches_is_that_of_the_bunches(recording):
    numbers = np.arange(6000)
    time = numbers // 5 * 1e-3 + numbers % 5 * 1e-6
    rows = np.column_stack([time, np.zeros((len(time), 2))])
    assert sampling_rate(replace(recording, telemetry=rows)) == pytest.approx(5000.0, rel=1e-3)


def test_a_clock_that_is_off_a_little_does_not_make_a_period_a_part_of_a_sample(recording):
    rows = np.column_stack([np.arange(6000) / 4996.3, np.zeros((6000, 2))])
    setup = estimator_setup(replace(recording, telemetry=rows), {"estimator.kind": "output_error"})
    assert setup.sampling_rate == 5000.0
    setup.create()


def test_a_clock_that_counts_from_1970_does_not_blur_the_sampling_rate(recording):
    time = (1.7e9 + np.arange(20_000) / 5000.0) - 1.7e9
    assert 1.0 / np.median(np.diff(time)) != pytest.approx(5000.0, rel=1e-4), "stamps are coarse"
    rows = np.column_stack([time, np.zeros((len(time), 2))])
    assert sampling_rate(replace(recording, telemetry=rows)) == 5000.0
