"""The floor of the transport benchmarks: the same ping-pong with bytes straight to Cyclone DDS.

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

ANY_STATE = 0x7F
PAYLOAD_SIZE = 80
"""Bytes of the payload, about those of a JointState."""


@dataclass
class Payload(IdlStruct, typename="bdt_bench::Payload"):
    """Nothing but bytes."""

    data: sequence[uint8]  # type: ignore[type-arg]


class Link:
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
        """Wait for bytes and take them."""
        while True:
            self._waits.wait(duration(seconds=1))
            samples: Any = ddspy_take(self.reader._ref, ANY_STATE, 1)
            if samples and not isinstance(samples, int) and samples[0][1].valid_data:
                payload: bytes = samples[0][0]
                return payload


def main() -> None:
    """Run ``ping DOMAIN COUNT`` or ``echo DOMAIN``."""
    role, domain, *numbers = sys.argv[1:]
    if role == "echo":
        link = Link(int(domain), "raw_pong", "raw_ping")
        print("ready", flush=True)
        while True:
            link.write(link.take())
    link = Link(int(domain), "raw_ping", "raw_pong")
    while not link.matched():
        time.sleep(0.001)
    payload = Payload([0] * PAYLOAD_SIZE).serialize()  # type: ignore[arg-type]
    count = int(numbers[0])
    begun = cpu = 0.0
    for number in range(count // 10 + count):
        if number == count // 10:
            begun, cpu = time.perf_counter(), time.process_time()
        link.write(payload)
        link.take()
    report = {"seconds": time.perf_counter() - begun, "cpu": time.process_time() - cpu}
    print(json.dumps(report), flush=True)


if __name__ == "__main__":
    main()
