"""Requests and replies over DDS topics, as rmw_cyclonedds exchanges them.

After the encapsulation header stand sixteen bytes: the client, that is the instance handle of its
request writer, and a number that the client counts. A reply repeats them.
"""

import struct
import time
from collections.abc import Callable
from typing import Any, NamedTuple, Self

from cyclonedds._clayer import (
    ddspy_get_matched_publication_data,
    ddspy_get_matched_subscription_data,
)

from embedded_ros import cyclone
from embedded_ros.cdr import ENCAPSULATION, CdrError, codec
from embedded_ros.deadline import Deadline
from embedded_ros.endpoints import Reader, Writer
from embedded_ros.held_signals import HeldSignals
from embedded_ros.qos_profile import QoSProfile
from embedded_ros.session import Session

__all__ = ["ClientPorts", "RequestHeader", "ServerPorts", "ServiceAddress"]

_HEADER = struct.Struct("<Qq")
_BODY = len(ENCAPSULATION) + _HEADER.size
_MATCH_TIMEOUT_S = 0.1


class ServiceAddress(NamedTuple):
    """Which service, and how: the class, the name as given and in full, the policies."""

    type: type[Any]
    given_name: str
    full_name: str
    profile: QoSProfile


class RequestHeader(NamedTuple):
    """Identity of a request, and the writer that it came from as the server sees it."""

    client: int
    sequence_number: int
    writer: int


def _payload(write: Callable[[Any, bytearray], None], header: bytes, message: Any) -> bytearray:
    payload = bytearray(ENCAPSULATION + header)
    write(message, payload)
    return payload


def _header(payload: bytes) -> tuple[int, int]:
    """Client and number at the begin of a payload; Fast DDS sends none."""
    if len(payload) < _BODY:
        raise CdrError(f"{len(payload)} bytes do not hold the header of rmw_cyclonedds")
    client, number = _HEADER.unpack_from(payload, len(ENCAPSULATION))
    return client, number


class _Ports:
    """Writer and reader of a client or server, joined by an identifier in their user data."""

    def __init__(
        self, session: Session, service: str, name: str, profile: QoSProfile, *, is_server: bool
    ) -> None:
        extra = f"{'serviceid' if is_server else 'clientid'}={session.new_service_id()};"
        request = (f"rq{name}Request", f"{service}_Request", profile, extra)
        reply = (f"rr{name}Reply", f"{service}_Response", profile, extra)
        self.writer: Writer = session.writer(*(reply if is_server else request))
        try:
            self.reader: Reader = session.reader(*(request if is_server else reply))
        except BaseException:
            self.writer.close()
            raise

    def usable(self) -> Self:
        """Return these; ``InvalidHandle`` once they are closed."""
        self.reader.usable()
        return self

    def close(self) -> None:
        """Delete the entities. Again is fine."""
        self.reader.close()
        self.writer.close()


class ClientPorts(_Ports):
    """Sends requests and takes replies.

    Parameters
    ----------
    session : Session
    service : str
        ``rcl_interfaces/srv/SetParameters``.
    name : str
        Full name of the service.
    profile : QoSProfile
    """

    def __init__(self, session: Session, service: str, name: str, profile: QoSProfile) -> None:
        super().__init__(session, service, name, profile, is_server=False)
        self._identity = cyclone.instance_handle(self.writer.ref)
        self._write = codec(f"{service}_Request").write
        self._read = codec(f"{service}_Response").read
        self._sequence_number = 0

    def send(self, request: Any, before_writing: Callable[[int], None]) -> None:
        """Send a request.

        Parameters
        ----------
        request : message
        before_writing : callable
            Gets the sequence number before a reply can come.
        """
        self._sequence_number += 1
        number = self._sequence_number
        payload = _payload(self._write, _HEADER.pack(self._identity, number), request)
        before_writing(number)
        self.writer.write(payload)

    def take(self) -> tuple[int, Any] | None:
        """Sequence number and reply; None if there is none or it is for another client."""
        taken = self.reader.take_decoded(self._decode)
        return None if taken is None else taken[0]

    def _decode(self, payload: bytes) -> tuple[int, Any] | None:
        client, number = _header(payload)
        return (number, self._read(payload, _BODY)) if client == self._identity else None

    def server_is_matched(self) -> bool:
        """Whether requests reach a server and its replies come back."""
        return bool(self.writer.matched_readers()) and bool(self.reader.matched_writers())


class ServerPorts(_Ports):
    """Takes requests and sends replies. The parameters are those of :class:`ClientPorts`."""

    def __init__(self, session: Session, service: str, name: str, profile: QoSProfile) -> None:
        super().__init__(session, service, name, profile, is_server=True)
        self._read = codec(f"{service}_Request").read
        self._write = codec(f"{service}_Response").write
        self._reachable: set[int] = set()

    def take(self) -> tuple[RequestHeader, Any] | None:
        """Header and request; None if there is none."""
        taken = self.reader.take_decoded(self._decode)
        if taken is None:
            return None
        (client, number, request), info = taken
        return RequestHeader(client, number, info.publication_handle), request

    def _decode(self, payload: bytes) -> tuple[int, int, Any]:
        return *_header(payload), self._read(payload, _BODY)

    def send(self, header: RequestHeader, response: Any) -> None:
        """Send a reply.

        The request may have come before discovery told us of the client's reply reader; then the
        reply waits up to 100 ms for it, as in rmw_cyclonedds.
        """
        payload = _payload(self._write, _HEADER.pack(*header[:2]), response)
        if header.writer not in self._reachable:
            deadline = Deadline(_MATCH_TIMEOUT_S)
            while not self._can_reach(header.writer) and not deadline.is_over():
                time.sleep(0.001)
            self._reachable.add(header.writer)
        self.writer.write(payload)

    def _can_reach(self, request_writer: int) -> bool:
        wanted = _client_id(ddspy_get_matched_publication_data, self.reader.ref, request_writer)
        if wanted is None:
            return True  # the client is gone or tells no identifier: waiting would not help
        return any(
            _client_id(ddspy_get_matched_subscription_data, self.writer.ref, reader) == wanted
            for reader in self.writer.matched_readers()
        )


def _client_id(lookup: Callable[..., Any], entity: int, peer: int) -> str | None:
    """``clientid`` in the user data of a matched peer."""
    from cyclonedds.builtin_types import cqos_to_qos, endpoint_constructor
    from cyclonedds.core import Policy

    with HeldSignals():
        data = lookup(entity, peer, endpoint_constructor, cqos_to_qos)
    if data is None or isinstance(data, int):
        return None
    policy = data.qos[Policy.Userdata] if Policy.Userdata in data.qos else None  # noqa: SIM401
    for item in (policy.data.decode(errors="replace") if policy else "").split(";"):
        key, _, value = item.partition("=")
        if key == "clientid":
            return value
    return None
