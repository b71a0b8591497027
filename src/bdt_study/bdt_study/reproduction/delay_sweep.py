"""The link between twin and controller: how much delay the reconfigurable controller bears."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

from matplotlib.figure import Figure

from bdt_analysis.figures import figure_style as style
from bdt_analysis.metrics.step_analysis import LIMIT_CYCLE_THRESHOLD
from bdt_study.engine.function_map import mapped
from bdt_study.engine.job import Engine
from bdt_study.reproduction.claims import LARGEST_BIAS, Claim
from bdt_study.reproduction.experiments import Choices, reconfigured_experiment
from bdt_twin.link import LinkSettings

DELAYS = (0.0, 0.1, 0.25, 0.5, 1.0, 2.0, 3.0, 5.0, 7.5, 10.0, 12.5, 15.0, 17.5, 20.0, 25.0, 30.0)
"""Fixed delays [s]."""

PAPER_DELAY = 1.0
"""Delay of the paper [s]."""

RANDOM_RUNS = 12
"""Number of seeds for the random delay."""

LONGEST_RANDOM = 2.0
"""Random delays are uniform between zero and this [s], so their mean is the paper's."""


@dataclass(frozen=True)
class DelayOutcome:
    """A run of the reconfigurable controller.

    Attributes
    ----------
    delay : float
        Communication delay [s]; its mean when it is random.
    worst_bias : float
        Worst bias of all steps [% of the amplitude].
    worst_residual : float
        Largest peak to peak at the end of a step [m].
    limit_cycles : int
        Number of steps that end in a limit cycle.
    """

    delay: float
    worst_bias: float
    worst_residual: float
    limit_cycles: int

    @property
    def good(self) -> bool:
        """Whether the claims of figure 7 hold."""
        return self.limit_cycles == 0 and self.worst_bias < LARGEST_BIAS


@dataclass(frozen=True)
class DelaySweep:
    """Runs with a fixed delay, in the order of delay, and with random ones."""

    fixed: tuple[DelayOutcome, ...]
    random: tuple[DelayOutcome, ...]

    def at(self, delay: float) -> DelayOutcome:
        """Return the run with this fixed delay [s]."""
        return next(each for each in self.fixed if each.delay == delay)

    @property
    def first_bad(self) -> float | None:
        """Shortest delay [s] with which the claims of figure 7 do not hold."""
        return next((each.delay for each in self.fixed if not each.good), None)


def sweep_delays(
    engine: Engine,
    choices: Choices,
    delays: Sequence[float] = DELAYS,
    random_runs: int = RANDOM_RUNS,
) -> DelaySweep:
    """Run the reconfigurable controller with many delays.

    Parameters
    ----------
    engine : Engine
        What works on it.
    choices : Choices
        What the paper leaves open.
    delays : sequence of float
        Fixed delays [s], increasing.
    random_runs : int
        Number of runs in which every message has a delay of its own, uniform from 0 to 2 s, so
        that messages overtake each other.
    """
    fixed = [LinkSettings(communication_delay=delay) for delay in delays]
    random = [
        LinkSettings(
            communication_delay=0.5 * LONGEST_RANDOM,
            delay_distribution="uniform",
            delay_spread=1.0,
            link_seed=seed,
        )
        for seed in range(random_runs)
    ]
    outcomes = tuple(mapped(engine, partial(_outcome, choices), [*fixed, *random]))
    return DelaySweep(outcomes[: len(fixed)], outcomes[len(fixed) :])


def paper_delay_is_harmless(sweep: DelaySweep) -> Claim:
    """Figure 7: 1 s instead of none."""
    none, paper = sweep.at(0.0), sweep.at(PAPER_DELAY)
    return Claim(
        "fig7_delay_does_not_matter",
        "The delay of 1 s due to the data transfer does not significantly affect estimation and "
        "control.",
        paper.worst_bias - none.worst_bias,
        "% of the amplitude",
        none.good and paper.good,
        "worst bias with a delay of 1 s less that without; stable and below 2 % with both",
    )


def delay_begins_to_matter(sweep: DelaySweep) -> Claim:
    """Figure 7: how far from 1 s that stays true."""
    first = sweep.first_bad
    longest = max(each.delay for each in sweep.fixed)
    return Claim(
        "fig7_delay_that_matters",
        "A delay of 1 s does not matter (the paper does not say which one does).",
        longest if first is None else first,
        "s",
        first is None or first > PAPER_DELAY,
        f"shortest of {len(sweep.fixed)} delays up to {longest:g} s with a limit cycle or a bias "
        "of 2 %" + (": none" if first is None else ""),
    )


def random_delay_is_harmless(sweep: DelaySweep) -> Claim:
    """Figure 5: the link may be asynchronous."""
    return Claim(
        "fig7_random_delay",
        "The communication is asynchronous: its delay may vary.",
        max(each.worst_bias for each in sweep.random),
        "% of the amplitude",
        all(each.good for each in sweep.random),
        f"worst bias of {len(sweep.random)} runs in which every message has a random delay, "
        f"uniform from 0 to {LONGEST_RANDOM:g} s; no limit cycle and below 2 % in all",
    )


def delay_figure(sweep: DelaySweep, amplitude: float) -> Figure:
    """Return residual and bias over the delay; crosses mark limit cycles.

    Parameters
    ----------
    sweep : DelaySweep
        The runs.
    amplitude : float
        Amplitude of the steps [m]; a hundredth of it is the least size of a limit cycle.
    """
    smallest_cycle = 1e6 * LIMIT_CYCLE_THRESHOLD * amplitude
    with style.house_style():
        figure = style.new_figure(9.6, 3.6)
        residual, bias = figure.subplots(1, 2, sharex=True)
        for axes, value, label, limit in (
            (
                residual,
                _micrometers,
                "worst residual, peak to peak [µm]",
                smallest_cycle,
            ),
            (bias, _percent, "worst bias [% of the amplitude]", LARGEST_BIAS),
        ):
            axes.axhline(limit, color=style.FAINT, ls=":", lw=1.2)
            for runs, marker, color, name in (
                (sweep.fixed, "o", style.POSITION, "fixed delay"),
                (sweep.random, "D", style.DEAD_ZONE, "random, 0 to 2 s"),
            ):
                line = "-" if marker == "o" else ""
                axes.plot(
                    [each.delay for each in runs],
                    [value(each) for each in runs],
                    color=color,
                    marker=marker,
                    ms=4.5,
                    mfc="none",
                    ls=line,
                    lw=0.8,
                    label=name,
                )
            bad = [each for each in (*sweep.fixed, *sweep.random) if each.limit_cycles]
            axes.plot(
                [each.delay for each in bad],
                [value(each) for each in bad],
                color=style.ALARM_INK,
                marker="X",
                ms=8,
                ls="",
                label="with limit cycle",
            )
            axes.set_xlabel("communication delay [s]")
            axes.set_ylabel(label)
        residual.set_yscale("log")
        bias.set_ylim(bottom=0.0)
        residual.legend(loc="upper left")
        style.fix_layout(figure)
    return figure


def _micrometers(outcome: DelayOutcome) -> float:
    return 1e6 * outcome.worst_residual


def _percent(outcome: DelayOutcome) -> float:
    return outcome.worst_bias


def _outcome(choices: Choices, link: LinkSettings) -> DelayOutcome:
    run = reconfigured_experiment(choices, link)
    return DelayOutcome(
        link.communication_delay,
        float(run.biases.max()),
        float(run.residuals.max()),
        int(run.limit_cycles.sum()),
    )
