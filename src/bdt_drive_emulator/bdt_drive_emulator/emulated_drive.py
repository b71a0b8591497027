"""A drive on an emulator that can be told to have faults, for tests of a driver."""

from bdt_drive_emulator.emulated_device import FAULT_KIND
from bdt_drive_emulator.line_faults import FAULT_TIME, Fault
from bdt_serial_drive.serial_drive import SerialDrive


class EmulatedDrive(SerialDrive):
    """A serial drive whose device obeys :meth:`fault`; ``bdt hardware-check`` uses that.

    Attributes
    ----------
    faults : tuple of str
        Names of the faults that the device can have.
    fault_time : float
        Time for which a fault lasts [s].
    """

    faults = tuple(str(fault) for fault in Fault)
    fault_time = FAULT_TIME

    def fault(self, name: str) -> None:
        """Ask the device for a fault.

        Parameters
        ----------
        name : str
            One of :attr:`faults`.

        Raises
        ------
        ValueError
            If there is no such fault.
        """
        self._connected().send(FAULT_KIND, str(Fault(name)).encode("ascii"))
