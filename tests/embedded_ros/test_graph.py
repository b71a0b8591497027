"""The graph, where other things than ROS take part in it or a process dies."""

import os
import signal
import subprocess
import sys
import time

import pytest
from rclpy.node import Node
from std_msgs.msg import Float64
from std_srvs.srv import Trigger


def test_a_bare_dds_writer_belongs_to_no_node(ros):
    from cyclonedds.domain import DomainParticipant
    from cyclonedds.pub import DataWriter
    from cyclonedds.topic import Topic
    from embedded_ros.endpoints import _carrier

    node = ros.create(Node, "n")
    participant = DomainParticipant(node.context.get_domain_id())
    writer = DataWriter(
        participant, Topic(participant, "rt/bare", _carrier("std_msgs/msg/Float64"))
    )
    ros.spin_until(lambda: node.get_publishers_info_by_topic("bare"))
    (info,) = node.get_publishers_info_by_topic("bare")
    assert info.node_name == "_CREATED_BY_BARE_DDS_APP_"
    assert str(info.topic_type_hash) == "INVALID"
    del writer


PEER = """
import rclpy
from rclpy.node import Node
from std_msgs.msg import Float64
from std_srvs.srv import Trigger
rclpy.init(args=[])
node = Node("peer")
publisher = node.create_publisher(Float64, "from_peer", 10)
node.create_subscription(Float64, "to_peer", lambda message: None, 10)
node.create_service(Trigger, "of_peer", lambda request, response: response)
node.create_timer(0.001, lambda: publisher.publish(Float64()))
rclpy.spin(node)
"""

#: After this lease [s], which a participant announces, Cyclone DDS gives it up. By default 10.
LEASE = 3.0


@pytest.fixture
def peer():
    lease = (
        "<CycloneDDS><Domain><Discovery>"
        f"<LeaseDuration>{LEASE} s</LeaseDuration></Discovery></Domain></CycloneDDS>"
    )
    uri = ",".join(filter(None, [os.environ.get("CYCLONEDDS_URI"), lease]))
    environment = os.environ | {"CYCLONEDDS_URI": uri}
    with subprocess.Popen([sys.executable, "-c", PEER], env=environment) as process:
        yield process
        process.kill()


def test_a_peer_that_is_killed_disappears_and_nothing_hangs(ros, peer):
    node = ros.create(Node, "n")
    received = []
    node.create_subscription(Float64, "from_peer", received.append, 10)
    publisher = node.create_publisher(Float64, "to_peer", 10)
    client = node.create_client(Trigger, "of_peer")
    ros.spin_until(lambda: received and publisher.get_subscription_count())
    assert client.wait_for_service(20.0)
    assert ros.result(client.call_async(Trigger.Request())) is not None
    peer.send_signal(signal.SIGKILL)
    peer.wait(20)
    # Nobody knows yet: what is sent meanwhile must not block.
    start = time.monotonic()
    for _ in range(100):
        publisher.publish(Float64())
    pending = client.call_async(Trigger.Request())
    ros.executor.spin_once(timeout_sec=0.01)
    assert time.monotonic() - start < LEASE
    ros.spin_until(lambda: node.get_node_names() == ["n"], LEASE + 20)
    ros.spin_until(lambda: publisher.get_subscription_count() == 0)
    assert not client.service_is_ready()
    assert "/from_peer" in dict(node.get_topic_names_and_types())
    assert node.count_publishers("from_peer") == 0
    assert not pending.done()
    client.remove_pending_request(pending)
