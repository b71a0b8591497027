"""Where the reader of a tutorial types."""

import os
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
CHECKOUT = ("Makefile", "config", "embedded_ros", "requirements.lock", "src")


@pytest.fixture
def folder(tmp_path):
    """Return a folder that looks like a checkout whose environment is set up."""
    for name in CHECKOUT:
        (tmp_path / name).symlink_to(ROOT / name)
    (tmp_path / ".venv").symlink_to(sys.prefix)
    return tmp_path


@pytest.fixture
def environment(folder, claim_domain):
    """Return the environment of a terminal of 90 columns in which .venv is active."""
    inherited = {name: text for name, text in os.environ.items() if not name.startswith("MAKE")}
    return inherited | {
        "COLUMNS": "90",
        "PATH": f"{folder / '.venv' / 'bin'}:{os.environ['PATH']}",
        "PYTHONUNBUFFERED": "1",
        "ROS_DOMAIN_ID": str(claim_domain()),
    }
