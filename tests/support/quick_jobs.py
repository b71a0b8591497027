"""Jobs for an engine that take no time, or as long as a test wants; nothing of ours is imported."""

import os
import time
from dataclasses import dataclass


@dataclass(frozen=True)
class Job:
    """A job with a number, which is all that its work depends on."""

    number: int

    @property
    def name(self):
        return f"part {self.number}"


class Square(Job):
    """Gives the square of its number."""

    def run(self):
        return self.number**2


class End(Job):
    """Ends its process."""

    def run(self):
        os._exit(1)


@dataclass(frozen=True)
class Refuse(Job):
    """Raises an error."""

    error: Exception

    def run(self):
        raise self.error


@dataclass(frozen=True)
class Sleep(Job):
    """Sleeps [s] and gives the process in which it did."""

    duration: float

    def run(self):
        time.sleep(self.duration)
        return os.getpid()


def slept(duration):
    """Return a duration after it has passed [s]."""
    time.sleep(duration)
    return duration
