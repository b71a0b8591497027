"""What the conformance tests need of a world with rclpy: a domain of their own, on loopback."""

import gc
import os
import time
from collections.abc import Callable, Iterator
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from typing import Any

import pytest

_spec = spec_from_file_location("ros_domain", Path(__file__).with_name("ros_domain.py"))
_ros_domain = module_from_spec(_spec)
_spec.loader.exec_module(_ros_domain)

# Before rclpy is initialized anywhere.
os.environ["ROS_DOMAIN_ID"] = str(_ros_domain.claim_domain())
os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"

LOOPBACK = (
    '<CycloneDDS><Domain id="any"><General><Interfaces><NetworkInterface name="lo" '
    'multicast="false"/></Interfaces><AllowMulticast>false</AllowMulticast></General><Discovery>'
    "<ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>99"
    '</MaxAutoParticipantIndex><Peers><Peer address="127.0.0.1"/></Peers></Discovery>'
    "</Domain></CycloneDDS>"
)


def _is_installed(implementation: str) -> bool:
    index = Path("share/ament_index/resource_index/rmw_typesupport")
    prefixes = filter(None, os.environ.get("AMENT_PREFIX_PATH", "").split(":"))
    return any((prefix / index / implementation).exists() for prefix in map(Path, prefixes))


# LOCALHOST alone does not choose the interface in a ROS 2 installation. With other implementations
# endpoints of one process need time to find each other; most tests give them none.
if _is_installed("rmw_cyclonedds_cpp"):
    os.environ.setdefault("CYCLONEDDS_URI", LOOPBACK)
    os.environ.setdefault("RMW_IMPLEMENTATION", "rmw_cyclonedds_cpp")

DEADLINE = 60.0
"""Wall time [s] after which a condition counts as never met."""


class Ros:
    """Nodes of one test in a private context with one executor.

    An exception in a callback leaves the executor's spin and thereby fails the test.
    """

    def __init__(self) -> None:
        import rclpy
        from rclpy.context import Context
        from rclpy.executors import SingleThreadedExecutor

        self.context = Context()
        rclpy.init(args=[], context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.nodes: list[Any] = []

    def node(self, name: str, **options: Any) -> Any:
        """Create a node that the executor spins."""
        from rclpy.node import Node

        node = Node(name, context=self.context, **options)
        self.nodes.append(node)
        self.executor.add_node(node)
        return node

    def spin_until(self, condition: Callable[[], Any], deadline: float = DEADLINE) -> None:
        """Spin until `condition` is true; fail the test after `deadline` seconds."""
        end = time.monotonic() + deadline
        while not condition():
            assert time.monotonic() < end, f"not within {deadline} s"
            self.executor.spin_once(timeout_sec=0.02)

    @staticmethod
    def wait_until(condition: Callable[[], Any], deadline: float = DEADLINE) -> None:
        """Wait without spinning for what other threads or the middleware bring about."""
        end = time.monotonic() + deadline
        while not condition():
            assert time.monotonic() < end, f"not within {deadline} s"
            time.sleep(0.001)

    def spin_for(self, duration: float) -> None:
        """Spin for a while [s], to see that something does not happen."""
        from rclpy.task import Future

        self.executor.spin_until_future_complete(Future(), timeout_sec=duration)

    @staticmethod
    def processor_time(wait: Callable[[], Any]) -> float:
        """Processor time [s] that this thread takes for `wait`: all of the wall time if it polls.

        Neither other threads nor a garbage collection of all that the tests left are counted.
        """
        gc.collect()
        begin = time.thread_time()
        wait()
        return time.thread_time() - begin

    def result(self, future: Any, deadline: float = DEADLINE) -> Any:
        """Spin until `future` is done and return its result."""
        self.spin_until(future.done, deadline)
        return future.result()

    def close(self) -> None:
        """Destroy everything."""
        self.executor.shutdown()
        for node in self.nodes:
            node.destroy_node()
        self.context.try_shutdown()


@pytest.fixture
def ros() -> Iterator[Ros]:
    """Nodes in process."""
    loop = Ros()
    yield loop
    loop.close()


@pytest.fixture
def node(ros: Ros) -> Any:
    """One node."""
    return ros.node("n")
