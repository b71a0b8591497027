"""Log messages of a node on ``/rosout``."""

from embedded_ros import log_output
from embedded_ros.cdr import ENCAPSULATION, codec
from embedded_ros.duration import Duration
from embedded_ros.graph import NodeEntities
from embedded_ros.message_classes import message_class
from embedded_ros.qos_policies import DurabilityPolicy
from embedded_ros.qos_profile import QoSProfile
from embedded_ros.session import Session

__all__ = ["RosoutPublisher"]

_LOG = "rcl_interfaces/msg/Log"


class RosoutPublisher:
    """Publishes what a logger and its children log."""

    def __init__(self, session: Session, node: NodeEntities, logger_name: str) -> None:
        profile = QoSProfile(
            depth=1000, durability=DurabilityPolicy.TRANSIENT_LOCAL, lifespan=Duration(seconds=10)
        )
        self._session = session
        self._node = node
        self._logger_name = logger_name
        self._writer = session.writer("rt/rosout", _LOG, profile)
        session.graph.add(node, writers=(self._writer.guid,), readers=())
        log_output.add_sink(logger_name, self._publish)

    def _publish(self, record: log_output.Record, nanoseconds: int) -> None:
        if self._writer.closed or not self._session.valid:
            return
        stamp = message_class("builtin_interfaces/msg/Time")(
            sec=nanoseconds // 10**9, nanosec=nanoseconds % 10**9
        )
        message = message_class(_LOG)(
            stamp=stamp,
            level=int(record.severity),
            name=record.name,
            msg=record.message,
            file=record.file,
            function=record.function,
            line=record.line,
        )
        payload = bytearray(ENCAPSULATION)
        codec(_LOG).write(message, payload)
        self._writer.write(payload)

    def close(self) -> None:
        """Publish no more."""
        log_output.remove_sink(self._logger_name, self._publish)
        self._writer.close()
