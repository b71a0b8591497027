"""What a run starts is decided, and refused, before anything is started."""

from pathlib import Path

import pytest

from bdt_bringup.configuration import load_configuration
from bdt_bringup.run_plan import plan_run
from bdt_msgs_py.command_errors import BadInputError

CONFIG = Path(__file__).parents[2] / "config"


def plan(**changes):
    choices = {
        "mode": None,
        "duration": None,
        "processes": "separate",
        "output": None,
        "recorder": {},
    }
    configuration = load_configuration(changes.pop("config", None))
    return plan_run(configuration, **{**choices, **changes})


def test_duration_and_mode_come_from_the_command_line_then_the_file_then_the_default(tmp_path):
    path = tmp_path / "short.yaml"
    path.write_text("plant: {ros__parameters: {duration: 7.0, mode: realtime}}")
    assert plan(config=path, duration=3.0, mode="lockstep").duration == 3.0
    assert plan(config=path).duration == 7.0
    assert plan(config=path).mode == "realtime"
    assert plan().duration == 120.0
    assert plan().mode == "lockstep"


def test_the_plant_waits_for_twin_and_recorder_and_the_others_use_simulated_time(tmp_path):
    recorded = plan(config=CONFIG / "paper.yaml", output=tmp_path / "run")
    assert 'lockstep_followers:=["twin", "recorder"]' in recorded.ros_arguments("plant")
    assert str(CONFIG / "paper.yaml") in recorded.ros_arguments("twin")
    for node in ("controller", "twin"):
        assert "use_sim_time:=true" in recorded.ros_arguments(node)
    assert 'lockstep_followers:=["twin"]' in plan(recorder=None).ros_arguments("plant")


def test_a_node_of_which_the_file_says_nothing_does_not_get_it(tmp_path):
    path = tmp_path / "short.yaml"
    path.write_text("plant: {ros__parameters: {duration: 7.0}}")
    assert str(path) in plan(config=path).ros_arguments("plant")
    for node in ("controller", "twin", "recorder"):
        assert "--params-file" not in plan(config=path).ros_arguments(node)


def test_the_recorder_is_told_where_and_how_to_write(tmp_path):
    settings = {"storage": "sqlite3", "compression": "zstd", "split_duration": 2.5}
    recorded = plan(output=tmp_path / "run", recorder=settings)
    arguments = recorded.ros_arguments("recorder")
    assert f'bag:="{tmp_path / "run" / "bag"}"' in arguments
    assert 'storage:="sqlite3"' in arguments
    assert 'compression:="zstd"' in arguments
    assert "split_duration:=2.5" in arguments


def test_the_plant_starts_last_because_it_drives_the_others():
    assert plan().nodes == ["controller", "twin", "recorder", "plant"]
    assert plan(recorder=None).nodes == ["controller", "twin", "plant"]


@pytest.mark.parametrize("duration", [0.0, -1.0, float("nan"), float("inf")])
def test_a_duration_that_is_not_positive_and_finite_is_refused(duration):
    with pytest.raises(BadInputError, match=r"--duration .* must be above 0"):
        plan(duration=duration)


def test_a_folder_that_holds_something_is_refused_and_an_empty_one_is_not(tmp_path):
    assert plan(output=tmp_path).output == tmp_path
    (tmp_path / "bag").mkdir()
    with pytest.raises(BadInputError, match="already holds a run"):
        plan(output=tmp_path)
    file = tmp_path / "file"
    file.touch()
    with pytest.raises(BadInputError, match="already holds a run"):
        plan(output=file)


def test_a_real_machine_takes_the_place_of_the_plant_and_lives_in_wall_time(tmp_path):
    recorded = plan(config=CONFIG / "serial_drive.yaml", output=tmp_path / "run")
    assert (recorded.machine, recorded.is_real, recorded.mode) == ("driver", True, "realtime")
    assert recorded.nodes == ["controller", "twin", "recorder", "driver"]
    for node in ("controller", "twin"):
        assert "use_sim_time:=false" in recorded.ros_arguments(node)
    assert recorded.ros_arguments("driver")[-2] == "--params-file"
    assert plan(config=CONFIG / "paper.yaml").nodes[-1] == "plant"


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        ({"mode": "lockstep"}, "--mode lockstep: a real machine does not wait"),
        ({"processes": "single"}, "--processes single: a real machine's driver .* or shared"),
    ],
)
def test_a_real_machine_does_not_wait_and_has_a_process_of_its_own(changes, line):
    with pytest.raises(BadInputError, match=line):
        plan(config=CONFIG / "serial_drive.yaml", **changes)


def test_each_node_has_a_process_unless_the_driver_takes_the_controller_into_its_own():
    machine = CONFIG / "serial_drive.yaml"
    assert plan(config=machine).modules == {
        "controller": "bdt_controller.controller_node",
        "twin": "bdt_twin.twin_node",
        "recorder": "bdt_bags.recorder.recorder_node",
        "driver": "bdt_driver.driver_node",
    }
    shared = plan(config=machine, processes="shared")
    assert shared.nodes == ["controller", "twin", "recorder", "driver"]
    assert list(shared.modules) == ["twin", "recorder", "driver"]
    assert shared.modules["driver"] == "bdt_bringup.controlled_driver"


def test_a_process_for_driver_and_controller_needs_a_driver():
    with pytest.raises(BadInputError, match="--processes shared: there is no driver"):
        plan(config=CONFIG / "paper.yaml", processes="shared")
