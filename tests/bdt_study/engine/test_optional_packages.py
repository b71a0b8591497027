"""What needs a package that is missing or does not work says so in one line, before any work."""

import sys

import pytest

from bdt_bringup.cli import run_command
from bdt_msgs_py.command_errors import BAD_INPUT, BadInputError
from bdt_study.engine.optional_packages import check_imports


@pytest.mark.parametrize(
    ("command", "module", "what"),
    [
        ("sweep gap_delay --dry-run", "pyarrow.dataset", "bdt sweep"),
        ("sweep report somewhere", "SALib.analyze", "bdt sweep report"),
        ("sweep gap_delay --scheduler x", "distributed", "--scheduler"),
        ("evaluate --output kept", "pyarrow.parquet", "--output"),
        ("evaluate --scheduler x", "distributed", "--scheduler"),
    ],
)
def test_a_missing_package_is_one_line(command, module, what, monkeypatch, tmp_path, capsys):
    if command.startswith("sweep"):
        pytest.importorskip("pyarrow")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(sys.modules, module, None)
    assert run_command(command.split()) == BAD_INPUT
    told = capsys.readouterr().err
    package = module.split(".")[0]
    assert told.startswith(f"error: {what}: needs the Python package {package}: ")
    assert told.count("\n") == 1
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("fault", ["ImportError('wants a newer numpy')", "AttributeError('_API')"])
def test_a_package_that_does_not_work_is_told_with_its_reason(tmp_path, monkeypatch, fault):
    (tmp_path / "too_new.py").write_text(f"raise {fault}")
    monkeypatch.syspath_prepend(tmp_path)
    reason = fault.split("'")[1]
    with pytest.raises(BadInputError, match=f"^--it: needs the Python package too_new: {reason}$"):
        check_imports("--it", ("too_new",))
