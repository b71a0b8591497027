"""The slow link between the twin and the controller, in simulated time."""

import heapq
import itertools
import math
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from bdt_msgs_py.quantities import quantity, validate
from bdt_plant.elementary_functions import float_exponential

DISTRIBUTIONS = ("fixed", "uniform", "log_normal", "table")

BEFORE_ALL = -1
"""Time [ns] before any telemetry."""

LOOKAHEAD = 1000
"""Messages to come that a promise takes into account."""


@dataclass(frozen=True)
class LinkSettings:
    """How long a reconfiguration takes to the controller, and whether it gets there.

    The paper has a fixed delay of 1 s.
    """

    communication_delay: float = quantity(
        1.0,
        "s",
        "simulated time from the end of a telemetry batch to the controller's new dead zone; the "
        "mean of uniform, the median of log_normal delays",
        minimum=0.0,
        maximum=1e4,
        reconfigurable=True,
    )
    delay_distribution: str = quantity(
        "fixed", "", "how the delay differs from message to message", choices=DISTRIBUTIONS
    )
    delay_spread: float = quantity(
        0.0,
        "",
        "uniform: half the width as a fraction of the delay; log_normal: standard deviation of "
        "the delay's logarithm",
        minimum=0.0,
        maximum=10.0,
    )
    delay_table: tuple[float, ...] = quantity(
        (1.0,), "s", "table: delays of the messages, over and over", minimum=0.0, maximum=1e4
    )
    request_loss: float = quantity(
        0.0, "", "probability that a reconfiguration never arrives", minimum=0.0, maximum=1.0
    )
    link_seed: int = quantity(
        1, "", "seed of random delays and losses", minimum=0, maximum=2**31 - 1
    )

    def __post_init__(self) -> None:
        validate(self)
        if self.delay_distribution == "uniform" and self.delay_spread > 1.0:
            raise ValueError(
                f"LinkSettings.delay_spread = {self.delay_spread!r}: must be 0 to 1 for uniform "
                "delays, which are not negative"
            )
        if not self.delay_table:
            raise ValueError("LinkSettings.delay_table = []: must have at least one delay")


PAPER_LINK = LinkSettings()
"""A fixed delay of 1 s."""


def delays(settings: LinkSettings) -> Iterator[float]:
    """Iterate over the delays of the messages [s], the same ones for the same seed."""
    generator = np.random.default_rng(settings.link_seed)
    typical, spread = settings.communication_delay, settings.delay_spread
    if settings.delay_distribution == "table":
        yield from itertools.cycle(settings.delay_table)
    while True:
        if settings.delay_distribution == "uniform":
            yield typical * (1.0 + spread * generator.uniform(-1.0, 1.0))
        elif settings.delay_distribution == "log_normal":
            yield typical * float_exponential(spread * generator.standard_normal())
        else:
            yield typical


def expected_delay(settings: LinkSettings) -> float:
    """Return the delay that whoever sends has to reckon with [s]."""
    if settings.delay_distribution == "table":
        return math.fsum(settings.delay_table) / len(settings.delay_table)
    return settings.communication_delay


class Reconfiguration(NamedTuple):
    """What the controller is to be set to, on its way there.

    Attributes
    ----------
    due : int
        Time at which it arrives [ns].
    estimated : int
        Stamp of the newest sample behind it [ns].
    tolerance : float
        Dead-zone tolerance epsilon_dz [m].
    voltage_offset : float or None
        Voltage that the controller is to add to its commands [V]; None to leave that as it is.
    gains : tuple of (str, float)
        Gains by the names of the controller's parameters; empty to leave them as they are.
    """

    due: int
    estimated: int
    tolerance: float
    voltage_offset: float | None = None
    gains: tuple[tuple[str, float], ...] = ()


class DelayedLink:
    """Delivers reconfigurations some time after they were sent, none after a newer one.

    Parameters
    ----------
    settings : LinkSettings
        Delays and losses.

    Attributes
    ----------
    lost : int
        Number of reconfigurations that never arrive.
    overtaken : int
        Number of reconfigurations that arrived later than a newer one, and were dropped.
    """

    def __init__(self, settings: LinkSettings) -> None:
        self._delays = delays(settings)
        self._drawn: deque[int] = deque()
        self._expected = expected_delay(settings)
        self._loss = settings.request_loss
        # Losses have draws of their own, so that they do not change the delays.
        self._draws = np.random.default_rng((settings.link_seed, 1))
        self._pending: list[Reconfiguration] = []
        self._newest: int | None = None
        self._in_force: Reconfiguration | None = None
        self.lost = self.overtaken = 0

    def use(self, settings: LinkSettings) -> None:
        """Delay what is sent from now on as other settings say; losses go on as they were."""
        self._delays = delays(settings)
        self._drawn.clear()
        self._expected = expected_delay(settings)

    @property
    def in_force(self) -> Reconfiguration | None:
        """What was delivered last, with the offset and the gains from before; None for nothing."""
        return self._in_force

    def resume(
        self,
        tolerance: float,
        voltage_offset: float | None = None,
        gains: tuple[tuple[str, float], ...] = (),
    ) -> None:
        """Take for delivered what somebody else has delivered before; see `Reconfiguration`.

        Whatever is learned from telemetry is newer.
        """
        self._newest = BEFORE_ALL
        self._in_force = Reconfiguration(BEFORE_ALL, BEFORE_ALL, tolerance, voltage_offset, gains)

    @property
    def expected_delay(self) -> float:
        """Delay that the sender has to reckon with [s]."""
        return self._expected

    def send(
        self,
        now: int,
        estimated: int,
        tolerance: float,
        voltage_offset: float | None = None,
        gains: tuple[tuple[str, float], ...] = (),
    ) -> int | None:
        """Send a reconfiguration.

        Parameters
        ----------
        now : int
            Time of sending [ns].
        estimated, tolerance, voltage_offset, gains
            See :class:`Reconfiguration`.

        Returns
        -------
        int or None
            When it arrives [ns]; None if it gets lost.
        """
        due = now + self._delay_of(0)
        self._drawn.popleft()
        if self._loss and self._draws.random() < self._loss:
            self.lost += 1
            return None
        sent = Reconfiguration(due, estimated, tolerance, voltage_offset, gains)
        heapq.heappush(self._pending, sent)
        return due

    def send_again(self, now: int) -> int | None:
        """Send what was delivered last, as whoever had it has lost it.

        Parameters
        ----------
        now : int
            Time of sending [ns].

        Returns
        -------
        int or None
            When it arrives [ns]; None if it gets lost, or nothing has been delivered.
        """
        if self._in_force is None or self._newest is None:
            return None
        # Newer than what was delivered, older than whatever is learned from more telemetry.
        in_force = self._in_force
        return self.send(
            now, self._newest + 1, in_force.tolerance, in_force.voltage_offset, in_force.gains
        )

    def deliver(self, now: int) -> Reconfiguration | None:
        """Return the newest of what has arrived at `now` [ns] and forget the older ones.

        None when nothing newer has arrived than what was delivered before.
        """
        delivered = None
        while self._pending and self._pending[0].due <= now:
            arrived = heapq.heappop(self._pending)
            if self._newest is None or arrived.estimated > self._newest:
                delivered, self._newest = arrived, arrived.estimated
            else:
                self.overtaken += 1
        if delivered is not None:
            self._in_force = _after(self._in_force, delivered)
        return delivered

    def next_due(self) -> int | None:
        """Return when the next reconfiguration arrives [ns], or None."""
        return self._pending[0].due if self._pending else None

    def earliest_arrival(self, end: int, batch: int) -> int:
        """Return before when nothing can arrive that is learned from telemetry yet to come [ns].

        Parameters
        ----------
        end : int
            Stamp of the newest sample that has been worked on [ns].
        batch : int
            Duration of each batch to come [ns]; each one leads to one message at most.
        """
        best = self._delay_of(0) + batch
        for number in range(1, LOOKAHEAD):
            ended = (number + 1) * batch
            if ended >= best:
                break
            best = min(best, ended + self._delay_of(number))
        return end + min(best, LOOKAHEAD * batch)

    def restart(self) -> None:
        """Forget everything that is on its way and what was delivered."""
        self._pending.clear()
        self._newest = self._in_force = None

    def _delay_of(self, number: int) -> int:
        """Return the delay [ns] of a message to come, 0 being the next one."""
        while len(self._drawn) <= number:
            self._drawn.append(round(next(self._delays) * 1e9))
        return self._drawn[number]


def _after(before: Reconfiguration | None, arrived: Reconfiguration) -> Reconfiguration:
    """Return what is in force after an arrival, which may leave offset and gains as they were."""
    if before is None:
        return arrived
    if arrived.voltage_offset is None:
        arrived = arrived._replace(voltage_offset=before.voltage_offset)
    return arrived if arrived.gains else arrived._replace(gains=before.gains)
