"""From an estimate to a reconfiguration on its way: what node and offline loop share."""

from bdt_twin.dead_zone_tolerance import DeadZoneRule
from bdt_twin.decision import Decision
from bdt_twin.estimator import Estimate
from bdt_twin.link import DelayedLink, Reconfiguration


class Reconfigurator:
    """Sends what an estimate asks for over the slow link.

    Parameters
    ----------
    rule : DeadZoneRule
        Width of the dead zone for an estimate.
    link : DelayedLink
        The way to the controller.
    """

    def __init__(self, rule: DeadZoneRule, link: DelayedLink) -> None:
        self._rule = rule
        self._link = link

    @property
    def is_bounded(self) -> bool:
        """Whether the gap is so unsure that its bound, not doubt, sets the dead zone."""
        return self._rule.is_bounded

    def send(
        self,
        estimate: Estimate,
        now: int,
        voltage_offset: float | None = None,
        decision: Decision | None = None,
    ) -> float | None:
        """Send a dead zone, unless nothing is known of the gap.

        Parameters
        ----------
        estimate : Estimate
            What is known.
        now : int
            Time of sending [ns].
        voltage_offset : float or None
            Voltage that the controller is to add to its commands [V], sent with the dead zone;
            None to leave that as it is.
        decision : Decision or None
            What was decided by simulation; None for the rule.

        Returns
        -------
        float or None
            The tolerance that was sent [m], whether it arrives or gets lost; None if none was.
        """
        if not estimate.is_known:
            return None
        effective = now * 1e-9 + self._link.expected_delay
        wanted = self._rule.wanted(estimate, effective)
        gains: tuple[tuple[str, float], ...] = ()
        if decision is not None:
            # Where doubt is beyond its bound, the bound counts and no simulation.
            if decision.tolerance is not None and not self._rule.is_bounded:
                wanted = decision.tolerance
            gains = decision.gains.by_name() if decision.gains is not None else ()
        tolerance = self._rule.limited(wanted, effective)
        self._link.send(now, now, tolerance, voltage_offset, gains)
        return tolerance

    @property
    def in_force(self) -> Reconfiguration | None:
        """What was delivered last; None for nothing."""
        return self._link.in_force

    def gains_in_force(self) -> dict[str, float]:
        """Return the gains that were delivered last, by name; empty for none."""
        in_force = self._link.in_force
        return {} if in_force is None else dict(in_force.gains)

    def resume(
        self,
        now: int,
        tolerance: float,
        voltage_offset: float | None = None,
        gains: tuple[tuple[str, float], ...] = (),
    ) -> None:
        """Go on from what a twin before, or somebody else, has put in force.

        Parameters
        ----------
        now : int
            Time [ns].
        tolerance, voltage_offset, gains
            See :class:`bdt_twin.link.Reconfiguration`.
        """
        self._rule.resume(tolerance, now * 1e-9)
        self._link.resume(tolerance, voltage_offset, gains)

    def send_again(self, now: int) -> bool:
        """Send what is in force at the time `now` [ns]; False if nothing is, or it gets lost."""
        return self._link.send_again(now) is not None

    def deliver(self, now: int) -> Reconfiguration | None:
        """Return the newest of what has arrived at `now` [ns]."""
        return self._link.deliver(now)

    def next_due(self) -> int | None:
        """Return when the next reconfiguration arrives [ns], or None."""
        return self._link.next_due()

    def earliest_action(self, end: int, batch: int) -> int:
        """Return before when telemetry yet to come cannot change the dead zone [ns].

        Parameters
        ----------
        end : int
            Stamp of the newest sample that has been worked on [ns].
        batch : int
            Duration of each batch to come [ns].
        """
        return self._link.earliest_arrival(end, batch)

    def restart(self) -> None:
        """Forget everything: another run begins."""
        self._rule.restart()
        self._link.restart()
