"""Delays of the link: harmless up to many seconds."""

import pytest

from bdt_study.engine.in_this_process import InThisProcess
from bdt_study.reproduction.delay_sweep import (
    DelayOutcome,
    DelaySweep,
    delay_begins_to_matter,
    delay_figure,
    paper_delay_is_harmless,
    random_delay_is_harmless,
    sweep_delays,
)
from bdt_study.reproduction.experiments import Choices


@pytest.fixture(scope="module")
def sweep():
    return sweep_delays(InThisProcess(), Choices(), (0.0, 1.0, 30.0), random_runs=2)


def test_one_second_does_not_matter_and_thirty_do(sweep):
    assert paper_delay_is_harmless(sweep).holds
    assert delay_begins_to_matter(sweep).measured == 30.0
    assert sweep.at(30.0).limit_cycles >= 3


def test_random_delays_do_not_matter_either(sweep):
    assert random_delay_is_harmless(sweep).holds
    assert sweep.random[0] != sweep.random[1]


def test_a_delay_that_matters_at_once_is_told():
    good, bad = DelayOutcome(0.0, 0.5, 1e-6, 0), DelayOutcome(1.0, 0.5, 1e-4, 1)
    sweep = DelaySweep((good, bad), (bad,))
    assert sweep.first_bad == 1.0
    assert not paper_delay_is_harmless(sweep).holds
    assert not delay_begins_to_matter(sweep).holds
    assert not random_delay_is_harmless(sweep).holds


def test_a_bias_of_two_percent_is_bad():
    assert not DelayOutcome(0.0, 2.0, 1e-6, 0).good


def test_without_a_bad_delay_the_longest_one_is_told():
    sweep = DelaySweep((DelayOutcome(1.0, 0.5, 1e-6, 0), DelayOutcome(5.0, 0.5, 1e-6, 0)), ())
    claim = delay_begins_to_matter(sweep)
    assert claim.holds
    assert claim.measured == 5.0


def test_the_figure_marks_limit_cycles(sweep):
    residual, _ = delay_figure(sweep, 0.005).axes
    marked = next(line for line in residual.lines if line.get_label() == "with limit cycle")
    assert list(marked.get_xdata()) == [30.0]
