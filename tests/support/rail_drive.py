"""Drives for tests: a carriage on a rail whose speed follows the voltage, and what goes wrong."""

import math
import threading
from pathlib import Path

import numpy as np

SPEED = 0.004
"""Speed of the carriage [m/s] at 1 V."""

MADE = []
"""Every drive that was made, so that a test finds the one that a node has made."""


class RailDrive:
    """A carriage that is where the applied voltages have brought it, one control period each.

    What is asked of it stands in ``calls``; a test sets ``failing`` to the name of a method that
    shall raise, ``position`` to where the carriage is, ``hanging`` to an event to wait for.
    """

    def __init__(self, period=0.002, samples=0, log=""):
        self.period, self.per_period = period, samples
        self.position = self.voltage = 0.0
        self.calls, self.written = [], []
        self.failing, self.hanging, self.log = "", None, log
        MADE.append(self)

    def open(self):
        self._call("open")

    def read(self):
        self._call("read")
        if self.hanging is not None:
            self.hanging.wait(60.0)
        applied = self.voltage
        self.position += applied * SPEED * self.period
        if not self.per_period:
            return self.position, applied
        rows = np.tile((applied, self.position), (self.per_period, 1))
        return self.position, applied, rows

    def write(self, voltage):
        self._call("write")
        self.voltage = voltage
        self.written.append(voltage)

    def stop(self):
        self._call("stop")
        self.voltage = 0.0

    def close(self):
        self._call("close")

    def _call(self, name):
        if self.log and name not in self.calls:
            with Path(self.log).open("a", encoding="utf-8") as file:
                file.write(f"{name}\n")
        self.calls.append(name)
        if self.failing == name:
            raise OSError(f"{name}: the cable is pulled")


class LostSensor(RailDrive):
    """A carriage whose position cannot be read."""

    def read(self):
        return math.nan, self.voltage


class NoStop:
    """A class that is no drive."""

    def open(self): ...

    def read(self): ...

    def write(self, voltage): ...


def hang(drive):
    """Make a drive hang in its next reading; return the event that ends it."""
    drive.hanging = threading.Event()
    return drive.hanging
