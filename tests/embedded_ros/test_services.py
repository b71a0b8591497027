"""Services, and the parameter services through their client."""

import subprocess
import sys
import threading

import pytest
from rclpy._rclpy_pybind11 import RCLError
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.exceptions import InvalidHandle, InvalidServiceNameException
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.parameter_client import AsyncParameterClient
from std_msgs.msg import String
from std_srvs.srv import SetBool, Trigger


@pytest.fixture
def node(ros):
    return ros.create(Node, "n")


def answer(request, response):
    response.success = request.data
    response.message = "yes" if request.data else "no"
    return response


def test_a_request_is_answered(ros, node):
    node.create_service(SetBool, "flag", answer)
    client = node.create_client(SetBool, "flag")
    assert client.wait_for_service(5.0)
    response = ros.result(client.call_async(SetBool.Request(data=True)))
    assert response == SetBool.Response(success=True, message="yes")


def test_answers_find_the_client_and_call_they_belong_to(ros, node):
    node.create_service(SetBool, "flag", answer)
    clients = [ros.create(Node, name).create_client(SetBool, "flag") for name in ("a", "b")]
    assert all(client.wait_for_service(5.0) for client in clients)
    calls = [
        (flag, client.call_async(SetBool.Request(data=flag)))
        for flag in (True, False, False, True)
        for client in clients
    ]
    for flag, future in reversed(calls):
        assert ros.result(future).success is flag


def test_a_service_may_be_a_coroutine_that_calls_another(ros, node):
    node.create_service(SetBool, "inner", answer)
    client = node.create_client(SetBool, "inner", callback_group=ReentrantCallbackGroup())

    async def outer(_, response):
        inner = await client.call_async(SetBool.Request(data=True))
        response.message = inner.message
        return response

    group = ReentrantCallbackGroup()
    node.create_service(Trigger, "outer", outer, callback_group=group)
    caller = node.create_client(Trigger, "outer", callback_group=group)
    assert client.wait_for_service(5.0)
    assert caller.wait_for_service(5.0)
    assert ros.result(caller.call_async(Trigger.Request())).message == "yes"


def test_waiting_ends_when_the_server_appears_or_time_is_over(ros, node):
    client = node.create_client(Trigger, "later")
    assert not client.service_is_ready()
    assert not client.wait_for_service(0.02)
    other = ros.create(Node, "other")
    threading.Timer(
        0.05, lambda: other.create_service(Trigger, "later", lambda _, reply: reply)
    ).start()
    assert client.wait_for_service(10.0)


def test_waiting_ends_when_the_context_is_shut_down(ros, node):
    client = node.create_client(Trigger, "never")
    threading.Timer(0.05, ros.context.try_shutdown).start()
    with pytest.raises(RCLError, match="context is invalid"):
        client.wait_for_service()


DYING_SERVER = """
import os, sys, rclpy
from rclpy.node import Node
from std_srvs.srv import Trigger
rclpy.init()
node = Node("dying")
node.create_service(Trigger, "die", lambda request, response: os._exit(3))
print("ready", flush=True)
rclpy.spin(node)
"""


def test_a_server_that_dies_leaves_the_call_pending(ros, node):
    client = node.create_client(Trigger, "die")
    with subprocess.Popen(
        [sys.executable, "-c", DYING_SERVER], stdout=subprocess.PIPE, text=True
    ) as server:
        server.stdout.readline()
        assert client.wait_for_service(10.0)
        future = client.call_async(Trigger.Request())
        assert server.wait(10) == 3
    ros.executor.spin_until_future_complete(future, 0.05)
    assert not future.done()
    client.remove_pending_request(future)
    with pytest.raises(KeyError):
        client.get_pending_request(1)


def test_a_blocking_call_needs_an_executor_in_another_thread(ros, node):
    node.create_service(SetBool, "flag", answer)
    client = node.create_client(SetBool, "flag")
    assert client.wait_for_service(5.0)
    assert client.call(SetBool.Request(), timeout_sec=0.01) is None
    spinner = threading.Thread(target=ros.executor.spin)
    spinner.start()
    assert client.call(SetBool.Request(data=True), timeout_sec=5.0).message == "yes"
    ros.executor.shutdown()
    spinner.join(5)
    assert not spinner.is_alive()


def test_a_callback_may_block_on_a_call_in_a_multi_threaded_executor(ros):
    node = Node("n", context=ros.context)
    group = ReentrantCallbackGroup()
    node.create_service(SetBool, "flag", answer, callback_group=group)
    client = node.create_client(SetBool, "flag", callback_group=group)
    answers = []

    def call_once():
        node.destroy_timer(timer)
        answers.append(client.call(SetBool.Request(data=True)))

    timer = node.create_timer(0.0, call_once, callback_group=group)
    executor = MultiThreadedExecutor(4, context=ros.context)
    executor.add_node(node)
    assert client.wait_for_service(5.0)
    for _ in range(200):
        executor.spin_once(0.05)
        if answers:
            break
    assert answers[0].message == "yes"
    assert executor.shutdown(5.0)
    node.destroy_node()


def test_bad_arguments(ros, node):
    with pytest.raises(InvalidServiceNameException):
        node.create_client(Trigger, "a b")
    with pytest.raises(RuntimeError, match="might be a message"):
        node.create_client(String, "x")
    client = node.create_client(Trigger, "x")
    with pytest.raises(TypeError):
        client.call_async(SetBool.Request())
    node.destroy_client(client)
    with pytest.raises(InvalidHandle):
        client.call_async(Trigger.Request())


def test_a_callback_that_returns_no_response_is_an_error_of_spin(ros, node):
    node.create_service(Trigger, "x", lambda _request, _response: None)
    client = node.create_client(Trigger, "x")
    assert client.wait_for_service(5.0)
    client.call_async(Trigger.Request())
    with pytest.raises(TypeError):
        ros.spin_until(lambda: False, 5.0)


@pytest.fixture
def parameters(ros, node):
    node.declare_parameters("", [("gain", 1.0), ("names", ["a", "b"])])
    client = AsyncParameterClient(ros.create(Node, "asking"), "/n")
    assert client.wait_for_services(5.0)
    return client


def test_remote_parameters_are_read(ros, parameters):
    values = ros.result(parameters.get_parameters(["gain", "names"])).values
    assert values[0].double_value == 1.0
    assert values[1].string_array_value == ["a", "b"]
    assert ros.result(parameters.get_parameters(["gain", "nothing"])).values == []
    assert list(ros.result(parameters.get_parameter_types(["gain"])).types) == [3]
    assert ros.result(parameters.describe_parameters(["gain"])).descriptors[0].name == "gain"
    names = ros.result(parameters.list_parameters()).result.names
    assert names == ["use_sim_time", "start_type_description_service", "gain", "names"]


def test_remote_parameters_are_set(ros, node, parameters):
    both = [Parameter("gain", value=2.5), Parameter("gain", value="x")]
    results = ros.result(parameters.set_parameters(both)).results
    assert [result.successful for result in results] == [True, False]
    assert "Wrong parameter type" in results[1].reason
    assert node.get_parameter("gain").value == 2.5
    result = ros.result(parameters.set_parameters_atomically(both)).result
    assert not result.successful
    missing = ros.result(parameters.set_parameters([Parameter("nothing", value=1)])).results[0]
    # The name is missing in rclpy's answer, too.
    assert missing.reason == "Invalid access to undeclared parameter(s): []"


def test_a_parameter_file_is_sent(ros, node, parameters, tmp_path):
    path = tmp_path / "p.yaml"
    path.write_text("n: {ros__parameters: {gain: 4.5, names: [c]}}")
    ros.result(parameters.load_parameter_file(str(path)))
    assert node.get_parameter("gain").value == 4.5
    assert node.get_parameter("names").value == ["c"]


def test_arrays_arrive_as_arrays(ros, node, parameters):
    node.declare_parameter("values", [1.0])
    ros.result(parameters.set_parameters([Parameter("values", value=[1.5, 2.5])]))
    assert list(node.get_parameter("values").value) == [1.5, 2.5]
