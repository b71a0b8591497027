"""Loops compile at once, also where no cache can be written; without numba they just run."""

import hashlib
import os
import subprocess
import sys
from pathlib import Path
from threading import Event, Thread

import numpy as np
import pytest

from bdt_plant import compilation
from bdt_plant.compilation import GIVEN, WRITTEN, _rows_in_vectors, compile_loop
from bdt_plant.motor import MotorState


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


def plus_one(value):
    return value + 1.0


def build(sources):
    def loop(given, written):
        _ = sources
        for n in range(given.size):
            written[n] = plus_one(given[n])

    return loop


def signature():
    given = numba.types.Array(numba.types.float64, 1, "C", readonly=True)
    return given, numba.types.Array(numba.types.float64, 1, "C")


def test_a_loop_is_compiled_with_the_steps_that_it_calls():
    loop = compilation.compile_with_steps(build, [plus_one], signature)
    written = np.empty(3)
    loop(np.arange(3.0), written)
    assert len(loop.signatures) == 1
    assert written.tolist() == [1.0, 2.0, 3.0]


def test_the_loop_holds_a_hash_of_its_steps_and_of_how_it_is_compiled(monkeypatch):
    built = []
    monkeypatch.setattr(compilation, "compile_loop", lambda loop, _: built.append(loop))
    compilation.compile_with_steps(build, [plus_one], signature)
    [held] = built[0].__closure__
    sources = [Path(name).read_bytes() for name in sorted([__file__, compilation.__file__])]
    assert held.cell_contents == hashlib.sha256(b"".join(sources)).hexdigest()


def within_a_tuple(given):
    return (1.0, given)


@pytest.mark.parametrize("given", [MotorState(0.0, 0.0, 0.0), np.zeros(3)])
def test_a_loop_whose_result_python_would_have_to_make_is_refused(given):
    """Ctrl-C in such a loop is heard where numba does not expect it, and may end the process."""
    with pytest.raises(TypeError, match=r"within_a_tuple returns .*: must be numbers and tuples"):
        compile_loop(within_a_tuple, (numba.typeof(given),))


def test_numbers_and_tuples_of_them_come_out_of_a_loop():
    given = (1.0, (True, 2))
    assert compile_loop(within_a_tuple, (numba.typeof(given),))(given) == (1.0, given)


def test_two_threads_that_compile_do_not_take_the_setting_from_each_other():
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
            seen.append(numba.config.SLP_VECTORIZE)

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


def test_without_numba_a_loop_with_steps_runs_as_it_is(monkeypatch):
    monkeypatch.setattr(compilation, "find_spec", lambda _: None)
    written = np.empty(1)
    compilation.compile_with_steps(build, [plus_one], signature)(np.ones(1), written)
    assert written.tolist() == [2.0]


MODEL = """
import sys
from typing import NamedTuple

import numba
import numpy as np

from bdt_plant.compilation import GIVEN, WRITTEN, compile_with_steps


class NAME(NamedTuple):
    factor: float


def scaled(value, step):
    return step.factor * value


def build(sources):
    def loop(step, given, written):
        _ = sources
        for n in range(given.size):
            written[n] = scaled(given[n], step)

    return loop


def signature():
    types = numba.types
    array = types.Array(types.float64, 1, "C")
    return numba.typeof(NAME(1.0)), array, array


written = np.empty(2)
compile_with_steps(build, [scaled], signature)(NAME(3.0), np.array([1.0, 2.0]), written)
print(written.tolist())
"""


def test_a_cache_that_names_a_class_of_an_earlier_version_is_not_opened(tmp_path):
    """Numba unpickles the index of its cache, classes and all, before it looks at its age."""
    program = tmp_path / "model.py"
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    for name in ("FirstName", "SecondName"):
        program.write_text(MODEL.replace("NAME", name))
        done = subprocess.run(
            [sys.executable, "-c", "import model"],
            cwd=tmp_path,
            env=environment,
            check=False,
            capture_output=True,
            text=True,
        )
        assert done.stdout == "[3.0, 6.0]\n", done.stderr
    assert len(list((tmp_path / "cache").rglob("*.nbi"))) == 2
