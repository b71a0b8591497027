"""The controller that runs: reference minus measurement through the dead-zone PID."""

from dataclasses import dataclass

from bdt_controller.pid import INITIAL_PID, PidGains, discretize_pid
from bdt_controller.voltage_limit import limited_pid_step
from bdt_msgs_py.quantities import quantity, validate


@dataclass(frozen=True)
class ControllerSettings:
    """Rate, dead zone and voltage limit of the controller."""

    control_rate: float = quantity(500.0, "Hz", "rate of measurements", minimum=0.1, maximum=1e6)
    dead_zone_tolerance: float = quantity(
        0.0,
        "m",
        "tolerance epsilon_dz around the reference within which the voltage is 0 (eq. 9); "
        "0 switches the dead zone off",
        minimum=0.0,
        maximum=0.1,
        reconfigurable=True,
    )
    voltage_limit: float = quantity(
        0.0,
        "V",
        "largest voltage commanded, with conditional integration against windup; 0 for no limit",
        minimum=0.0,
        maximum=1e6,
    )

    def __post_init__(self) -> None:
        validate(self)


class DeadZoneController:
    """A dead-zone PID with its state.

    Parameters
    ----------
    gains : PidGains
        Gains of eq. 4.
    settings : ControllerSettings
        Rate, dead zone and voltage limit.
    """

    def __init__(self, gains: PidGains, settings: ControllerSettings) -> None:
        self.configure(gains, settings)
        self.reset()

    def configure(self, gains: PidGains, settings: ControllerSettings) -> None:
        """Take new gains and a new dead zone from the next step on; the state stays."""
        self._step = discretize_pid(gains, 1.0 / settings.control_rate)
        self._tolerance = settings.dead_zone_tolerance
        self._limit = settings.voltage_limit

    def reset(self) -> None:
        """Forget the past errors."""
        self._state = INITIAL_PID

    def step(self, reference: float, position: float) -> float:
        """Return the motor voltage [V] for one measurement (eqs 4 to 8).

        Parameters
        ----------
        reference, position : float
            Reference r and measured position q3 of platform 3 [m].
        """
        self._state, voltage = limited_pid_step(
            self._state, reference - position, self._tolerance, self._step, self._limit
        )
        return voltage
