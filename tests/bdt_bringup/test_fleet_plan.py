"""Which twins a fleet has, with which arguments, and which process has which."""

import pytest

from bdt_bringup.fleet_plan import FleetTwin, plan_fleet, shared_out
from bdt_msgs_py.command_errors import BadInputError

TWINS = [FleetTwin(f"/m{number}", ()) for number in range(5)]


@pytest.fixture
def own(tmp_path):
    """Return a configuration whose twin keeps its state in one file."""
    path = tmp_path / "own.yaml"
    path.write_text("/**/twin:\n  ros__parameters:\n    state_file: kept.json\n")
    return path


def test_each_twin_is_in_the_namespace_of_its_machine_with_its_clock():
    left, right = plan_fleet(["left", "hall/right"])
    assert (left.name, right.name) == ("/left/twin", "/hall/right/twin")
    assert left.arguments == ("-r", "__ns:=/left", "-r", "/clock:=clock")


def test_a_machine_may_have_a_configuration_of_its_own(own):
    left, right = plan_fleet(["left", f"right={own}"], config="paper")
    assert left.arguments[-1].endswith("paper.yaml")
    assert right.arguments[-1] == str(own)


def test_each_twin_has_a_state_file_of_its_own(tmp_path):
    twins = plan_fleet(["a/b", "a", "b"], states=tmp_path)
    assert [twin.arguments[-1] for twin in twins] == [
        f'state_file:="{tmp_path / name}"'
        for name in ("a.b.twin.json", "a.twin.json", "b.twin.json")
    ]


def test_simulated_machines_have_a_clock():
    (twin,) = plan_fleet(["left"], use_sim_time=True)
    assert twin.arguments[-2:] == ("-p", "use_sim_time:=true")


@pytest.mark.parametrize(
    ("machines", "message"),
    [
        (["left", "/left/"], "machine /left: comes 2 times, each twin needs its own"),
        (["3d"], "--namespace 3d: must consist of letters"),
        (["left=nowhere.yaml"], "nowhere.yaml"),
    ],
)
def test_what_cannot_be_a_fleet_is_refused(machines, message):
    with pytest.raises(BadInputError, match=message):
        plan_fleet(machines)


def test_twins_do_not_share_a_state_file(own, tmp_path):
    with pytest.raises(BadInputError, match=r"state_file kept.json: comes 2 times"):
        plan_fleet(["left", "right"], config=str(own))
    assert len(plan_fleet(["left", "right"], config=str(own), states=tmp_path)) == 2


@pytest.mark.parametrize(("workers", "sizes"), [(1, [5]), (2, [3, 2]), (5, [1] * 5), (9, [1] * 5)])
def test_twins_are_shared_out_evenly(workers, sizes):
    shares = shared_out(TWINS, workers)
    assert [len(share) for share in shares] == sizes
    assert sorted(twin.name for share in shares for twin in share) == [one.name for one in TWINS]


@pytest.mark.parametrize("workers", [0, 1025])
def test_a_fleet_has_some_processes(workers):
    with pytest.raises(BadInputError, match=f"--workers {workers}: must be 1 to 1024"):
        shared_out(TWINS, workers)
