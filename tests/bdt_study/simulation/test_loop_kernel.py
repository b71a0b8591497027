"""The compiled loop is compiled as it is meant to be, whatever happened before."""

import os
import platform
import subprocess
import sys

import pytest
from interrupted_calls import end_of_interrupted

pytest.importorskip("numba")

PACKED = """
import os, re
from bdt_study.simulation import loop_kernel
{before}
loop = loop_kernel.compiled_loop(is_machine=False)
(assembly,) = loop.inspect_asm().values()
print(len(re.findall(r"v?mulpd|vfn?m(?:add|sub)[0-9]+pd", assembly)))
"""
"""Prints how many multiplications of several numbers at once the compiled loop has."""


def packed_multiplications(cache, before=""):
    result = subprocess.run(
        [sys.executable, "-c", PACKED.format(before=before)],
        env={**os.environ, "NUMBA_CACHE_DIR": str(cache)},
        capture_output=True,
        text=True,
        check=True,
        timeout=120,
    )
    return int(result.stdout)


MUCH_BEFORE = """
from bdt_plant.compiled_period import compiled_hold_period
compiled_hold_period()
os.environ["NUMBA_LATER"] = "1"
"""
"""A loop that shares steps with the kernel, and a change of numba's environment."""


@pytest.mark.skipif(platform.machine() != "x86_64", reason="names of that processor's instructions")
def test_rows_are_in_vectors_whatever_was_before(tmp_path):
    """What is compiled once is kept on the disk: as slow as it came out."""
    alone = packed_multiplications(tmp_path / "alone")
    assert alone > 10
    assert packed_multiplications(tmp_path / "after", MUCH_BEFORE) == alone


SCENARIO = """
from bdt_plant.cogging import CoggingParameters
from bdt_plant.plant import PlantModel
from bdt_study.simulation.closed_loop import Scenario, simulate
scenario = Scenario(duration=0.02, model=PlantModel({effect}))
"""


@pytest.mark.parametrize("effect", ["", "cogging=CoggingParameters(3e-3)"])
def test_ctrl_c_in_a_simulation_is_an_exception_as_anywhere(effect):
    assert end_of_interrupted(SCENARIO.format(effect=effect), "simulate(scenario)") == (0, "")
