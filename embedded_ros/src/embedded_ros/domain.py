"""DDS domains and participants: how far discovery reaches, and who lives in a domain.

``ROS_AUTOMATIC_DISCOVERY_RANGE`` is read as in Jazzy, except that unset means ``LOCALHOST`` on the
loopback interface alone, without multicast. What ``CYCLONEDDS_URI`` holds comes after our
configuration and so wins.
"""

import contextlib
import os
import re
import threading
from dataclasses import dataclass, field
from pathlib import Path

from cyclonedds.core import DDSException, Policy, Qos
from cyclonedds.domain import Domain, DomainParticipant

from embedded_ros import cyclone
from embedded_ros.errors import RCLError

__all__ = ["close_participant", "create_participant", "domain_configuration", "domain_id_from"]

# The ports of a domain leave room for participants 0 to 119, so that is how many processes fit.
# rmw_cyclonedds searches 0 to 32 only; we reach those by asking all 120 ports ourselves.
_LAST_PARTICIPANT_INDEX = 119
_LAST_DOMAIN_ID = 232

_LOOPBACK = (
    "<General>"
    '<Interfaces><NetworkInterface name="{interface}" multicast="false"/></Interfaces>'
    "<AllowMulticast>false</AllowMulticast>"
    "</General>"
    "<Discovery>"
    "<ParticipantIndex>auto</ParticipantIndex>"
    f"<MaxAutoParticipantIndex>{_LAST_PARTICIPANT_INDEX}</MaxAutoParticipantIndex>"
    "<SPDPInterval>2s</SPDPInterval>"
    "{reach}"
    "</Discovery>"
    # Each thread that receives fills such a buffer slowly and then takes a new one: what a process
    # holds grows for ten minutes by Cyclone's megabyte, and looks like a leak.
    "<Sizing><ReceiveBufferSize>256KiB</ReceiveBufferSize></Sizing>"
)

# rmw_fastrtps in its default range, SUBNET, looks for nobody on loopback. It finds us if we go on
# calling: 60 packets a second, 0.05 % of a core. Cyclone would stop after half a minute.
_THIS_MACHINE = '<Peer address="127.0.0.1" PruneDelay="inf"/>'


@dataclass
class _OpenDomain:
    """A Cyclone domain, kept while a participant needs it: dropping it kills them."""

    domain: Domain | None
    participants: set[int] = field(default_factory=set)


_lock = threading.Lock()
_domains: dict[int, _OpenDomain] = {}


def domain_id_from(environment: str | None) -> int:
    """Domain id from the value of ``ROS_DOMAIN_ID``.

    Raises
    ------
    RCLError
        If it is not a number or out of range.
    """
    if not environment:
        return 0
    try:
        number = int(environment, 0)
    except ValueError:
        raise RCLError(
            f"failed to initialize rcl: ROS_DOMAIN_ID is not an integral number: {environment!r}"
        ) from None
    if not 0 <= number <= _LAST_DOMAIN_ID:
        raise RCLError(
            f"failed to initialize rcl: ROS_DOMAIN_ID is out of range: "
            f"{number} is not in [0, {_LAST_DOMAIN_ID}]"
        )
    return number


def domain_configuration(discovery_range: str | None, static_peers: str | None) -> str:
    """Cyclone configuration (XML) for a discovery range.

    Parameters
    ----------
    discovery_range : str or None
        Value of ``ROS_AUTOMATIC_DISCOVERY_RANGE``.
    static_peers : str or None
        Value of ``ROS_STATIC_PEERS``: hosts separated by semicolons.

    Returns
    -------
    str
        Empty if the configuration is left to ``CYCLONEDDS_URI``.
    """
    chosen = (discovery_range or "LOCALHOST").upper()
    peers = [peer for peer in (static_peers or "").split(";") if peer]
    match chosen:
        case "SYSTEM_DEFAULT":
            return ""
        case "SUBNET":
            body = f"<Discovery>{_peers(peers)}</Discovery>" if peers else ""
        case "OFF":
            # Without peers Cyclone takes this machine for one. The tag is that of rmw_cyclonedds.
            tag = f"<Tag>ros_discovery_off_{os.getpid()}</Tag>"
            body = _LOOPBACK.format(interface="lo", reach=tag)
        case "LOCALHOST":
            # Hosts of their own need an interface of their own: loopback reaches none of them.
            body = _LOOPBACK.format(interface="lo", reach=_peers(peers, _THIS_MACHINE))
            if peers:
                body = body.replace('name="lo"', 'autodetermine="true"')
        case _:
            raise RCLError(
                "failed to initialize rcl: ROS_AUTOMATIC_DISCOVERY_RANGE is "
                f"{discovery_range!r}, not SUBNET, LOCALHOST, OFF or SYSTEM_DEFAULT"
            )
    return f'<CycloneDDS><Domain id="any">{body}</Domain></CycloneDDS>' if body else ""


def _peers(hosts: list[str], first: str = "") -> str:
    return f"<Peers>{first}" + "".join(f'<Peer address="{host}"/>' for host in hosts) + "</Peers>"


def create_participant(domain_id: int, enclave: str) -> DomainParticipant:
    """Create a participant; the first one of a domain opens the domain."""
    environment = os.environ
    parts = [
        domain_configuration(
            environment.get("ROS_AUTOMATIC_DISCOVERY_RANGE"), environment.get("ROS_STATIC_PEERS")
        ),
        environment.get("CYCLONEDDS_URI", ""),
    ]
    if _selects_interfaces(parts[1]):
        # Cyclone takes no interface twice, and what the environment says comes first.
        parts[0] = re.sub("<Interfaces>.*?</Interfaces>", "", parts[0])
    configuration = ",".join(part for part in parts if part)
    with _lock:
        if domain_id not in _domains:
            _domains[domain_id] = _OpenDomain(_open_domain(domain_id, configuration))
        try:
            participant = DomainParticipant(
                domain_id, qos=Qos(Policy.Userdata(f"enclave={enclave};".encode()))
            )
        except DDSException as error:
            _close_if_empty(domain_id)
            raise RCLError(
                f"failed to initialize rcl: no DDS participant in domain {domain_id}: {error} "
                f"(configuration: {configuration or 'none'})"
            ) from error
        _domains[domain_id].participants.add(participant._ref)
    return participant


def _selects_interfaces(uri: str) -> bool:
    """Tell whether a value of ``CYCLONEDDS_URI``, or a file that it names, chooses interfaces."""
    texts = [uri]
    for part in uri.split(","):
        if part.startswith("file://"):
            with contextlib.suppress(OSError):  # Cyclone complains of it
                texts.append(Path(part.removeprefix("file://")).read_text(encoding="utf-8"))
    return any("<networkinterface" in text.lower() for text in texts)


def close_participant(domain_id: int, participant: int) -> None:
    """Delete a participant with all it holds; the last one closes the domain and its threads."""
    with _lock:
        cyclone.delete(participant)
        if domain_id in _domains:
            _domains[domain_id].participants.discard(participant)
            _close_if_empty(domain_id)


def _open_domain(domain_id: int, configuration: str) -> Domain | None:
    try:
        return Domain(domain_id, configuration)
    except DDSException as error:
        if error.code == DDSException.DDS_RETCODE_PRECONDITION_NOT_MET:
            return None  # somebody else in this process has opened the domain
        raise RCLError(
            f"failed to initialize rcl: Cyclone DDS refuses its configuration: {error} "
            f"(configuration: {configuration})"
        ) from error


def _close_if_empty(domain_id: int) -> None:
    opened = _domains[domain_id]
    if not opened.participants:
        del _domains[domain_id]
        if opened.domain is not None:
            cyclone.delete(opened.domain._ref)
