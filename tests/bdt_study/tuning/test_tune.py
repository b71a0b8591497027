"""How candidates are chosen and confirmed, with loops whose outcome the tests decide."""

import json
import math
from argparse import Namespace

import pytest
import yaml
from scipy.stats import beta

from bdt_controller.notch import NO_NOTCH, NotchFilter
from bdt_controller.pid import PidGains
from bdt_msgs_py.command_errors import BadInputError
from bdt_plant.plant import PlantModel
from bdt_study.calibration.start_values import read_configuration
from bdt_study.engine.in_this_process import InThisProcess
from bdt_study.tuning import run_tuning, tune
from bdt_study.tuning.candidate_outcome import summarize
from bdt_study.tuning.linear_judgment import LinearJudgment
from bdt_study.tuning.loop_trial import LoopOutcome, Tried, run_loop
from bdt_study.tuning.mechanism_ranges import MechanismRanges
from bdt_study.tuning.robust_design import ControllerDesign
from bdt_study.tuning.targets import Targets
from bdt_study.tuning.tuning_table import verdict
from bdt_twin.dead_zone_tolerance import DeadZoneSettings

GOOD = LinearJudgment(True, 3.0, 3.5, math.radians(15.0), 10.0, True)
TODAY = Tried(ControllerDesign("as it is", PidGains()), DeadZoneSettings())


def outcome(*, fails=False, settling=2.0, bias=1.0):
    return LoopOutcome(int(fails), (settling,) * 3, (50.0,) * 3, bias, 20.0)


def test_failures_have_the_interval_of_clopper_and_pearson():
    outcomes = [outcome(fails=number < 3) for number in range(100)]
    candidate = summarize(TODAY, GOOD, outcomes)
    assert (candidate.failures, candidate.loops, candidate.success) == (3, 100, 0.97)
    expected = beta.ppf(0.025, 3, 98), beta.ppf(0.975, 4, 97)
    assert candidate.failure_interval == pytest.approx(expected, rel=1e-9)


def test_a_candidate_is_told_each_target_that_it_lacks():
    baseline = summarize(TODAY, GOOD, [outcome()])
    assert Targets().lacks(baseline, baseline) == []
    poor = LinearJudgment(True, 3.0, 4.0, math.radians(5.0), 8.0, False)
    bad = summarize(TODAY, poor, [outcome(fails=True, settling=3.0)])
    lacks = Targets().lacks(bad, baseline)
    assert len(lacks) == 6
    for text in ("steady-state error", "bandwidth 8", "phase margin 5.0", "sensitivity 4.00"):
        assert any(text in lack for lack in lacks)


class Loops:
    """Stands for the random loops: which controllers fail in how many of ten."""

    def __init__(self, failures):
        self._failures = failures

    def __call__(self, engine, models, tried, seeds, control_rate):
        self.control_rate = control_rate
        for seed in seeds:
            yield [
                outcome(
                    fails=seed % 10 < self._failures(one, is_nominal=len(models) == 1),
                    bias=one.dead_zone.ratio,
                )
                for one in tried
            ]


class Search:
    """Stands for the search of gains, which has tests of its own."""

    asked = None

    def __init__(self, models, bandwidth, control_rate):
        Search.asked = bandwidth, control_rate

    def design(self, name, integral_time, *, with_notch):
        notch = NotchFilter(27.0) if with_notch else NO_NOTCH
        return ControllerDesign(name, PidGains(3000.0, 3000.0 / integral_time), notch)


@pytest.fixture(autouse=True)
def decided_designs(monkeypatch):
    monkeypatch.setattr(tune, "RobustSearch", Search)
    monkeypatch.setattr(tune, "judge", lambda *_given: GOOD)


def run(monkeypatch, failures):
    monkeypatch.setattr(tune, "run_loops", Loops(failures))
    return tuned()


def tuned():
    what = PlantModel(), MechanismRanges(), PidGains(), Targets(), 500.0
    tuner = tune.Tuner(InThisProcess(), *what, lambda *_progress: None)
    return tuner.tune(10, 20, 0)


def test_the_smallest_bias_of_what_reaches_the_targets_is_recommended(monkeypatch):
    result = run(monkeypatch, lambda one, **_: one.dead_zone.ratio < 0.55)
    assert result.is_met
    assert result.recommended.tried.dead_zone.ratio == 0.6
    assert not result.recommended.tried.design.notch.frequency
    assert result.recommended.loops == 20
    assert "recommended" in verdict(result)


def test_where_no_pid_will_do_a_filter_is_offered_with_the_evidence(monkeypatch):
    result = run(
        monkeypatch,
        lambda one, is_nominal: 5 * (not is_nominal and not one.design.notch.frequency),
    )
    assert result.is_met
    assert result.recommended.tried.design.notch.frequency > 0.0
    assert "no PID reaches the targets, the nearest lacks: 50.0 %" in verdict(result)


def test_where_nothing_will_do_that_is_said(monkeypatch):
    result = run(monkeypatch, lambda _one, is_nominal: 5 * (not is_nominal))
    assert not result.is_met
    assert verdict(result).startswith("nothing reaches the targets")


def test_what_was_only_lucky_in_the_choice_is_not_recommended(monkeypatch):
    class Confirming(Loops):
        def __call__(self, engine, models, tried, seeds, control_rate):
            self.is_choice = seeds[0] >= tune.SCREENING
            return super().__call__(engine, models, tried, seeds, control_rate)

    loops = Confirming(lambda one, **_: not loops.is_choice and one.dead_zone.ratio < 0.55)
    monkeypatch.setattr(tune, "run_loops", loops)
    result = tuned()
    assert result.is_met
    assert result.recommended.tried.dead_zone.ratio == 0.6


def test_a_random_loop_is_the_same_whatever_else_is_tried():
    models = (PlantModel(),)
    wide = Tried(TODAY.design, DeadZoneSettings(ratio=2.0))
    (alone,) = run_loop(models, [wide], 7, 500.0)
    _, together = run_loop(models, [TODAY, wide], 7, 500.0)
    assert alone == together
    assert alone.limit_cycles == 0
    assert all(0.0 < share < 200.0 for share in alone.overshoots)


def options(tmp_path, **changes):
    given = {
        "config": None,
        "calibration": None,
        "range": [],
        "bandwidth": None,
        "phase_margin": None,
        "screening": 10,
        "loops": 10,
        "seed": 0,
        "workers": None,
        "output": tmp_path / "tuned.yaml",
        "json": True,
    }
    return Namespace(**given | changes)


def test_the_command_prints_json_and_writes_parameters_that_nodes_take(
    tmp_path, monkeypatch, capsys
):
    monkeypatch.setattr(tune, "run_loops", Loops(lambda _one, is_nominal: 0))
    config = tmp_path / "start.yaml"
    config.write_text(
        yaml.safe_dump({"/**/twin": {"ros__parameters": {"structure": {"mass": 5.0}}}}),
        encoding="utf-8",
    )
    assert run_tuning.run_tuning(options(tmp_path, config=config, range=["damping=0.1"])) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed["targets_met"]
    assert printed["ranges"]["damping"] == 0.1
    written = read_configuration(tmp_path / "tuned.yaml")
    gains = printed["recommended"]["pid"]
    assert written["controller"]["pid.proportional"] == gains["proportional"]
    assert written["twin"]["dead_zone.ratio"] == 0.4
    assert written["twin"]["pid.proportional"] == gains["proportional"]
    assert written["twin"]["structure.mass"] == 5.0


@pytest.mark.parametrize("node", ["plant", "driver"])
def test_bandwidth_and_rate_are_those_of_the_loop_to_come(tmp_path, monkeypatch, capsys, node):
    loops = Loops(lambda _one, is_nominal: 0)
    monkeypatch.setattr(tune, "run_loops", loops)
    config = tmp_path / "start.yaml"
    sections = {f"/**/{node}": {"ros__parameters": {"control_rate": 250.0}}}
    config.write_text(yaml.safe_dump(sections), encoding="utf-8")
    run_tuning.run_tuning(options(tmp_path, config=config, bandwidth=4.0))
    assert Search.asked == (4.0, 250.0)
    assert loops.control_rate == 250.0
    # What simulates decisions has to know it, too.
    assert read_configuration(tmp_path / "tuned.yaml")["twin"]["decision.control_rate"] == 250.0
    printed = json.loads(capsys.readouterr().out)
    assert printed["targets"]["bandwidth"] == 4.0
    assert "bandwidth 10 rad/s, not 4" in printed["recommended"]["lacks"]


@pytest.mark.parametrize("rate", ["fast", 0.0, 500, float("nan")])
def test_a_rate_that_is_none_is_one_line(tmp_path, rate):
    config = tmp_path / "start.yaml"
    sections = {"/**/driver": {"ros__parameters": {"control_rate": rate}}}
    config.write_text(yaml.safe_dump(sections), encoding="utf-8")
    with pytest.raises(BadInputError, match=r"^--config: driver: control_rate = "):
        run_tuning.run_tuning(options(tmp_path, config=config))


def test_a_random_loop_runs_at_any_rate():
    # 20 times 51.22, divided by 51.22, is not 20.
    run_loop((PlantModel(),), [TODAY], 7, 51.22)
    (slow,) = run_loop((PlantModel(),), [TODAY], 7, 250.0)
    (usual,) = run_loop((PlantModel(),), [TODAY], 7, 500.0)
    assert slow.limit_cycles == usual.limit_cycles == 0
    assert slow.voltage_peak == pytest.approx(usual.voltage_peak, rel=0.2)
    assert slow != usual


def test_the_command_prints_a_table(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(tune, "run_loops", Loops(lambda _one, is_nominal: 0))
    assert run_tuning.run_tuning(options(tmp_path, json=False)) == 0
    printed = capsys.readouterr().out
    assert "T_i = 0.5 s" in printed
    assert "recommended" in printed


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"loops": 5}, "--loops 5: must be 10 to 1000000"),
        ({"seed": -1}, "--seed -1"),
        ({"workers": 0}, "--workers 0: must be 1 to 1024"),
        ({"range": ["friction=1"]}, "must be NAME=SHARE with one of back_emf"),
        ({"range": ["damping=x"]}, "--range damping=x"),
        ({"bandwidth": 0.0}, "--bandwidth, --phase-margin: Targets.bandwidth = 0.0 rad/s: must be"),
        ({"phase_margin": math.nan}, "Targets.phase_margin = nan"),
        ({"range": ["damping=1"]}, "MechanismRanges.damping = 1.0: must be 0 to 0.9"),
    ],
)
def test_options_that_are_not_allowed_are_one_line(tmp_path, changes, text):
    with pytest.raises(BadInputError, match=text):
        run_tuning.run_tuning(options(tmp_path, **changes))
