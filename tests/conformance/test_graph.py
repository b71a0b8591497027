"""The graph: nodes, topics, services and their endpoints, here and in other processes.

What was just made need not be in the graph yet, even in the same process: these tests wait for it.
"""

import subprocess
import sys

import pytest
from rclpy._rclpy_pybind11 import NodeNameNonExistentError
from rclpy.duration import Duration
from rclpy.exceptions import InvalidServiceNameException, InvalidTopicNameException
from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    QoSProfile,
    ReliabilityPolicy,
)
from rclpy.topic_endpoint_info import TopicEndpointInfo, TopicEndpointTypeEnum
from rclpy.type_hash import TypeHash
from std_msgs.msg import Float64
from std_srvs.srv import Trigger


@pytest.fixture
def node(ros):
    node = ros.node("n")
    node.create_publisher(Float64, "out", 10)
    node.create_subscription(Float64, "in", print, 10)
    node.create_client(Trigger, "asks")
    node.create_service(Trigger, "serves", print)

    def is_complete():
        queries = (
            node.get_publisher_names_and_types_by_node,
            node.get_subscriber_names_and_types_by_node,
            node.get_client_names_and_types_by_node,
            node.get_service_names_and_types_by_node,
        )
        found = {name for query in queries for name, _ in query("n", "/")}
        return {"/out", "/in", "/asks", "/serves"} <= found

    ros.wait_until(is_complete)
    return node


def one_info(ros, query, topic):
    """Wait for the one endpoint of a topic."""
    ros.wait_until(lambda: query(topic))
    (info,) = query(topic)
    return info


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


def test_an_endpoint_tells_node_type_hash_and_qos(ros, node):
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
    info = one_info(ros, node.get_publishers_info_by_topic, "special")
    assert (info.node_name, info.node_namespace) == ("n", "/")
    assert info.topic_type == "std_msgs/msg/Float64"
    assert str(info.topic_type_hash).startswith("RIHS01_705ba9c3d1a09df43737eb67095534de36f")
    assert info.endpoint_type is TopicEndpointTypeEnum.PUBLISHER
    assert len(info.endpoint_gid) == 16
    assert info.qos_profile == profile
    assert node.get_subscriptions_info_by_topic("special") == []


def test_history_is_told_for_keep_all(ros, node):
    node.create_publisher(Float64, "all", QoSProfile(history=HistoryPolicy.KEEP_ALL))
    info = one_info(ros, node.get_publishers_info_by_topic, "all")
    assert info.qos_profile.history is HistoryPolicy.KEEP_ALL


def test_what_is_destroyed_disappears(ros, node):
    other = ros.node("other")
    publisher = other.create_publisher(Float64, "out", 10)
    ros.wait_until(lambda: node.count_publishers("out") == 2)
    other.destroy_publisher(publisher)
    ros.wait_until(lambda: node.count_publishers("out") == 1)
    other.destroy_node()
    ros.wait_until(lambda: node.get_node_names() == ["n"])


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
        assert node.wait_for_node("/far/peer", 20.0)
        assert ("peer", "/far") in node.get_node_names_and_namespaces()
        assert ("peer", "/far", "/") in node.get_node_names_and_namespaces_with_enclaves()
        info = one_info(ros, node.get_publishers_info_by_topic, "/far/out")
        assert (info.node_name, info.node_namespace) == ("peer", "/far")
        peer.stdin.close()
        assert peer.wait(20) == 0
    ros.spin_until(lambda: "peer" not in node.get_node_names())


def test_nodes_are_listed_with_their_namespaces(ros, node):
    ros.node("n", namespace="/far")
    ros.wait_until(lambda: len(node.get_node_names()) == 2)
    assert node.get_node_names() == ["n", "n"]
    assert sorted(node.get_node_names_and_namespaces()) == [("n", "/"), ("n", "/far")]
    assert sorted(node.get_fully_qualified_node_names()) == ["/far/n", "/n"]


def test_nodes_are_waited_for(ros, node):
    assert not node.wait_for_node("late", 0.05)
    ros.node("late", namespace="/far")
    assert node.wait_for_node("/far/late", 20.0)
    assert node.wait_for_node("far/late", 20.0)


def test_a_nodes_entities_are_found_by_its_full_name(ros, node):
    other = ros.node("n", namespace="/far")
    other.create_publisher(Float64, "elsewhere", 1)

    def published(namespace):
        return dict(node.get_publisher_names_and_types_by_node("n", namespace))

    ros.wait_until(lambda: "/far/elsewhere" in published("/far"))
    assert "/far/elsewhere" not in published("/")


@pytest.mark.parametrize(
    ("query", "error"),
    [
        ("count_publishers", InvalidTopicNameException),
        ("count_subscribers", InvalidTopicNameException),
        ("count_clients", InvalidServiceNameException),
        ("count_services", InvalidServiceNameException),
        ("get_publishers_info_by_topic", InvalidTopicNameException),
        ("get_subscriptions_info_by_topic", InvalidTopicNameException),
    ],
)
def test_names_are_checked(node, query, error):
    with pytest.raises(error):
        getattr(node, query)("a//b")
    with pytest.raises(ValueError, match="topic name 'a b' is invalid"):
        getattr(node, query)("a b")


def test_a_subscription_has_an_endpoint(ros, node):
    info = one_info(ros, node.get_subscriptions_info_by_topic, "in")
    assert info.endpoint_type == TopicEndpointTypeEnum.SUBSCRIPTION
    assert isinstance(info, TopicEndpointInfo)
    assert isinstance(info.topic_type_hash, TypeHash)
    text = str(info)
    for line in ("Node name: n", "Topic type: std_msgs/msg/Float64", "Endpoint type: SUBSCRIPTION"):
        assert line in text


def test_endpoints_are_found_by_their_dds_names(ros, node):
    info = one_info(
        ros, lambda topic: node.get_publishers_info_by_topic(topic, no_mangle=True), "rt/out"
    )
    assert info.topic_type == "std_msgs::msg::dds_::Float64_"


def test_a_topic_without_the_prefix_of_ros(ros, node):
    profile = QoSProfile(depth=1, avoid_ros_namespace_conventions=True)
    publisher = node.create_publisher(Float64, "/bare", profile)
    ros.wait_until(lambda: "/bare" in dict(node.get_topic_names_and_types(no_demangle=True)))
    assert publisher.topic_name == "/bare"
    assert "/bare" not in dict(node.get_topic_names_and_types())


def test_one_topic_may_have_two_types(ros, node):
    from std_msgs.msg import String

    node.create_publisher(String, "out", 1)
    both = ["std_msgs/msg/Float64", "std_msgs/msg/String"]
    ros.wait_until(lambda: dict(node.get_topic_names_and_types())["/out"] == both)
