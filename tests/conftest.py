"""What tests with nodes need: a ROS domain of their own, on loopback, and nodes that end."""

import os
import signal
import sys
import time
from collections.abc import Callable, Iterator
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, settings

# In the folder of the tests that run with a real ROS 2, too, and need nothing else of this project.
_file = Path(__file__).parent / "conformance" / "ros_domain.py"
_spec = spec_from_file_location("ros_domain", _file)
_ros_domain = module_from_spec(_spec)
_spec.loader.exec_module(_ros_domain)

os.environ["ROS_DOMAIN_ID"] = str(_ros_domain.claim_domain())
os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"

# As the command does: there are as many test processes as processors.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# In the background of a script Ctrl-C is ignored, also in the programs that a test starts.
signal.signal(signal.SIGINT, signal.default_int_handler)

# A browser, bags and messages of loops, for the tests of several packages.
pytest_plugins = ["browser", "recorded_loops"]

LONG = (
    "test_tutorials_in_real_time",
    "test_tutorials",
    "test_run",
    "test_page",
    "test_output_error",
    "test_supervision",
    "test_reproduce",
    "test_reference",
    "test_calibrate",
    "test_stray_messages",
    "test_unknown_machines",
    "test_analyze",
    "test_restarts",
    "test_export",
    "test_fault_schedules",
    "test_run_sweep",
    "test_sweep_on_a_cluster",
    "test_stray_processes",
)
"""Files of tests that take long: where one begins last, one process works alone."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put the long files first; xdist puts those first that have most tests."""

    def place(item: pytest.Item) -> int:
        name = item.path.stem
        return LONG.index(name) if name in LONG else len(LONG)

    items.sort(key=place)


# Time limits of hypothesis say more about a busy machine than about the code.
settings.register_profile("project", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("project")

DEADLINE = 60.0
"""Wall time [s] after which a condition counts as never met."""


class RosLoop:
    """Nodes of one test in a private context with one executor.

    An exception in a callback leaves the executor's spin and thereby fails the test.
    """

    def __init__(self) -> None:
        import rclpy
        from rclpy.context import Context
        from rclpy.executors import SingleThreadedExecutor

        self.context = Context()
        rclpy.init(context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.nodes: list[Any] = []

    def create(self, node_class: Callable[..., Any], *arguments: Any, **parameters: Any) -> Any:
        """Create a node with parameters; ``__`` in a parameter's name stands for a dot."""
        from rclpy.parameter import Parameter

        overrides = [
            Parameter(name.replace("__", "."), value=value) for name, value in parameters.items()
        ]
        node = node_class(*arguments, context=self.context, parameter_overrides=overrides)
        self.nodes.append(node)
        self.executor.add_node(node)
        return node

    def spin_until(self, condition: Callable[[], Any], deadline: float = DEADLINE) -> None:
        """Spin until `condition` is true; fail the test after `deadline` seconds."""
        end = time.monotonic() + deadline
        while not condition():
            assert time.monotonic() < end, f"not within {deadline} s"
            self.executor.spin_once(timeout_sec=0.05)

    def spin_for(self, duration: float) -> None:
        """Spin for a while [s], to see that something does not happen."""
        from rclpy.task import Future

        self.executor.spin_until_future_complete(Future(), timeout_sec=duration)

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


@pytest.fixture(scope="session")
def count_calls() -> Callable[[Callable[[], Any]], int]:
    """Return a function that counts the calls of Python and C functions within a call.

    It tells work for each message from work for each number, on a busy machine as well.
    """

    def count(function: Callable[[], Any]) -> int:
        events: list[str] = []
        before = sys.getprofile()
        sys.setprofile(lambda _frame, event, _argument: events.append(event))
        try:
            function()
        finally:
            sys.setprofile(before)
        return events.count("call") + events.count("c_call")

    return count


@pytest.fixture(scope="session")
def claim_domain() -> Callable[[], int]:
    """Return a function that claims another ROS domain, for processes that must meet no others."""
    return _ros_domain.claim_domain


@pytest.fixture(scope="module")
def ros_loops() -> Iterator[Callable[[], RosLoop]]:
    """Return a function that gives nodes in process, each time after the end of the last ones."""
    loops: list[RosLoop] = []

    def create() -> RosLoop:
        for loop in loops:
            loop.close()
        loops[:] = [RosLoop()]
        return loops[0]

    yield create
    for loop in loops:
        loop.close()


@pytest.fixture
def ros() -> Iterator[RosLoop]:
    """Nodes in process."""
    loop = RosLoop()
    yield loop
    loop.close()
