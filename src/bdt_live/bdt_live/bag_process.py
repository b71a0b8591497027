"""The process behind a page that plays a bag: no ROS, and nothing to set but the pace.

``python -m bdt_bringup.child_node PARENT bdt_live.bag_process SOCKET OUTPUT BAG``
"""

import select
import socket
import sys
import time
from pathlib import Path

from bdt_bags.bag_error import BagError
from bdt_bags.reading.recording import Recording, load_recording
from bdt_live.channel import Channel
from bdt_live.from_server import read_server_message
from bdt_live.page_requests import PageRequest
from bdt_live.playback import Playback
from bdt_msgs_py.command_errors import BAD_INPUT, complain
from bdt_msgs_py.stop_signals import StopSignals

FRAME_PERIOD = 0.04
"""Wall time [s] between two frames."""

STATE_PERIOD = 0.5
"""Wall time [s] between two words on how it goes."""

LARGEST_FRAME = 300
"""Rows of a frame."""

WITHOUT_A_LOOP = "a bag is played back: there is no loop to ask"


class BagShow:
    """Plays a bag for the page.

    Parameters
    ----------
    channel : Channel
        To the process of the page.
    recording : Recording
        The bag.
    """

    def __init__(self, channel: Channel, recording: Recording) -> None:
        self._channel, self._recording = channel, recording
        self._playback = Playback(recording)
        self._marks = recording.marks
        self._told_marks: list[float] = []
        self._state_due = 0.0

    def run(self, signals: StopSignals) -> None:
        """Play until the process of the page is gone, or a signal comes."""
        before = time.monotonic()
        while not signals.requested:
            select.select([self._channel], [], [], FRAME_PERIOD)
            texts = self._channel.receive()
            if texts is None:
                return
            for text in texts:
                self._take(*read_server_message(text))
            now = time.monotonic()
            if now - before >= FRAME_PERIOD:
                self._send(self._playback.advance(now - before))
                before = now
            if now >= self._state_due:
                self._state_due = now + STATE_PERIOD
                self._send_state()

    def _send(self, rows: list[list[float | None]]) -> None:
        for begin in range(0, len(rows), LARGEST_FRAME):
            frame = {"type": "frame", "rows": rows[begin : begin + LARGEST_FRAME]}
            self._channel.send(frame, may_be_dropped=True)
        self._channel.flush()
        if self._told_marks != self._played_marks:
            self._tell_marks()

    @property
    def _played_marks(self) -> list[float]:
        return [time for time in self._marks if time <= self._playback.time]

    def _tell_marks(self) -> None:
        self._told_marks = self._played_marks
        self._channel.send({"type": "marks", "times": self._told_marks})

    def _send_state(self) -> None:
        playback = self._playback
        self._channel.send(
            {
                "type": "state",
                "word": "the end of the bag" if playback.is_over else "a bag is played back",
                "cause": "",
                "reason": "",
                "nodes": [],
                "rate": None,
                "latency": None,
                "pace": playback.pace,
                "paused": playback.is_paused,
                "over": playback.is_over,
            },
            may_be_dropped=True,
        )

    def _take(self, page: int, request: PageRequest | None) -> None:
        if request is None:
            self._tell_pitch()
            self._tell_marks()
            return
        reason = self._do(request)
        self._state_due = 0.0
        number = request.number
        self._channel.send({"type": "reply", "page": page, "number": number, "reason": reason})

    def _do(self, request: PageRequest) -> str | None:
        playback = self._playback
        if request.action == "pause":
            playback.is_paused = True
        elif request.action == "resume":
            if playback.is_over:
                playback.rewind()
            playback.is_paused = False
        elif request.action == "step":
            self._send(playback.step())
        elif request.action == "pace":
            playback.pace = request.amount
        elif request.action == "mark":
            self._marks = (*self._marks, playback.time)
        else:
            return WITHOUT_A_LOOP
        return None

    def _tell_pitch(self) -> None:
        if self._recording.pitch is not None:
            pitch = {"name": "lead_screw.pitch", "kind": "fixed", "value": self._recording.pitch}
            self._channel.send({"type": "parameters", "node": "plant", "controls": [pitch]})


def main(args: list[str] | None = None) -> None:
    """Play a bag."""
    _, number, _output, bag = sys.argv if args is None else args
    channel = Channel(socket.socket(fileno=int(number)))
    with StopSignals() as signals:
        try:
            recording = load_recording(Path(bag))
        except BagError as error:
            sys.exit(complain(error, BAD_INPUT))
        BagShow(channel, recording).run(signals)


if __name__ == "__main__":
    main()
