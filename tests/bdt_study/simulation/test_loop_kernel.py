"""The compiled loop is compiled as it is meant to be, whatever happened before."""

import os
import platform
import subprocess
import sys
from threading import Event, Thread

import pytest

pytest.importorskip("numba")

PACKED = """
import os, re
from bdt_study.simulation import loop_kernel
os.environ.update({environment})
loop = loop_kernel.compiled_loop(is_machine=False)
(assembly,) = loop.inspect_asm().values()
print(len(re.findall(r"v?mulpd|vfn?m(?:add|sub)[0-9]+pd", assembly)))
"""
"""Prints how many multiplications of several numbers at once the compiled loop has."""


def packed_multiplications(cache, environment):
    result = subprocess.run(
        [sys.executable, "-c", PACKED.format(environment=environment)],
        env={**os.environ, "NUMBA_CACHE_DIR": str(cache)},
        capture_output=True,
        text=True,
        check=True,
        timeout=120,
    )
    return int(result.stdout)


@pytest.mark.skipif(platform.machine() != "x86_64", reason="names of that processor's instructions")
def test_rows_are_in_vectors_although_the_environment_has_changed(tmp_path):
    """What is compiled once is kept on the disk: as slow as it came out."""
    unchanged = packed_multiplications(tmp_path / "unchanged", {})
    assert unchanged > 10
    assert packed_multiplications(tmp_path / "changed", {"NUMBA_LATER": "1"}) == unchanged


def test_two_threads_that_compile_do_not_take_the_setting_from_each_other():
    from numba import config

    from bdt_study.simulation.loop_kernel import _rows_in_vectors

    inside, leave, left = Event(), Event(), Event()
    seen = []

    def first():
        with _rows_in_vectors():
            inside.set()
            leave.wait(10.0)
        left.set()

    def second():
        with _rows_in_vectors():
            leave.set()
            left.wait(10.0)
            seen.append(config.SLP_VECTORIZE)

    threads = [Thread(target=first), Thread(target=second)]
    threads[0].start()
    assert inside.wait(10.0)
    threads[1].start()
    # The second one cannot come in before the first one is out.
    assert not leave.wait(0.2)
    leave.set()
    for thread in threads:
        thread.join(10.0)
    assert seen == [1]
