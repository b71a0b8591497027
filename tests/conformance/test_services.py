"""Services and clients."""

import subprocess
import sys
import threading

import pytest
from rclpy._rclpy_pybind11 import RCLError
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.exceptions import InvalidHandle, InvalidServiceNameException
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile
from std_msgs.msg import String
from std_srvs.srv import Empty, SetBool, Trigger


def answer(request, response):
    response.success = request.data
    response.message = "yes" if request.data else "no"
    return response


def test_a_request_is_answered(ros, node):
    node.create_service(SetBool, "flag", answer)
    client = node.create_client(SetBool, "flag")
    assert client.wait_for_service(20.0)
    response = ros.result(client.call_async(SetBool.Request(data=True)))
    assert response == SetBool.Response(success=True, message="yes")


def test_answers_find_the_client_and_call_they_belong_to(ros, node):
    node.create_service(SetBool, "flag", answer)
    clients = [ros.node(name).create_client(SetBool, "flag") for name in ("a", "b")]
    assert all(client.wait_for_service(20.0) for client in clients)
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
    assert client.wait_for_service(20.0)
    assert caller.wait_for_service(20.0)
    assert ros.result(caller.call_async(Trigger.Request())).message == "yes"


def test_waiting_ends_when_the_server_appears_or_time_is_over(ros, node):
    client = node.create_client(Trigger, "later")
    assert not client.service_is_ready()
    assert not client.wait_for_service(0.02)
    other = ros.node("other")
    threading.Timer(
        0.05, lambda: other.create_service(Trigger, "later", lambda _, reply: reply)
    ).start()
    assert client.wait_for_service(20.0)


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
        assert client.wait_for_service(20.0)
        future = client.call_async(Trigger.Request())
        assert server.wait(20) == 3
    ros.executor.spin_until_future_complete(future, 0.05)
    assert not future.done()
    client.remove_pending_request(future)
    with pytest.raises(KeyError):
        client.get_pending_request(1)


def test_a_blocking_call_needs_an_executor_in_another_thread(ros, node):
    node.create_service(SetBool, "flag", answer)
    client = node.create_client(SetBool, "flag")
    assert client.wait_for_service(20.0)
    assert client.call(SetBool.Request(), timeout_sec=0.01) is None
    spinner = threading.Thread(target=ros.executor.spin)
    spinner.start()
    assert client.call(SetBool.Request(data=True), timeout_sec=20.0).message == "yes"
    ros.executor.shutdown()
    spinner.join(20)
    assert not spinner.is_alive()


def test_a_callback_may_block_on_a_call_in_a_multi_threaded_executor(ros):
    node = Node("n", context=ros.context)
    group = ReentrantCallbackGroup()
    node.create_service(SetBool, "flag", answer, callback_group=group)
    client = node.create_client(SetBool, "flag", callback_group=group)
    answers, once = [], threading.Lock()

    def call_once():
        # A timer without a period may be ready again before it is destroyed.
        if once.acquire(blocking=False):
            node.destroy_timer(timer)
            answers.append(client.call(SetBool.Request(data=True)))

    timer = node.create_timer(0.0, call_once, callback_group=group)
    executor = MultiThreadedExecutor(4, context=ros.context)
    executor.add_node(node)
    assert client.wait_for_service(20.0)
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
    assert client.wait_for_service(20.0)
    client.call_async(Trigger.Request())
    with pytest.raises(TypeError):
        ros.spin_until(lambda: False)


def test_clients_and_services_tell_their_properties(node):
    profile = QoSProfile(depth=3)
    service = node.create_service(SetBool, "flag", answer, qos_profile=profile)
    client = node.create_client(SetBool, "flag", qos_profile=profile)
    for entity in (service, client):
        assert entity.srv_type is SetBool
        assert entity.srv_name == "flag"
        assert entity.service_name == "/flag"
        assert entity.qos_profile == profile
    assert service.callback is answer
    assert service in list(node.services)
    assert list(node.clients) == [client]


def test_a_service_without_fields(ros, node):
    calls = []

    def callback(request, response):
        calls.append(request)
        return response

    node.create_service(Empty, "empty", callback)
    client = node.create_client(Empty, "empty")
    assert client.wait_for_service(20.0)
    assert ros.result(client.call_async(Empty.Request())) == Empty.Response()
    assert calls == [Empty.Request()]


def test_a_forgotten_request_is_never_answered(ros, node):
    node.create_service(SetBool, "flag", answer)
    client = node.create_client(SetBool, "flag")
    assert client.wait_for_service(20.0)
    forgotten, wanted = (client.call_async(SetBool.Request(data=True)) for _ in range(2))
    client.remove_pending_request(forgotten)
    client.remove_pending_request(forgotten)
    assert ros.result(wanted).success
    assert not forgotten.done()


def test_done_callbacks_get_the_future(ros, node):
    node.create_service(SetBool, "flag", answer)
    client = node.create_client(SetBool, "flag")
    assert client.wait_for_service(20.0)
    seen = []
    future = client.call_async(SetBool.Request(data=True))
    future.add_done_callback(seen.append)
    ros.spin_until(lambda: seen)
    assert seen == [future]
    assert future.result().success


def test_a_cancelled_call_is_forgotten(ros, node):
    node.create_service(SetBool, "flag", answer)
    client = node.create_client(SetBool, "flag")
    assert client.wait_for_service(20.0)
    future = client.call_async(SetBool.Request())
    future.cancel()
    with pytest.raises(KeyError):
        client.get_pending_request(1)
    ros.spin_for(0.02)
    assert future.cancelled()


def test_destroyed_entities_are_gone(ros, node):
    service = node.create_service(SetBool, "flag", answer)
    client = node.create_client(SetBool, "flag")
    assert client.wait_for_service(20.0)
    assert node.destroy_service(service)
    assert not node.destroy_service(service)
    ros.wait_until(lambda: not client.service_is_ready())
    assert node.destroy_client(client)
    assert not node.destroy_client(client)
    with pytest.raises(InvalidHandle):
        client.wait_for_service(0.01)


def test_a_call_blocks_in_another_thread(ros, node):
    node.create_service(SetBool, "flag", answer)
    client = node.create_client(SetBool, "flag")
    assert client.wait_for_service(20.0)
    responses = []
    caller = threading.Thread(
        target=lambda: responses.append(client.call(SetBool.Request(data=True)))
    )
    caller.start()
    ros.spin_until(lambda: responses)
    caller.join(20)
    assert responses[0].message == "yes"
