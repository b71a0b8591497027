"""The controller that runs: reference minus measurement through the dead-zone PID."""

from dataclasses import dataclass

from bdt_controller.control_law import (
    INITIAL_CONTROL,
    ControlLaw,
    control_step,
    discretize_control,
    switched,
)
from bdt_controller.notch import NO_NOTCH, NotchFilter
from bdt_controller.pid import PidGains
from bdt_msgs_py.quantities import quantity, validate


@dataclass(frozen=True)
class ControllerSettings:
    """Rate, dead zone, voltage limit and voltage offset of the controller."""

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
    voltage_offset: float = quantity(
        0.0,
        "V",
        "voltage added to every command, in the dead zone as well, against an offset of the "
        "amplifier: -0.02 for an amplifier that adds 0.02",
        minimum=-10.0,
        maximum=10.0,
        reconfigurable=True,
    )

    def __post_init__(self) -> None:
        validate(self)
        if self.voltage_limit and abs(self.voltage_offset) > self.voltage_limit:
            raise ValueError(
                f"ControllerSettings.voltage_offset = {self.voltage_offset!r} V: must be within "
                f"voltage_limit ({self.voltage_limit:g} V)"
            )


class DeadZoneController:
    """A dead-zone PID with its state.

    Parameters
    ----------
    gains : PidGains
        Gains of eq. 4.
    settings : ControllerSettings
        Rate, dead zone, voltage limit and voltage offset.
    notch : NotchFilter
        Filter in series with the PID.
    """

    def __init__(
        self, gains: PidGains, settings: ControllerSettings, notch: NotchFilter = NO_NOTCH
    ) -> None:
        self.configure(gains, settings, notch)
        self.reset()

    def configure(
        self, gains: PidGains, settings: ControllerSettings, notch: NotchFilter = NO_NOTCH
    ) -> None:
        """Take new gains, dead zone, offset and filter from the next step on, without a bump."""
        self._law = discretize_control(gains, 1.0 / settings.control_rate, notch)
        self._tolerance = settings.dead_zone_tolerance
        self._limit = settings.voltage_limit
        self._offset = settings.voltage_offset

    @property
    def resting_voltage(self) -> float:
        """Voltage with which nothing is to move [V]: none but the offset."""
        return self._offset

    def reset(self) -> None:
        """Forget the past errors."""
        self._state = INITIAL_CONTROL
        self._law_before: ControlLaw = self._law

    def step(self, reference: float, position: float) -> float:
        """Return the motor voltage [V] to command for one measurement (eqs 4 to 8).

        Parameters
        ----------
        reference, position : float
            Reference r and measured position q3 of platform 3 [m].
        """
        error, law = reference - position, self._law
        if law != self._law_before:
            self._state = switched(self._state, error, self._law_before, law)
            self._law_before = law
        self._state, voltage = control_step(
            self._state, error, self._tolerance, law, self._limit, self._offset
        )
        return voltage
