"""The graph: nodes, topics, services and their endpoints, here and in other processes."""

import subprocess
import sys

import pytest
from rclpy._rclpy_pybind11 import NodeNameNonExistentError
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    QoSProfile,
    ReliabilityPolicy,
)
from rclpy.topic_endpoint_info import TopicEndpointTypeEnum
from std_msgs.msg import Float64
from std_srvs.srv import Trigger


@pytest.fixture
def node(ros):
    node = ros.create(Node, "n")
    node.create_publisher(Float64, "out", 10)
    node.create_subscription(Float64, "in", print, 10)
    node.create_client(Trigger, "asks")
    node.create_service(Trigger, "serves", print)
    return node


def test_names_and_types(node):
    assert ("/out", ["std_msgs/msg/Float64"]) in node.get_topic_names_and_types()
    assert ("/serves", ["std_srvs/srv/Trigger"]) in node.get_service_names_and_types()
    raw = dict(node.get_topic_names_and_types(no_demangle=True))
    assert raw["rq/servesRequest"] == ["std_srvs::srv::dds_::Trigger_Request_"]
    assert "ros_discovery_info" in raw


def test_a_node_owns_what_it_made(node):
    published = dict(node.get_publisher_names_and_types_by_node("n", "/"))
    assert published.keys() == {"/out", "/parameter_events", "/rosout"}
    assert dict(node.get_subscriber_names_and_types_by_node("n", "/")).keys() == {"/in"}
    assert dict(node.get_client_names_and_types_by_node("n", "/")) == {
        "/asks": ["std_srvs/srv/Trigger"]
    }
    services = dict(node.get_service_names_and_types_by_node("n", "/"))
    assert services["/serves"] == ["std_srvs/srv/Trigger"]
    assert "/n/set_parameters_atomically" in services
    assert "/n/get_type_description" in services
    with pytest.raises(NodeNameNonExistentError):
        node.get_publisher_names_and_types_by_node("nobody", "/")


def test_counts(node):
    assert node.count_publishers("out") == 1
    assert node.count_subscribers("out") == 0
    assert node.count_subscribers("/in") == 1
    assert node.count_services("serves") == 1
    assert node.count_clients("asks") == 1


def test_an_endpoint_tells_node_type_hash_and_qos(node):
    profile = QoSProfile(
        depth=7,
        reliability=ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL,
        deadline=Duration(seconds=1),
        lifespan=Duration(seconds=2),
        liveliness=LivelinessPolicy.MANUAL_BY_TOPIC,
        liveliness_lease_duration=Duration(seconds=3),
    )
    node.create_publisher(Float64, "special", profile)
    (info,) = node.get_publishers_info_by_topic("special")
    assert (info.node_name, info.node_namespace) == ("n", "/")
    assert info.topic_type == "std_msgs/msg/Float64"
    assert str(info.topic_type_hash).startswith("RIHS01_705ba9c3d1a09df43737eb67095534de36f")
    assert info.endpoint_type is TopicEndpointTypeEnum.PUBLISHER
    assert len(info.endpoint_gid) == 16
    assert info.qos_profile == profile
    assert node.get_subscriptions_info_by_topic("special") == []


def test_history_is_told_for_keep_all(node):
    node.create_publisher(Float64, "all", QoSProfile(history=HistoryPolicy.KEEP_ALL))
    (info,) = node.get_publishers_info_by_topic("all")
    assert info.qos_profile.history is HistoryPolicy.KEEP_ALL


def test_what_is_destroyed_disappears(ros, node):
    other = ros.create(
        Node,
        "other",
    )
    publisher = other.create_publisher(Float64, "out", 10)
    assert node.count_publishers("out") == 2
    other.destroy_publisher(publisher)
    assert node.count_publishers("out") == 1
    other.destroy_node()
    assert node.get_node_names() == ["n"]


PEER = """
import sys, rclpy
from rclpy.node import Node
from std_msgs.msg import Float64
rclpy.init(args=[])
node = Node("peer", namespace="/far")
node.create_publisher(Float64, "out", 10)
print("ready", flush=True)
sys.stdin.read()
"""


def test_a_node_of_another_process_appears_and_disappears(ros, node):
    with subprocess.Popen(
        [sys.executable, "-c", PEER], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as peer:
        peer.stdout.readline()
        assert node.wait_for_node("/far/peer", 5)
        assert ("peer", "/far") in node.get_node_names_and_namespaces()
        ros.spin_until(lambda: node.get_publishers_info_by_topic("/far/out"))
        (info,) = node.get_publishers_info_by_topic("/far/out")
        assert (info.node_name, info.node_namespace) == ("peer", "/far")
        peer.stdin.close()
        assert peer.wait(10) == 0
    ros.spin_until(lambda: "peer" not in node.get_node_names(), 5)


def test_a_bare_dds_writer_belongs_to_no_node(node):
    from cyclonedds.domain import DomainParticipant
    from cyclonedds.pub import DataWriter
    from cyclonedds.topic import Topic
    from embedded_ros.endpoints import _carrier

    participant = DomainParticipant(node.context.get_domain_id())
    writer = DataWriter(
        participant, Topic(participant, "rt/bare", _carrier("std_msgs/msg/Float64"))
    )
    for _ in range(50):
        infos = node.get_publishers_info_by_topic("bare")
        if infos:
            break
        node.wait_for_node("nobody", 0.1)
    assert infos[0].node_name == "_CREATED_BY_BARE_DDS_APP_"
    assert str(infos[0].topic_type_hash) == "INVALID"
    del writer
