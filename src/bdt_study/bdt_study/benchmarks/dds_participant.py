"""The floor of transport and real time: the same ping-pong with bytes straight to Cyclone DDS.

No messages, no executor, no nodes: a wait, a take and a write. It runs where the Python package
``cyclonedds`` is installed.
"""

import json
import sys
import time
from dataclasses import dataclass
from typing import Any

from cyclonedds._clayer import ddspy_take, ddspy_write
from cyclonedds.core import Policy, Qos, ReadCondition, WaitSet
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import sequence, uint8
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

from bdt_msgs_py.real_time import enter_real_time
from bdt_study.benchmarks.paced_timer import periods, real_time_settings, report

ANY_STATE = 0x7F
PAYLOAD_SIZE = 80
"""Bytes of the payload, about those of a JointState."""
NUMBER_SIZE = 8
"""Bytes at its beginning that hold its number."""
RESEND_PERIOD = 1.0
"""Wall time without an answer after which bytes are sent again [s]."""


@dataclass
class Payload(IdlStruct, typename="bdt_bench::Payload"):
    """Nothing but bytes."""

    data: sequence[uint8]  # type: ignore[type-arg]


HEAD = Payload([0] * PAYLOAD_SIZE).serialize()[:-PAYLOAD_SIZE]  # type: ignore[arg-type]
"""What stands before the bytes: the encoding, and their number."""


class Endpoints:
    """A reliable writer, a reader, and a wait for the latter."""

    def __init__(self, domain: int, out: str, back: str) -> None:
        self._participant = DomainParticipant(domain)
        qos = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.History.KeepLast(10))
        self.writer = DataWriter(self._participant, Topic(self._participant, out, Payload), qos)
        self.reader = DataReader(self._participant, Topic(self._participant, back, Payload), qos)
        self._condition = ReadCondition(self.reader, ANY_STATE)
        self._waits = WaitSet(self._participant)
        self._waits.attach(self._condition)

    def matched(self) -> bool:
        """Whether the other end is there, in both directions."""
        return bool(
            self.writer.get_matched_subscriptions() and self.reader.get_matched_publications()
        )

    def write(self, payload: bytes) -> None:
        """Write bytes."""
        ddspy_write(self.writer._ref, payload)

    def take(self) -> bytes:
        """Wait for bytes and take them; empty ones when none came for :data:`RESEND_PERIOD`."""
        if not self._waits.wait(duration(seconds=RESEND_PERIOD)):
            return b""
        samples: Any = ddspy_take(self.reader._ref, ANY_STATE, 1)
        if samples and not isinstance(samples, int) and samples[0][1].valid_data:
            payload: bytes = samples[0][0]
            return payload
        return b""


def main() -> None:
    """Run ``echo DOMAIN [PRIORITY]`` and with it ``ping DOMAIN COUNT``, or another end.

    That is ``paced DOMAIN RATE SECONDS PRIORITY``.
    """
    role, domain, *numbers = sys.argv[1:]
    if role == "echo":
        link = Endpoints(int(domain), "raw_pong", "raw_ping")
        enter_real_time(real_time_settings(int(numbers[0]) if numbers else 0))
        print("ready", flush=True)
        while True:
            payload = link.take()
            if payload:
                link.write(payload)
    link = Endpoints(int(domain), "raw_ping", "raw_pong")
    while not link.matched():
        time.sleep(0.001)
    if role == "paced":
        paced(link, float(numbers[0]), float(numbers[1]), int(numbers[2]))
    else:
        ping(link, int(numbers[0]))


def ping(link: Endpoints, count: int) -> None:
    """Send bytes, wait for their echo, and so on; what is not answered is sent again.

    One end may know the other before the other knows it: the first answers then go nowhere.
    """
    begun = cpu = 0.0
    for number in range(count // 10 + count):
        if number == count // 10:
            begun, cpu = time.perf_counter(), time.process_time()
        exchange(link, number)
    report = {"seconds": time.perf_counter() - begun, "cpu": time.process_time() - cpu}
    print(json.dumps(report), flush=True)


def paced(link: Endpoints, rate: float, seconds: float, priority: int) -> None:
    """Send bytes at a rate [Hz] for a time [s], and print how long each echo took."""
    exchange(link, 0)
    refusals = enter_real_time(real_time_settings(priority))
    times = []
    for number, _ in enumerate(periods(rate, seconds), 1):
        begun = time.monotonic_ns()
        exchange(link, number)
        times.append(time.monotonic_ns() - begun)
    report(times, refusals)


def exchange(link: Endpoints, number: int) -> None:
    """Send bytes with a number, and wait for their echo."""
    payload = HEAD + number.to_bytes(NUMBER_SIZE, "little") + bytes(PAYLOAD_SIZE - NUMBER_SIZE)
    answer = b""
    while answer != payload:
        # Only silence asks for it again: an echo that came twice is none of this one.
        if not answer:
            link.write(payload)
        answer = link.take()


if __name__ == "__main__":
    main()
