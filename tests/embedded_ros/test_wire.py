"""What goes over the network, seen by plain Cyclone DDS with types declared independently."""

import re
import struct
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest
from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import array, float64, int64, sequence, uint8, uint64
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from embedded_ros.dds_qos import to_dds
from embedded_ros.domain import domain_configuration
from embedded_ros.errors import RCLError
from embedded_ros.service_calls import ClientPorts
from rcl_interfaces.srv import GetParameters, SetParameters
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_default
from rclpy.serialization import serialize_message
from rclpy.wait_for_message import wait_for_message
from std_msgs.msg import Float64, String
from std_srvs.srv import SetBool


@dataclass
class Gid(IdlStruct, typename="rmw_dds_common::msg::dds_::Gid_"):
    """A GUID, as rmw_dds_common defines it."""

    data: array[uint8, 16]


@dataclass
class NodeEntities(IdlStruct, typename="rmw_dds_common::msg::dds_::NodeEntitiesInfo_"):
    """A node and its endpoints."""

    node_namespace: str
    node_name: str
    reader_gid_seq: sequence[Gid]
    writer_gid_seq: sequence[Gid]


@dataclass
class Info(IdlStruct, typename="rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_"):
    """A participant and its nodes."""

    gid: Gid
    node_entities_info_seq: sequence[NodeEntities]


@dataclass
class Float64_(IdlStruct, typename="std_msgs::msg::dds_::Float64_"):  # noqa: N801
    """A number."""

    data: float64


@dataclass
class SetBoolRequest(IdlStruct, typename="std_srvs::srv::dds_::SetBool_Request_"):
    """A request with the header of rmw_cyclonedds."""

    client: uint64
    number: int64
    data: bool


def test_the_request_of_a_service_begins_with_client_and_number(ros):
    node = ros.create(Node, "n")
    sent = []
    client = node.create_client(SetParameters, "p")
    client._ports.writer.write = sent.append
    request = SetParameters.Request(parameters=[Parameter("a", value=1.5).to_parameter_msg()])
    client.call_async(request)
    client.call_async(request)
    body = serialize_message(request)
    handle = client._ports._identity
    assert bytes(sent[0]) == body[:4] + struct.pack("<Qq", handle, 1) + body[4:]
    assert bytes(sent[1])[4:20] == struct.pack("<Qq", handle, 2)
    assert body[4:16].hex() == "01000000" + "02000000" + "6100" + "0300"


def test_topic_type_and_user_data_of_endpoints(ros):
    node = ros.create(Node, "n")
    node.create_publisher(Float64, "x", 10)
    node.create_service(SetBool, "s", print)
    node.create_client(SetBool, "c")
    found = {
        endpoint.topic: (endpoint.dds_type, endpoint.qos[Policy.Userdata].data.decode())
        for endpoint in node.context.handle.graph.writers(with_qos=True)
    }
    dds_type, data = found["rt/x"]
    assert dds_type == "std_msgs::msg::dds_::Float64_"
    assert data.startswith("typehash=RIHS01_705ba9c3d1a09df43737eb67095534de36fd426c0587779bda2bc5")
    dds_type, data = found["rr/sReply"]
    assert dds_type == "std_srvs::srv::dds_::SetBool_Response_"
    assert data.startswith("serviceid=")
    assert ";typehash=RIHS01_" in data
    dds_type, data = found["rq/cRequest"]
    assert dds_type == "std_srvs::srv::dds_::SetBool_Request_"
    assert data.startswith("clientid=")


def test_ros_discovery_info_is_what_rmw_reads(ros):
    node = ros.create(Node, "n")
    publisher = node.create_publisher(Float64, "x", 10)
    raw = DomainParticipant(ros.context.get_domain_id())
    qos = Qos(
        Policy.Reliability.Reliable(0), Policy.Durability.TransientLocal, Policy.History.KeepAll
    )
    # Both ends describe their types, so these are matched by structure: read the bytes' twin.
    from embedded_ros.endpoints import _carrier

    carrier = _carrier("rmw_dds_common/msg/ParticipantEntitiesInfo")
    reader = DataReader(raw, Topic(raw, "ros_discovery_info", carrier), qos=qos)
    from cyclonedds._clayer import ddspy_take

    samples = []
    ros.spin_until(lambda: samples.extend(ddspy_take(reader._ref, 0x7F, 10)) or samples)
    info = Info.deserialize(samples[-1][0])
    assert bytes(info.gid.data) == node.context.handle.guid
    (entry,) = [item for item in info.node_entities_info_seq if item.node_name == "n"]
    assert entry.node_namespace == "/"
    guids = [bytes(gid.data) for gid in entry.writer_gid_seq]
    assert publisher._writer.guid in guids
    assert len(entry.reader_gid_seq) == 7  # the services


def test_payloads_are_those_of_the_true_type():
    assert (
        Float64_(data=1.5).serialize(use_version_2=False)[4:]
        == serialize_message(Float64(data=1.5))[4:]
    )
    framed = SetBoolRequest(client=7, number=8, data=True).serialize(use_version_2=False)
    body = serialize_message(SetBool.Request(data=True))
    assert framed[4:21] == struct.pack("<Qq", 7, 8) + body[4:5]


def test_replies_to_other_clients_are_ignored(ros):
    node = ros.create(Node, "n")
    ports = ClientPorts(node.context.handle, "std_srvs/srv/SetBool", "/s", qos_profile_default)
    from embedded_ros.endpoints import Writer

    writer = Writer(
        node.context.handle.participant,
        node.context.handle.publisher,
        "rr/sReply",
        "std_srvs/srv/SetBool_Response",
        to_dds(qos_profile_default, ""),
    )
    body = serialize_message(SetBool.Response(success=True))
    for client in (ports._identity + 1, ports._identity):
        writer.write(body[:4] + struct.pack("<Qq", client, 5) + body[4:])
    assert ports.take() is None
    assert ports.take() == (5, SetBool.Response(success=True))
    for each in (ports, writer):
        each.close()


def test_what_is_no_message_is_dropped_with_a_warning_a_second(ros, capsys):
    node = ros.create(Node, "n")
    received = []
    node.create_subscription(String, "s", received.append, 10)
    publisher = node.create_publisher(String, "s", 10)
    for payload in ("00010000 ff000000 61620000", "00000000 00000002 61000000"):
        publisher.publish(bytes.fromhex(payload))
    publisher.publish(String(data="a"))
    ros.spin_until(lambda: received)
    assert received == [String(data="a")]
    warning = capsys.readouterr().err
    assert warning.count("\n") == 1
    assert "WARN" in warning
    assert "what came on rt/s is dropped: " in warning
    assert "not a std_msgs/msg/String" in warning


def test_a_wait_for_a_message_goes_on_after_what_is_none(ros):
    node = ros.create(Node, "n")
    latched = QoSProfile(depth=2, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    publisher = node.create_publisher(String, "s", latched)
    publisher.publish(bytes.fromhex("00010000 ff000000 61620000"))
    publisher.publish(String(data="a"))
    found = wait_for_message(String, node, "/s", qos_profile=latched, time_to_wait=20)
    assert found == (True, String(data="a"))


@pytest.mark.parametrize(
    ("service", "request_"),
    [
        (SetBool, SetBool.Request(data=True)),
        (GetParameters, GetParameters.Request(names=["use_sim_time", "a" * 40, "b" * 100])),
    ],
    ids=["shorter than the header", "longer"],
)
def test_a_request_of_fast_dds_is_dropped_and_the_service_goes_on(ros, capsys, service, request_):
    node = ros.create(Node, "n")
    node.create_service(service, "s", lambda _request, response: response)
    client = node.create_client(service, "s")
    # Fast DDS tells who asks beside the payload, not in its first sixteen bytes.
    client._ports.writer.write(serialize_message(request_))
    assert ros.result(client.call_async(request_)) == service.Response()
    assert "what came on rq/sRequest is dropped: " in capsys.readouterr().err


def test_a_reply_that_is_none_is_dropped_and_the_client_goes_on(ros, capsys):
    node = ros.create(Node, "n")
    client = node.create_client(GetParameters, "s")
    server = node.create_service(GetParameters, "s", lambda _request, response: response)
    header = struct.pack("<Qq", client._ports._identity, 1)
    server._ports.writer.write(b"\0\1\0\0" + header[:8])
    server._ports.writer.write(b"\0\1\0\0" + header + b"\xff\0\0\0")
    assert ros.result(client.call_async(GetParameters.Request())) == GetParameters.Response()
    assert "what came on rr/sReply is dropped: " in capsys.readouterr().err


def test_discovery_stays_on_loopback_unless_told_otherwise():
    local = domain_configuration(None, None)
    assert local == domain_configuration("localhost", "")
    assert 'name="lo" multicast="false"' in local
    assert '<Peer address="127.0.0.1" PruneDelay="inf"/>' in local
    assert "<MaxAutoParticipantIndex>119<" in local
    assert "<ReceiveBufferSize>256KiB<" in local
    assert "<Peer" not in domain_configuration("OFF", None)
    assert domain_configuration("SUBNET", None) == ""
    assert '<Peer address="10.0.0.1"/>' in domain_configuration("SUBNET", "10.0.0.1")
    assert domain_configuration("SYSTEM_DEFAULT", "10.0.0.1") == ""
    with pytest.raises(RCLError, match="'EVERYWHERE'"):
        domain_configuration("EVERYWHERE", None)


PARTICIPANTS = """
import sys, time
from cyclonedds.builtin import BuiltinDataReader, BuiltinTopicDcpsParticipant
from cyclonedds.domain import Domain, DomainParticipant
domain = Domain(int(sys.argv[1]), sys.argv[2])
participant = DomainParticipant(int(sys.argv[1]))
reader = BuiltinDataReader(participant, BuiltinTopicDcpsParticipant)
end = time.monotonic() + float(sys.argv[3])
while len(reader.read(N=10)) < 2 and time.monotonic() < end:
    time.sleep(0.01)
print(len(reader.read(N=10)))
"""


def participants_seen(ros, configuration, deadline):
    """Find how many participants, itself included, a process with a configuration finds."""
    domain_id = str(ros.context.get_domain_id())
    command = [sys.executable, "-c", PARTICIPANTS, domain_id, configuration, str(deadline)]
    result = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)
    return int(result.stdout)


def test_who_only_listens_on_loopback_finds_a_node_that_runs_already(ros):
    ros.create(Node, "n")
    ros.spin_for(2.0)  # a new participant announces itself to everybody a few times
    # rmw_fastrtps in the range SUBNET tells nobody on loopback of itself, either.
    silent = re.sub(
        "<Peers>.*</Peers>", '<Peers AddLocalhost="false"/>', domain_configuration("", "")
    )
    assert participants_seen(ros, silent, 15) == 2


def test_a_process_without_discovery_finds_nobody(ros):
    ros.create(Node, "n")
    assert participants_seen(ros, domain_configuration(None, None), 15) == 2
    assert participants_seen(ros, domain_configuration("OFF", None), 3) == 1


def test_no_multicast_group_is_joined(ros):
    ros.create(Node, "n")
    # 239.255.0.1, the group of DDS discovery, in the kernel's byte order.
    assert "0100FFEF" not in Path("/proc/self/net/igmp").read_text()
