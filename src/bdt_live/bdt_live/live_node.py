"""The node behind a page: hears a loop, tells it to the page, and does what the page asks for."""

import time
from pathlib import Path
from typing import Any

from rcl_interfaces.msg import Log
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from std_msgs.msg import Header

from bdt_bringup.loop_health import LoopHealth
from bdt_bringup.loop_state import SILENCE
from bdt_live.bag_saving import BagSaving
from bdt_live.channel import Channel
from bdt_live.extremes import rounded
from bdt_live.from_server import read_server_message
from bdt_live.loop_control import LoopControl
from bdt_live.loop_listener import LoopListener
from bdt_live.page_requests import NODES, PageRequest
from bdt_live.remote_parameters import RemoteParameters
from bdt_msgs_py.command_errors import printable
from bdt_msgs_py.qos import publisher_profile
from bdt_msgs_py.reading import nanoseconds_from_seconds
from bdt_msgs_py.topics import CONTROLLER_NODE, DEAD_ZONE_PARAMETER, MARK
from bdt_msgs_py.writing import mark

FRAME_PERIOD = 0.02
"""Wall time [s] between two frames."""

REQUEST_PERIOD = 0.01
"""Wall time [s] between two looks at what pages ask for."""

STATE_PERIOD = 0.5
"""Wall time [s] between two looks at the nodes of the loop."""

LONGEST_LINE = 300


class LiveNode(Node):
    """Hears a loop and tells it to the page.

    Parameters
    ----------
    channel : Channel
        To the process of the page.
    output : Path
        Folder for bags.
    spares_loop : bool
        Whether the loop waits for nobody, and may not be held up: see :class:`LoopListener`.
    **node_arguments
        Passed on to :class:`rclpy.node.Node`.

    Attributes
    ----------
    messages : int
        Number of messages taken, for :func:`bdt_msgs_py.spinning.spin_at_intervals_until`.
    is_alone : bool
        Whether the process of the page is gone.
    """

    def __init__(
        self, channel: Channel, output: Path, *, spares_loop: bool = False, **node_arguments: Any
    ) -> None:
        super().__init__("live", **node_arguments)
        self._channel = channel
        self.is_alone = False
        self._health = LoopHealth(self)
        self._parameters = {name: RemoteParameters(self, name, channel.send) for name in NODES}
        self._listener = LoopListener(
            self, list(self._parameters.values()), spares_loop=spares_loop
        )
        rows = self._listener.rows
        self._control = LoopControl(
            self._parameters, lambda: self._listener.end or 0.0, lambda: rows.gap
        )
        self._saving = BagSaving(output)
        self._marking = self.create_publisher(Header, MARK.name, publisher_profile(MARK))
        self._told_marks: list[float] = []
        self._told_pause = False
        self.create_subscription(Log, "/rosout", self._take_log, 50)
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(FRAME_PERIOD, self._send_frame, clock=steady)
        self.create_timer(REQUEST_PERIOD, self._take_requests, clock=steady)
        self.create_timer(STATE_PERIOD, self._look_at_nodes, clock=steady)

    @property
    def messages(self) -> int:
        """Number of messages taken."""
        return self._listener.messages

    def _send_frame(self) -> None:
        dead_zone = self._parameters[CONTROLLER_NODE].values.get(DEAD_ZONE_PARAMETER)
        self._listener.rows.hold("dead_zone", self._listener.end or 0.0, dead_zone)
        rows = self._listener.rows.rows()
        if rows:
            self._channel.send({"type": "frame", "rows": rows}, may_be_dropped=True)
        else:
            self._channel.flush()
        if self._told_marks != list(self._listener.marks):
            self._tell_marks()
        if self._told_pause != self._control.is_paused:
            self._send_state()
        self._listener.look()

    def _tell_marks(self) -> None:
        self._told_marks = list(self._listener.marks)
        self._channel.send({"type": "marks", "times": self._told_marks})

    def _look_at_nodes(self) -> None:
        for parameters in self._parameters.values():
            parameters.look()
        self._send_state()

    def _send_state(self) -> None:
        state, now = self._health.state, time.monotonic()
        timing, self._told_pause = self._listener.timing, self._control.is_paused
        nodes = [
            {
                "name": name,
                "level": 3 if now - report.heard > SILENCE else min(report.level, 2),
                "text": report.text[:LONGEST_LINE],
                "age": round(now - report.heard, 1),
            }
            for name, report in self._health.reports.items()
        ]
        self._channel.send(
            {
                "type": "state",
                "word": state.word,
                "cause": state.node,
                "reason": state.reason[:LONGEST_LINE],
                "nodes": nodes,
                "rate": None if timing.rate is None else rounded(timing.rate),
                "latency": None if timing.latency is None else rounded(timing.latency),
                "pace": self._control.pace,
                "paused": self._told_pause,
            },
            may_be_dropped=True,
        )
        if (saved := self._saving.outcome()) is not None:
            name, reason = saved
            self._channel.send({"type": "saved", "bag": name, "reason": reason})

    def _take_log(self, message: Log) -> None:
        line = {
            "node": printable(message.name)[:LONGEST_LINE],
            "level": ord(message.level) if isinstance(message.level, bytes) else message.level,
            "text": printable(message.msg)[:LONGEST_LINE],
        }
        self._channel.send({"type": "log", "line": line}, may_be_dropped=True)

    # Requests ------------------------------------------------------------------------------

    def _take_requests(self) -> None:
        texts = self._channel.receive()
        if texts is None:
            self.is_alone = True
            return
        for text in texts:
            page, request = read_server_message(text)
            if request is None:
                for parameters in self._parameters.values():
                    parameters.tell()
                self._tell_marks()
            else:
                self._do(page, request)

    def _do(self, page: int, request: PageRequest) -> None:
        def answer(reason: str | None) -> None:
            number = request.number
            self._channel.send({"type": "reply", "page": page, "number": number, "reason": reason})

        if request.action == "save":
            answer(self._saving.begin(self._listener.recent))
        elif request.action == "mark":
            answer(self._mark())
        else:
            self._control.do(request, answer)

    def _mark(self) -> str | None:
        """Mark the newest moment for all who listen, recorders as well; return why not, if so."""
        if self._listener.end is None:
            return "nothing has been heard of the loop yet"
        self._marking.publish(mark(nanoseconds_from_seconds(self._listener.end), self.get_name()))
        return None
