"""A pseudo-terminal that looks like a serial port, with a cable that can be pulled."""

import os
import select
import tty
from pathlib import Path

LARGEST_READ = 65536


class PseudoTerminal:
    """The device's end of a serial cable; the computer opens the other one.

    Parameters
    ----------
    link : Path or None
        Symbolic link to the port; its name stays when the port gets another one.

    Attributes
    ----------
    name : str
        Name of the port, for example ``/dev/pts/3``.

    Raises
    ------
    FileExistsError
        If something else than a link has that name.
    """

    def __init__(self, link: Path | None = None) -> None:
        if link is not None and link.exists() and not link.is_symlink():
            raise FileExistsError(f"{link} exists already and is no link")
        self._link = link
        self._ends: tuple[int, int] | None = None
        self.name = ""
        self.plug_in()

    def plug_in(self) -> None:
        """Connect the cable: there is a port again."""
        master, slave = self._ends = os.openpty()
        # Bytes as they are; and the device's end never waits.
        tty.setraw(slave)
        os.set_blocking(master, False)
        self.name = os.ttyname(slave)
        if self._link is not None:
            self._link.unlink(missing_ok=True)
            self._link.symlink_to(self.name)

    def pull(self) -> None:
        """Pull the cable: whoever has opened the port finds that it is gone."""
        if self._ends is not None:
            ends, self._ends = self._ends, None
            for end in ends:
                os.close(end)
            if self._link is not None:
                self._link.unlink(missing_ok=True)

    @property
    def is_plugged_in(self) -> bool:
        """Whether there is a port."""
        return self._ends is not None

    def wait(self, timeout: float) -> None:
        """Wait until the computer has sent something, `timeout` [s] at most."""
        select.select([self._ends[0]] if self._ends else [], [], [], max(timeout, 0.0))

    def read(self) -> bytes:
        """Return what the computer has sent."""
        if self._ends is None:
            return b""
        try:
            return os.read(self._ends[0], LARGEST_READ)
        except BlockingIOError:
            return b""

    def write(self, content: bytes) -> None:
        """Send bytes; those that nobody fetches are lost, as those of a device are."""
        if self._ends is None or not content:
            return
        try:
            os.write(self._ends[0], content)
        except BlockingIOError:
            return
