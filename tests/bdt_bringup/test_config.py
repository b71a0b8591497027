"""``bdt config``: the configurations that come with the package, for everything else of ROS."""

import subprocess
import sys
from pathlib import Path

import pytest
from shipped_configurations import SHIPPED

from bdt_bringup.cli import run_command
from bdt_msgs_py.configuration_files import packaged_configurations

ROOT = Path(__file__).parents[2]


def test_without_a_name_the_configurations_are_listed_with_what_they_are(capsys):
    assert run_command(["config"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == list(packaged_configurations())
    assert lines[list(packaged_configurations()).index("paper")] == (
        "paper            Figure 7 of the paper: the twin estimates the growing gap and "
        "reconfigures the dead zone."
    )


@pytest.mark.parametrize("name", SHIPPED)
def test_the_path_of_a_configuration_is_printed_from_any_folder(
    name, capsys, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    assert run_command(["config", name]) == 0
    path = Path(capsys.readouterr().out.strip())
    assert path.is_absolute()
    assert path.read_bytes() == (ROOT / "config" / f"{name}.yaml").read_bytes()


def test_a_name_that_is_none_is_one_line(capsys):
    assert run_command(["config", "papper"]) == 2
    error = capsys.readouterr().err
    assert error.startswith("error: configuration 'papper': must be one of fixed_dead_zone, ")
    assert error.endswith("; did you mean paper?\n")


def test_a_build_installs_the_configurations_into_the_share_folder(tmp_path):
    """Where ``$(ros2 pkg prefix --share bdt_bringup)/config/paper.yaml`` finds them."""
    subprocess.run(
        [sys.executable, "setup.py", "-q", "install_data", "--install-dir", tmp_path],
        cwd=ROOT / "src" / "bdt_bringup",
        check=True,
        capture_output=True,
    )
    installed = tmp_path / "share" / "bdt_bringup" / "config"
    assert {path.name for path in installed.iterdir()} == {
        path.name for path in packaged_configurations().values()
    }
