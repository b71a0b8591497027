"""The benchmarks on tiny cases: they run, compare the same things and say what they skip."""

import json
import math

import numpy as np
import pytest

from bdt_bringup.cli import run_command
from bdt_controller.pid import PidGains
from bdt_controller.reference import ReferenceProfile
from bdt_plant.gap_profile import GapProfile
from bdt_plant.plant import PlantModel, Sampling
from bdt_study.benchmarks import bench
from bdt_study.benchmarks.bench import BENCHMARKS, run_benchmarks
from bdt_study.benchmarks.c_loop import KEPT, NoCompilerError, build_c_loop, c_loop_call
from bdt_study.benchmarks.python_control_loop import interconnected_loop, step_response
from bdt_study.benchmarks.result import BenchmarkResult, BenchmarkSize, missed_targets
from bdt_study.simulation.closed_loop import Scenario, discrete_loop, sample_inputs, simulate
from bdt_study.simulation.loop_model import loop_at_rest

TINY = BenchmarkSize(
    duration=0.5, python_control_duration=0.02, repeats=2, batch=1, messages=100, loop_duration=1.0
)
FIELDS = {"name", "value", "unit", "reference", "reference_value", "ratio", "target"}


WITH_PROCESSES = (
    "bdt_study.benchmarks.transport",
    "bdt_study.benchmarks.program",
    "bdt_study.benchmarks.real_time",
    "bdt_study.benchmarks.sweep",
    "bdt_study.benchmarks.twins",
)
OFFLINE = [x for x, function in BENCHMARKS.items() if function.__module__ not in WITH_PROCESSES]


@pytest.mark.parametrize("name", OFFLINE)
def test_each_benchmark_gives_finite_numbers_as_json(name):
    report = json.loads(json.dumps(run_benchmarks([name], TINY), allow_nan=False))
    assert report["machine"]["cores"] >= 1
    assert report["results"]
    for result in report["results"]:
        assert set(result) == FIELDS
        assert result["name"] == name
        assert result["value"] > 0
        if result["reference_value"] is not None:
            assert result["ratio"] == pytest.approx(result["value"] / result["reference_value"])


def test_an_unknown_name_is_refused():
    with pytest.raises(ValueError, match="benchmark 'speed': must be one of kernel_vs_c"):
        run_benchmarks(["speed"], TINY)


def test_without_a_compiler_c_is_skipped_with_a_word(monkeypatch, tmp_path):
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path))
    (result,) = bench.kernel_vs_c(TINY)
    assert result.reference == "C skipped: no C compiler"
    assert result.reference_value is result.ratio is None
    assert result.value > 0


def test_a_compiler_that_fails_is_quoted(tmp_path):
    source = tmp_path / "broken.c"
    source.write_text("this is not C")
    with pytest.raises(NoCompilerError, match=r"failed|no C compiler"):
        build_c_loop(source)


def test_loading_the_c_loop_leaves_the_arithmetic_of_this_process_alone():
    try:
        build_c_loop()
    except NoCompilerError as error:
        pytest.skip(str(error))
    smallest_normal = float(np.finfo(float).tiny)
    assert smallest_normal / 2 > 0


@pytest.mark.parametrize("dead_zone", [0.0, 2.8e-5])
@pytest.mark.parametrize("gap", [GapProfile("constant"), GapProfile(growth_time=8.0)])
def test_the_c_loop_computes_the_same_loop(gap, dead_zone):
    try:
        library = build_c_loop()
    except NoCompilerError as error:
        pytest.skip(str(error))
    scenario = Scenario(6.0, ReferenceProfile(step_time=2.0), gap, dead_zone)
    inputs = sample_inputs(scenario)
    written = tuple(np.empty(scenario.samples) for _ in KEPT)
    start = loop_at_rest(float(inputs.gaps[0]))
    c_loop_call(library, start, discrete_loop(scenario), inputs, written)()
    trajectory = simulate(scenario)
    # -ffast-math rounds otherwise.
    for name, signal in zip(KEPT, written, strict=True):
        scale = np.abs(getattr(trajectory, name)).max()
        np.testing.assert_allclose(signal, getattr(trajectory, name), rtol=0, atol=1e-8 * scale)


def test_python_control_computes_the_same_loop():
    gap = math.radians(1.0)
    loop = interconnected_loop(PlantModel(), PidGains(), gap)
    times = np.arange(500) / 5000.0
    position = step_response(loop, 5e-3, times, "RK45", relative_tolerance=1e-6)
    fine = Scenario(0.1, 5e-3, gap, sampling=Sampling(1e6, 1e6))
    expected = simulate(fine, ("q3",)).q3[::200]
    assert np.abs(expected).max() > 1e-4
    np.testing.assert_allclose(position, expected, rtol=0, atol=1e-7)


def test_an_unknown_benchmark_is_one_line_and_exit_code_two(capsys):
    assert run_command(["bench", "no_such"]) == 2
    err = capsys.readouterr().err
    assert err.startswith("error: benchmark 'no_such': must be one of ")
    assert err.count("\n") == 1


def judged(value, target="at most"):
    return BenchmarkResult("speed", value, "ms", "", 10.0, value / 10.0, target)


def test_a_target_is_met_at_its_limit_and_missed_beyond():
    assert missed_targets([judged(10.0), judged(10.0, "at least"), judged(99.0, "")]) == []
    assert missed_targets([judged(10.1)]) == ["speed: 10.1 ms: must be at most 10"]
    assert missed_targets([judged(9.9, "at least")]) == ["speed: 9.9 ms: must be at least 10"]


def test_what_is_not_a_number_misses_its_target():
    assert len(missed_targets([judged(math.nan), judged(math.nan, "at least")])) == 2


@pytest.mark.parametrize(
    ("results", "code", "complaint"),
    [
        ([judged(1.0), judged(99.0, "")], 0, ""),
        (
            [judged(11.0), judged(1.0, "at least")],
            1,
            "error: speed: 11 ms: must be at most 10\nerror: speed: 1 ms: must be at least 10\n",
        ),
        ([judged(11.0, "")], 2, "error: --check: none of these benchmarks has a target\n"),
    ],
)
def test_a_check_complains_of_each_target_that_is_missed(
    results, code, complaint, monkeypatch, capsys
):
    monkeypatch.setitem(BENCHMARKS, "speed", lambda _size: results)
    assert run_command(["bench", "speed", "--check"]) == code
    told = capsys.readouterr()
    assert told.err == complaint
    assert "at most 10" in told.out or not any(each.target for each in results)
    assert run_command(["bench", "speed"]) == 0


def test_the_command_prints_the_results_as_a_table(capsys):
    assert run_command(["bench", "control_step"]) == 0
    assert "control_step" in capsys.readouterr().out
