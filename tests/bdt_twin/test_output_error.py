"""The estimator by output error against the true gap, with noise, holes and a wrong model."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bdt_plant import compilation
from bdt_plant.gap_profile import GapProfile, gap_at
from bdt_plant.motor import MotorParameters
from bdt_plant.plant import PlantModel, Sampling
from bdt_plant.plant_simulator import PlantSimulator
from bdt_plant.structure import StructureParameters
from bdt_twin import gap_doubt, next_fit, output_error
from bdt_twin.answer_check import AnswerCheck, Doubt
from bdt_twin.cramer_rao import cramer_rao_bound
from bdt_twin.estimator import TelemetryRejectedError
from bdt_twin.fit_doubt import FIRST_DOUBT, FIRST_MOTIONS
from bdt_twin.machine_memory import MachineMemory
from bdt_twin.model_factors import FACTORS
from bdt_twin.output_error import MOST_HELD, OutputErrorEstimator
from bdt_twin.output_error_settings import OutputErrorSettings
from bdt_twin.structure_responses import compiled_responses, compiled_responses_of_each
from bdt_twin.window_loop import compiled_window

RATE = 1000.0
CHOSEN = OutputErrorSettings(window=10.0, update_period=1.0)
GROWING = GapProfile(initial=math.radians(4.0), final=math.radians(24.0), growth_time=40.0)
KINKED = GapProfile(
    kind="table",
    table_times=(0.0, 11.0, 14.0, 30.0),
    table_gaps=tuple(np.deg2rad([3.0, 5.0, 9.0, 10.0]).tolist()),
)
PROFILES = [
    GapProfile(kind="constant", initial=math.radians(12.0)),
    GapProfile(kind="ramp", final=math.radians(20.0), growth_time=30.0),
    GROWING,
    KINKED,
]
OTHER_PLANT = PlantModel(
    motor=MotorParameters(back_emf_constant=0.1 * 1.05),
    structure=StructureParameters(mass=5.2 * 1.02, stiffness=1e4 * 0.98, damping=36.9 * 0.8),
)


def estimates_of(rows, chosen=CHOSEN, cuts=(), without=(), rate=RATE):
    """Return the estimates from batches that end at `cuts`, without some of their numbers."""
    estimator = OutputErrorEstimator(PlantModel(), chosen, rate)
    batches = list(pairwise([0, *sorted(cuts), len(rows)]))
    found = [
        estimator.update(rows[begin:end])
        for number, (begin, end) in enumerate(batches)
        if number not in without
    ]
    return [estimate for estimate in found if estimate is not None]


def seconds(rows, rate=RATE):
    return range(round(rate), len(rows), round(rate))


def measured(rows, noise, quantum, seed):
    """Return telemetry with white noise and quantization [m] of the position."""
    position = rows[:, 2] + np.random.default_rng(seed).normal(scale=noise, size=len(rows))
    return np.column_stack([rows[:, :2], np.round(position / quantum) * quantum])


def errors_of(found, profile):
    """Return errors of the gap and their standard uncertainties [deg], of what was learned."""
    learned = [estimate for estimate in found if not estimate.reason]
    errors = [estimate.gap - gap_at(profile, estimate.time) for estimate in learned]
    return np.rad2deg(errors), np.rad2deg([estimate.uncertainty for estimate in learned])


@pytest.mark.parametrize("profile", PROFILES[:3])
def test_clean_telemetry_gives_the_gap_to_a_hundredth_of_a_degree(closed_loop, profile):
    rows = closed_loop(profile, 16.0, rate=5000.0).rows
    found = estimates_of(rows, cuts=seconds(rows, 5000.0), rate=5000.0)
    errors, _ = errors_of(found, profile)
    assert errors.size >= 14
    assert np.sqrt(np.mean(errors**2)) < 0.01


def test_the_uncertainty_of_clean_telemetry_is_as_small_as_its_errors(closed_loop):
    rows = closed_loop(PROFILES[0], 16.0, rate=5000.0).rows
    found = estimates_of(rows, cuts=seconds(rows, 5000.0), rate=5000.0)
    errors, uncertainties = errors_of(found, PROFILES[0])
    assert 0.1 < np.sqrt(np.mean((errors / uncertainties) ** 2)) < 2.0


@pytest.mark.parametrize(("noise", "quantum", "rms"), [(1e-6, 1e-7, 0.1), (5e-6, 1e-6, 0.3)])
def test_noise_and_a_wrong_model_cost_little_and_the_uncertainty_says_how_much(
    closed_loop, noise, quantum, rms
):
    """The limits leave room for the tenth of the targets' samples: 1000 Hz, windows of 10 s."""
    errors, uncertainties = [], []
    for seed, profile in enumerate(PROFILES):
        loop = closed_loop(profile, 30.0, dead_zone=5.0 * (seed % 3), model=OTHER_PLANT)
        rows = measured(loop.rows, noise, quantum, seed)
        found = errors_of(estimates_of(rows, cuts=seconds(rows)), profile)
        errors.extend(found[0])
        uncertainties.extend(found[1])
    inside = np.abs(errors) < 1.96 * np.array(uncertainties)
    assert len(errors) > 100
    assert np.sqrt(np.mean(np.square(errors))) < rms
    assert 0.88 < inside.mean() < 0.995


def test_where_the_model_is_exact_the_error_is_near_the_cramer_rao_bound(closed_loop):
    profile, errors, bounds = PROFILES[0], [], []
    rows = closed_loop(profile, 20.0).rows
    for seed in range(12):
        estimator = OutputErrorEstimator(PlantModel(), replace(CHOSEN, update_period=10.0), RATE)
        estimate = None
        for batch in np.split(measured(rows, 5e-6, 1e-9, seed), 2):
            estimate = estimator.update(batch)
        # The last window that was complete ended at 10 s.
        last_fit = estimator.last_fit
        bounds.append(cramer_rao_bound(last_fit.window, last_fit.fit.unknowns, estimate.time, 5e-6))
        errors.append(estimate.gap - gap_at(profile, estimate.time))
    assert np.sqrt(np.mean(np.square(errors))) < 2.0 * np.mean(bounds)
    # An unbiased estimator that is much better than the bound would show the bound to be wrong.
    assert np.sqrt(np.mean(np.square(errors))) > 0.4 * np.mean(bounds)


def test_an_estimate_is_for_the_last_reversal(closed_loop):
    loop = closed_loop(GROWING, 20.0)
    learned = [e for e in estimates_of(loop.rows, cuts=seconds(loop.rows)) if not e.reason]
    for estimate in learned:
        turned = round(estimate.time * RATE)
        steps = np.diff(loop.theta_d[turned - 1 : turned + 2])
        before = np.diff(loop.theta_d[:turned])
        last_move = before[before != 0.0][-1]
        assert np.sign(last_move) == -np.sign(steps[steps != 0.0][0])
        assert estimate.reversals > 0


def test_an_estimate_waits_until_the_platform_has_answered_the_reversal(closed_loop):
    rows = closed_loop(GROWING, 20.0).rows
    chosen = replace(CHOSEN, update_period=0.1)
    learned = [e for e in estimates_of(rows, chosen, seconds(rows, 100.0)) if not e.reason]
    assert len(learned) > 100
    # A period of the structure's slowest vibration.
    ratio = math.sqrt(PlantModel().structure.mass / PlantModel().structure.stiffness)
    slowest = 2.0 * math.pi * ratio / (0.5 * (math.sqrt(5.0) - 1.0))
    assert min(each.age for each in learned) == pytest.approx(slowest, abs=0.03)


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("time", [15.5, 16.5, 17.1])
@pytest.mark.parametrize(("before", "after"), [(5.0, 12.0), (12.0, 3.0)])
def test_a_gap_that_jumps_is_not_stated_wrongly_and_surely(closed_loop, before, after, time, seed):
    jumping = GapProfile(
        kind="table",
        table_times=(0.0, time, time + 0.001, 30.0),
        table_gaps=tuple(np.deg2rad([before, before, after, after]).tolist()),
    )
    loop = closed_loop(jumping, 24.0, rate=2500.0, dead_zone=12.0, step_time=2.99)
    rows = measured(loop.rows, 1e-6, 1e-7, seed)
    found = estimates_of(rows, cuts=seconds(rows, 2500.0), rate=2500.0)
    errors, uncertainties = errors_of(found, jumping)
    assert errors.size > 15
    assert (np.abs(errors) < np.maximum(4.0 * uncertainties, 0.3)).all()
    assert np.median(np.abs(errors[-3:])) < 0.1


def test_a_gap_that_rises_and_falls_is_as_sure_as_its_errors_are_small(closed_loop):
    times = np.linspace(0.0, 60.0, 241)
    gaps = np.deg2rad(10.0 + 5.0 * np.sin(2.0 * np.pi * times / 40.0))
    wave = GapProfile(
        kind="table", table_times=tuple(times.tolist()), table_gaps=tuple(gaps.tolist())
    )
    loop = closed_loop(wave, 60.0, dead_zone=15.0, model=OTHER_PLANT)
    rows = measured(loop.rows, 2e-6, 1e-7, 3)
    errors, uncertainties = errors_of(estimates_of(rows, cuts=seconds(rows)), wave)
    assert errors.size > 50
    # With a scale of changes that is only that of wear it is 0.105.
    assert np.sqrt(np.mean(errors**2)) < 0.09
    assert (np.abs(errors) < 2.5 * uncertainties).mean() > 0.9


def test_growth_and_gain_come_with_the_gap(closed_loop):
    profile = PROFILES[1]
    rows = closed_loop(profile, 20.0, model=OTHER_PLANT).rows
    newest = estimates_of(rows, cuts=seconds(rows))[-1]
    assert newest.growth == pytest.approx(math.radians(20.0 / 30.0), rel=0.02)
    assert newest.gain_correction == pytest.approx(1 / 1.05, rel=1e-3)


@settings(max_examples=5, deadline=None)
@given(cuts=st.lists(st.integers(1, 5999), max_size=8, unique=True))
def test_estimates_do_not_depend_on_the_batches(cuts):
    rows = steps_by_hand()
    newest = estimates_of(rows, cuts=cuts)
    each = estimates_of(rows, cuts=range(500, 6000, 250))
    assert newest[-1] in each
    assert all(estimate in each for estimate in newest)


def steps_by_hand():
    """Return 6 s of telemetry without a loop: a voltage that goes back and forth."""
    plant = PlantSimulator(PlantModel(), PROFILES[0], Sampling(RATE, RATE / 500))
    return np.concatenate([plant.advance(voltage) for voltage in np.resize([1.0, 0.0, -1.5], 12)])


@pytest.mark.parametrize(
    ("step_time", "residual_rate", "seed"),
    [(5.6, 125.0, 1), (6.6, 125.0, 1), (5.6, 100.0, 1), (5.6, 200.0, 1), (4.6, 125.0, 3)],
)
def test_growth_that_ends_while_the_loop_rests_does_not_go_on(
    closed_loop, step_time, residual_rate, seed
):
    """What the gap would be if it had grown on explains the newest data nearly as well."""
    ends = GapProfile(
        kind="table",
        table_times=(0.0, 2.76, 60.0),
        table_gaps=tuple(np.deg2rad([9.0, 25.6, 26.1]).tolist()),
    )
    rows = closed_loop(ends, 12.0, 5000.0, dead_zone=26.0, step_time=step_time).rows
    rows = measured(rows, 1e-6, 1e-7, seed)
    chosen = replace(CHOSEN, residual_rate=residual_rate)
    errors, uncertainties = errors_of(
        estimates_of(rows, chosen, seconds(rows, 5000.0), rate=5000.0), ends
    )
    assert errors.size >= 9
    assert np.abs(errors).max() < 0.5
    assert np.abs(errors / uncertainties).max() < 3.5


def test_newest_only_lets_stale_windows_go(closed_loop):
    rows = measured(closed_loop(duration=10.0).rows, 1e-6, 1e-7, 0)
    behind = OutputErrorEstimator(PlantModel(), CHOSEN, RATE)
    newest = behind.update(rows, newest_only=True)
    [expected] = estimates_of(rows)
    assert newest.time == pytest.approx(expected.time, abs=2.0 / RATE)
    assert newest.gap == pytest.approx(expected.gap, abs=expected.uncertainty)


@pytest.mark.parametrize(
    ("largest", "reason", "begins_anew"),
    [
        # A gap that is only kept back for now is where the next window begins.
        (math.radians(1.0), "it has to be surer", False),
        (1e-6, "", True),
    ],
)
def test_fits_begin_anew_only_where_windows_leave_the_gap_unknown(
    closed_loop, monkeypatch, largest, reason, begins_anew
):
    beginnings = []
    fit_window = next_fit.fit_window

    def noted(window, growth_change, machine, predicted=None, *rest):
        beginnings.append(predicted is None)
        return fit_window(window, growth_change, machine, predicted, *rest)

    monkeypatch.setattr(next_fit, "fit_window", noted)
    if reason:
        monkeypatch.setattr(AnswerCheck, "doubt", lambda *_, **__: Doubt(reason))
    rows = measured(closed_loop(PROFILES[0], 12.0).rows, 1e-6, 1e-9, 1)
    chosen = replace(CHOSEN, largest_uncertainty=largest)
    assert all(each.reason for each in estimates_of(rows, chosen, seconds(rows)))
    assert len(beginnings) > 2 * MOST_HELD
    assert beginnings[0]
    assert any(beginnings[MOST_HELD:]) is begins_anew


def test_a_fit_begun_anew_has_to_explain_its_window_as_the_ones_before_were(
    closed_loop, monkeypatch
):
    begun_anew, surprises = [], []
    fit_window = next_fit.fit_window

    def worse_when_anew(window, growth_change, machine, predicted=None, *rest):
        fit = fit_window(window, growth_change, machine, predicted, *rest)
        begun_anew.append(predicted is None)
        return replace(fit, prediction_error=(3.0 if predicted is None else 1.0) * 1e-6)

    def noted(_, *known, is_surprised, **more):
        surprises.append(is_surprised)
        return Doubt("it has to be surer")

    # What joins takes another fit of the same window.
    monkeypatch.setattr(MachineMemory, "has_evidence", lambda *_: False)
    monkeypatch.setattr(next_fit, "fit_window", worse_when_anew)
    monkeypatch.setattr(AnswerCheck, "doubt", noted)
    rows = measured(closed_loop(PROFILES[0], 12.0).rows, 1e-6, 1e-7, 1)
    chosen = replace(CHOSEN, largest_uncertainty=1e-6)
    estimates_of(rows, chosen, seconds(rows))
    later = [surprise for anew, surprise in zip(begun_anew, surprises, strict=True) if anew][1:]
    assert later
    assert all(later)


def test_a_gap_too_unsure_for_an_answer_is_stated_with_its_uncertainty_as_long_as_nothing_is_known(
    closed_loop,
):
    rows = measured(closed_loop(GROWING, 12.0).rows, 20e-6, 1e-7, 1)
    sure = OutputErrorEstimator(PlantModel(), CHOSEN, RATE)
    last = [sure.update(rows[second : second + 1000]) for second in range(0, len(rows), 1000)][-1]
    assert not last.reason
    chosen = replace(CHOSEN, largest_uncertainty=0.5 * last.uncertainty)
    found = estimates_of(rows, chosen, seconds(rows))
    assert all(each.reason for each in found)
    rough = [each for each in found if each.is_known]
    assert len(rough) >= 3
    assert "the gap remains unknown by" in rough[-1].reason
    for each in rough:
        assert each.uncertainty >= chosen.largest_uncertainty
        assert abs(each.gap - gap_at(GROWING, each.time)) < 3.5 * each.uncertainty


@pytest.mark.parametrize("lost", [{12}, {7, 12, 13}])
def test_missing_batches_cost_no_more_than_their_data(closed_loop, lost):
    rows = measured(closed_loop(GROWING, 20.0).rows, 1e-6, 1e-7, 1)
    tenths = range(100, len(rows), 100)
    found = estimates_of(rows, cuts=tenths, without={10 * n + 5 for n in lost})
    errors, uncertainties = errors_of(found, GROWING)
    assert errors.size >= 17
    assert (np.abs(errors) < 3.5 * uncertainties + 0.01).all()
    assert np.abs(errors[-5:]).max() < 0.15


def test_outliers_are_left_out(closed_loop):
    rows = measured(closed_loop(GROWING, 20.0).rows, 1e-6, 1e-7, 2)
    random = np.random.default_rng(3)
    rows[random.random(len(rows)) < 0.02, 2] += 2e-3
    errors, _ = errors_of(estimates_of(rows, cuts=seconds(rows)), GROWING)
    assert errors.size >= 17
    assert np.abs(errors[-10:]).max() < 0.15


def rest(rows):
    rows[:, 1] = 0.0
    rows[:, 2] = 1e-3


def one_way(rows):
    """Turn the motor at an even speed, and the platform behind it."""
    rows[:, 1] = 0.5
    rows[:, 2] = 0.5 / 0.1 * rows[:, 0] * 1e-3 / (2 * math.pi)


def clipped(rows):
    np.minimum(rows[:, 2], 3e-3, out=rows[:, 2])


def another_platform(rows):
    rows[:, 2] = 1e-3 * np.sin(3.0 * rows[:, 0])


@pytest.mark.parametrize(
    ("spoil", "reason"),
    [
        (rest, "the motor does not move"),
        (one_way, "the lead screw does not reverse"),
        (clipped, "the position is stuck at its extreme while the motor turns"),
        (another_platform, "the model does not explain"),
    ],
)
def test_where_nothing_can_be_learned_nothing_is_invented(closed_loop, spoil, reason):
    rows = closed_loop().rows[:7000].copy()
    spoil(rows)
    found = estimates_of(rows, cuts=seconds(rows))
    assert all(math.isnan(estimate.gap) and estimate.uncertainty == math.inf for estimate in found)
    assert reason in found[-1].reason


def test_the_last_estimate_is_kept_with_an_uncertainty_that_grows(closed_loop):
    loop = closed_loop(PROFILES[1], 12.0)
    rows = np.concatenate([loop.rows, np.zeros((20000, 3))])
    rows[:, 0] = np.arange(len(rows)) / RATE
    rows[12000:, 2] = rows[11999, 2]
    found = estimates_of(rows, cuts=seconds(rows))
    learned = [estimate for estimate in found if not estimate.reason]
    kept = found[found.index(learned[-1]) + 1 :]
    assert kept[-1].reason == "the motor does not move"
    assert {estimate.time for estimate in kept} == {learned[-1].time}
    assert {estimate.gap for estimate in kept} == {learned[-1].gap}
    assert (np.diff([estimate.uncertainty for estimate in kept]) > 0).all()
    ends = [estimate.time + estimate.age for estimate in found]
    assert ends == pytest.approx(np.arange(len(found)))  # the window's newest samples
    # The gap would have gone on growing.
    assert abs(gap_at(PROFILES[1], 30.0) - kept[-2].gap) < 1.96 * kept[-2].uncertainty


def test_short_data_after_a_hole_teach_nothing(closed_loop):
    rows = closed_loop().rows
    estimator = OutputErrorEstimator(PlantModel(), CHOSEN, RATE)
    assert estimator.update(rows[:901]).reason == "no 1 s of data without a hole"
    estimator.restart()
    assert estimator.update(rows[5500:6100]).reason == "no 1 s of data without a hole"
    with pytest.raises(TelemetryRejectedError, match="not finite"):
        estimator.update(np.full((10, 3), np.nan))
    assert estimator.update(rows[6800:7100]).reason == "no 1 s of data without a hole"


def test_time_that_goes_back_restarts(closed_loop):
    rows = closed_loop().rows
    estimator = OutputErrorEstimator(PlantModel(), CHOSEN, RATE)
    estimator.update(rows)
    assert estimator.last_fit is not None
    with pytest.raises(TelemetryRejectedError, match="time goes back"):
        estimator.update(rows[:500])
    assert estimator.last_fit is None
    assert [estimator.update(rows)] == estimates_of(rows)


def test_without_numba_the_estimates_are_the_same(closed_loop, monkeypatch):
    rows = closed_loop(duration=4.0, rate=500.0).rows
    chosen = replace(CHOSEN, window=3.0, update_period=1.0)
    loops = compiled_window, compiled_responses, compiled_responses_of_each
    compiled = estimates_of(rows, chosen, rate=500.0)
    monkeypatch.setattr(compilation, "find_spec", lambda _: None)
    for cached in loops:
        cached.cache_clear()
    try:
        plain = estimates_of(rows, chosen, rate=500.0)
    finally:
        for cached in loops:
            cached.cache_clear()
    assert plain[-1].gap == pytest.approx(compiled[-1].gap, rel=1e-9)
    assert plain[-1].is_known


def test_what_is_known_of_a_machine_is_of_use_to_the_next_estimator(closed_loop):
    """After a short window it is surer of its constants than one that has to learn them all."""
    rows = closed_loop(duration=24.0, rate=RATE, model=OTHER_PLANT).rows.copy()
    rows[:, 2] += np.random.default_rng(3).normal(0.0, 5e-6, len(rows))
    before = OutputErrorEstimator(PlantModel(), CHOSEN, RATE)
    assert before.recollection is None
    before.update(rows[:14000])
    fresh, informed = (OutputErrorEstimator(PlantModel(), CHOSEN, RATE) for _ in range(2))
    informed.recall(before.recollection, 5.0)
    for estimator in (fresh, informed):
        estimator.update(rows[17500:19001])
    alone, first = (
        np.sqrt(np.diag(estimator.last_fit.fit.machine.covariance)[: len(FACTORS)])
        for estimator in (fresh, informed)
    )
    assert (first < alone).all()
    informed.restart()
    informed.update(rows[17500:19001])
    assert informed.last_fit.estimate == fresh.last_fit.estimate, "another run begins"


@pytest.mark.parametrize("rest", [0.0, 7.0])
def test_first_motions_tell_less_than_they_seem_to(closed_loop, monkeypatch, rest):
    """That of a machine at rest before, too; a machine that is known from another run has none."""
    still = np.zeros((round(rest * RATE), 3))
    rows = measured(np.concatenate([still, closed_loop(12.0, 12.0).rows]), 1e-6, 1e-7, 1)
    rows[:, 0] = 3.0 + np.arange(len(rows)) / RATE
    known = OutputErrorEstimator(PlantModel(), CHOSEN, RATE)
    known.update(rows)

    def uncertainties(recalls=False):
        estimator = OutputErrorEstimator(PlantModel(), CHOSEN, RATE)
        if recalls:
            estimator.recall(known.recollection, 0.0)
        found = [estimator.update(batch) for batch in np.split(rows, len(rows) // 1000)]
        return {
            each.time - 3.0 - rest: each.uncertainty
            for each in found
            if each is not None and each.is_known and not each.reason
        }

    doubted, recalled = uncertainties(), uncertainties(recalls=True)
    monkeypatch.setattr(gap_doubt, "FIRST_DOUBT", 1.0)
    plain = uncertainties()
    assert min(plain) < FIRST_MOTIONS < max(plain)
    for time, uncertainty in doubted.items():
        factor = FIRST_DOUBT if time < FIRST_MOTIONS else 1.0
        assert uncertainty == pytest.approx(factor * plain[time], rel=1e-9)
    assert uncertainties(recalls=True) == recalled


def test_a_window_that_is_explained_much_worse_than_the_one_before_needs_another(
    closed_loop, monkeypatch
):
    """A fit that had to begin anew may have found a bad one, and is sure of it."""
    rows = measured(closed_loop(12.0, 12.0).rows, 1e-6, 1e-7, 1)
    fits = []

    def fitted(window, *known):
        window, fit = next_fit.next_fit(window, *known)
        fits.append(fit)
        worse = 2.5 if len(fits) >= 8 else 1.0
        return window, replace(fit, prediction_error=worse * fit.prediction_error)

    monkeypatch.setattr(output_error, "next_fit", fitted)
    found = estimates_of(rows, cuts=seconds(rows))
    reasons = {len(fits) - number: each.reason for number, each in enumerate(reversed(found))}
    assert reasons[7] == reasons[9] == reasons[10] == ""
    assert reasons[8] == "the newest data are not explained yet"
