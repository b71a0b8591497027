"""Beginning and end: init, shutdown, contexts and the module's spin functions."""

import os

import pytest
import rclpy
from rclpy._rclpy_pybind11 import RCLError
from rclpy.context import Context
from rclpy.exceptions import NotInitializedException
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.task import Future
from rclpy.utilities import get_default_context, get_rmw_implementation_identifier
from std_msgs.msg import Float64


@pytest.fixture
def default_context():
    rclpy.init(args=[])
    yield get_default_context()
    rclpy.try_shutdown()


def test_a_context_lives_from_init_to_shutdown():
    context = Context()
    assert not context.ok()
    context.init(args=[])
    assert context.ok()
    assert context.get_domain_id() == int(os.environ["ROS_DOMAIN_ID"])
    with pytest.raises(RuntimeError, match="must only be called once"):
        context.init(args=[])
    context.shutdown()
    assert not context.ok()
    context.try_shutdown()
    with pytest.raises(RCLError, match="already called"):
        context.shutdown()


def test_a_context_is_not_used_again():
    context = Context()
    context.init(args=[])
    context.shutdown()
    with pytest.raises(RuntimeError, match="must only be called once"):
        context.init(args=[])


def test_the_default_context_is_replaced_after_shutdown():
    rclpy.init(args=[])
    assert rclpy.ok()
    first = get_default_context()
    rclpy.shutdown()
    assert not rclpy.ok()
    assert get_default_context() is not first
    rclpy.init(args=[])
    assert rclpy.ok()
    rclpy.try_shutdown()
    rclpy.try_shutdown()
    assert not rclpy.ok()


def test_init_and_shutdown_once(default_context):
    with pytest.raises(RuntimeError, match="must only be called once"):
        rclpy.init(args=[])
    rclpy.shutdown()
    with pytest.raises(RuntimeError):
        rclpy.shutdown()


def test_init_takes_names_only():
    with pytest.raises(TypeError):
        rclpy.init([])


def test_a_context_manager_does_both():
    with Context() as context:
        assert context.ok()
    assert not context.ok()


def test_shutdown_calls_back():
    # In rclpy 7.1 a callback that asks context.ok() waits for ever: not asked here.
    context, calls = Context(), []
    context.init(args=[])
    context.on_shutdown(lambda: calls.append(1))
    context.on_shutdown(lambda: calls.append(2))
    context.shutdown()
    assert calls == [1, 2]
    context.on_shutdown(lambda: calls.append("at once"))
    assert calls == [1, 2, "at once"]
    with pytest.raises(TypeError):
        Context().on_shutdown("no callable")


def test_methods_called_on_shutdown_are_held_weakly():
    calls = []

    class Owner:
        def method(self):
            calls.append(1)

    context, kept, dropped = Context(), Owner(), Owner()
    context.init(args=[])
    context.on_shutdown(kept.method)
    context.on_shutdown(dropped.method)
    del dropped
    context.shutdown()
    assert calls == [1]


def test_without_init_there_are_no_nodes():
    context = Context()
    with pytest.raises(NotInitializedException, match=r"rclpy.init\(\) has not been called"):
        Node("n", context=context)
    with pytest.raises(RuntimeError):
        context.shutdown()
    context.try_shutdown()
    with pytest.raises(RuntimeError):
        context.get_domain_id()
    with pytest.raises(RuntimeError, match="lower than zero"):
        context.init(args=[], domain_id=-1)


def test_after_shutdown_there_are_no_nodes():
    context = Context()
    context.init(args=[])
    context.shutdown()
    with pytest.raises(NotInitializedException):
        Node("n", context=context)


def test_the_domain_is_chosen():
    other = int(os.environ["ROS_DOMAIN_ID"]) % 100 + 1
    context = Context()
    rclpy.init(args=[], context=context, domain_id=other)
    assert context.get_domain_id() == other
    rclpy.shutdown(context=context)
    assert not rclpy.ok(context=context)


def test_domains_do_not_hear_each_other(ros):
    other = Context()
    other.init(args=[], domain_id=(ros.context.get_domain_id() % 100) + 1)
    here, there = Node("here", context=ros.context), Node("there", context=other)
    there.create_subscription(Float64, "/x", print, 10)
    publisher = here.create_publisher(Float64, "/x", 10)
    assert not here.wait_for_node("/there", 0.3)
    assert publisher.get_subscription_count() == 0
    here.destroy_node()
    there.destroy_node()
    other.shutdown()


def test_two_contexts_in_a_process_exchange_messages(ros):
    other = Context()
    other.init(args=[])
    first, second = ros.node("first"), Node("second", context=other)
    assert first.wait_for_node("/second", 20.0)
    received = []
    first.create_subscription(Float64, "x", received.append, 10)
    publisher = second.create_publisher(Float64, "x", 10)
    ros.wait_until(publisher.get_subscription_count)
    publisher.publish(Float64(data=1.0))
    ros.spin_until(lambda: received)
    second.destroy_node()
    other.shutdown()
    assert ros.context.ok()
    ros.executor.spin_once(timeout_sec=0)


def test_create_node_passes_its_options_on(default_context):
    node = rclpy.create_node(
        "n",
        namespace="ns",
        cli_args=["--ros-args", "-p", "a:=1"],
        parameter_overrides=[Parameter("b", value=2)],
        automatically_declare_parameters_from_overrides=True,
        start_parameter_services=False,
    )
    assert node.get_fully_qualified_name() == "/ns/n"
    assert node.context is default_context
    assert [node.get_parameter(name).value for name in "ab"] == [1, 2]
    assert "/ns/n/get_parameters" not in dict(node.get_service_names_and_types())
    node.destroy_node()


def test_the_module_spins_with_one_executor_for_all(default_context):
    node = rclpy.create_node("n")
    executor = rclpy.get_global_executor()
    assert rclpy.get_global_executor() is executor
    calls = []
    node.create_guard_condition(lambda: calls.append(node.executor)).trigger()
    rclpy.spin_once(node, timeout_sec=20)
    assert calls == [executor]
    assert executor.get_nodes() == []
    rclpy.spin_once(node, timeout_sec=0)
    future = executor.create_task(lambda: 1)
    rclpy.spin_until_future_complete(node, future, timeout_sec=20)
    assert future.result() == 1
    never = Future()
    rclpy.spin_until_future_complete(node, never, timeout_sec=0.01)
    assert not never.done()
    node.destroy_node()


def test_the_module_spins_with_an_executor_that_is_given(default_context):
    node = rclpy.create_node("n")
    executor = SingleThreadedExecutor()
    calls = []
    node.create_guard_condition(lambda: calls.append(node.executor)).trigger()
    rclpy.spin_once(node, executor=executor, timeout_sec=20)
    assert calls == [executor]
    executor.shutdown()
    node.destroy_node()


def test_spin_ends_with_the_context(default_context):
    node = rclpy.create_node("n")
    node.create_guard_condition(rclpy.shutdown).trigger()
    rclpy.spin(node)
    assert not rclpy.ok()
    node.destroy_node()


def test_the_implementation_has_a_name():
    assert get_rmw_implementation_identifier().startswith("rmw_")
