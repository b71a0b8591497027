"""Loops compile at once, also where no cache can be written; without numba they just run."""

import numpy as np
import pytest

from bdt_twin import compilation
from bdt_twin.compilation import GIVEN, WRITTEN, compile_loop


def double(given, written):
    for n in range(given.size):
        written[n] = 2.0 * given[n]


numba = pytest.importorskip("numba")


def test_a_loop_is_compiled_before_its_first_call(tmp_path, monkeypatch):
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path))
    loop = compile_loop(double, f"void({GIVEN}, {WRITTEN})")
    assert len(loop.signatures) == 1
    assert list(tmp_path.rglob("*.nbi"))
    given, written = np.arange(3.0), np.empty(3)
    given.flags.writeable = False
    loop(given, written)
    assert written.tolist() == [0.0, 2.0, 4.0]


def test_without_a_folder_for_the_cache_a_loop_is_compiled_all_the_same(monkeypatch):
    njit = numba.njit

    def refuse(signatures, **options):
        if options.get("cache"):
            # What numba says of a function in a folder that is not to be written.
            raise RuntimeError("cannot cache function 'double': no locator available")
        return njit(signatures, **options)

    monkeypatch.setattr(numba, "njit", refuse)
    written = np.empty(1)
    compile_loop(double, f"void({GIVEN}, {WRITTEN})")(np.ones(1), written)
    assert written.tolist() == [2.0]


def test_without_numba_the_loop_runs_as_it_is(monkeypatch):
    monkeypatch.setattr(compilation, "find_spec", lambda _: None)
    assert compile_loop(double, f"void({GIVEN}, {WRITTEN})") is double
