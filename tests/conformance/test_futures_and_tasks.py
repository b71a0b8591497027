"""Futures, and tasks: functions and coroutines that an executor runs."""

import threading

import pytest
from rclpy.task import Future, Task


def boom(*_):
    raise ValueError("boom")


def test_tasks_give_results_and_exceptions(ros, node):
    task = ros.executor.create_task(lambda x, y: x + y, 1, y=2)
    assert ros.result(task) == 3
    failing = ros.executor.create_task(boom)
    with pytest.raises(ValueError, match="boom"):
        ros.executor.spin_until_future_complete(failing, 1)
    assert isinstance(failing.exception(), ValueError)


def test_coroutines_wait_for_futures_without_spinning_idly(ros, node):
    future = Future()
    steps = []

    async def wait():
        steps.append("waits")
        steps.append(await future)
        return "done"

    task = ros.executor.create_task(wait)
    ros.executor.spin_once(timeout_sec=1)
    assert ros.processor_time(lambda: ros.executor.spin_once(timeout_sec=0.3)) < 0.15
    assert steps == ["waits"]
    threading.Timer(0.02, future.set_result, ["set"]).start()
    assert ros.result(task) == "done"
    assert steps == ["waits", "set"]


def test_a_coroutine_that_only_yields_lets_others_run(ros, node):
    calls = []

    class Pause:
        def __await__(self):
            yield

    async def forever():
        while len(calls) < 3:
            await Pause()

    task = ros.executor.create_task(forever)
    node.create_timer(0.005, lambda: calls.append(1))
    ros.spin_until(task.done)


def test_a_future_calls_back_when_it_is_done():
    future, seen = Future(), []
    future.add_done_callback(seen.append)
    assert not future.done()
    assert future.result() is None
    future.set_result(5)
    future.add_done_callback(seen.append)
    assert seen == [future, future]
    assert future.result() == 5
    cancelled = Future()
    cancelled.cancel()
    assert cancelled.cancelled()
    assert not cancelled.done()


def test_a_future_cannot_be_subscripted_at_run_time_as_in_rclpy():
    with pytest.raises(TypeError, match="type 'Future' is not subscriptable"):
        Future[int]


def test_a_future_holds_an_exception():
    future = Future()
    future.set_exception(ValueError("boom"))
    assert future.done()
    assert isinstance(future.exception(), ValueError)
    with pytest.raises(ValueError, match="boom"):
        future.result()


def test_a_future_that_fails_unseen_says_so(capfd):
    future = Future()
    future.set_exception(ValueError("boom"))
    del future
    assert "The following exception was never retrieved: boom" in capfd.readouterr().err


def test_a_done_callback_that_raises_does_not_stop_the_others():
    future, seen = Future(), []
    future.add_done_callback(boom)
    future.add_done_callback(seen.append)
    with pytest.warns(UserWarning, match="Unhandled exception in done callback"):
        future.set_result(1)
    assert seen == [future]


def test_done_callbacks_of_a_future_with_an_executor_are_run_by_it(ros, node):
    future, seen = Future(executor=ros.executor), []
    future.add_done_callback(seen.append)
    future.set_result(1)
    assert seen == []
    ros.spin_until(lambda: seen)


def test_a_task_runs_by_itself_when_called():
    task = Task(lambda x, y: x + y, args=[1], kwargs={"y": 2})
    assert not task.done()
    task()
    assert task.done()
    assert task.result() == 3
    assert not task.executing()
    failing = Task(boom)
    failing()
    assert isinstance(failing.exception(), ValueError)


def test_a_cancelled_task_does_not_run(ros, node):
    calls = []
    task = Task(lambda: calls.append(1))
    task.cancel()
    assert task.cancelled()
    assert not task.done()


def test_a_cancelled_task_that_an_executor_has_runs_all_the_same(ros, node):
    calls = []

    async def coroutine():
        calls.append("coroutine")

    for work in (lambda: calls.append("function"), coroutine):
        task = ros.executor.create_task(work)
        task.cancel()
        ros.spin_until(task.done)
        assert not task.cancelled()
    assert calls == ["function", "coroutine"]


def test_a_function_may_fail_with_what_ends_coroutines():
    def end():
        raise StopIteration(4)

    task = Task(end)
    task()
    assert isinstance(task.exception(), StopIteration)


def test_an_exception_outlives_a_result():
    future = Future()
    future.set_exception(ValueError("boom"))
    future.set_result(1)
    with pytest.raises(ValueError, match="boom"):
        future.result()


def test_coroutines_await_each_other(ros, node):
    async def inner(value):
        return value + 1

    async def outer():
        first = ros.executor.create_task(inner, 1)
        return await first + await inner(2)

    assert ros.result(ros.executor.create_task(outer)) == 5
    assert ros.result(ros.executor.create_task(inner(1))) == 2


def test_an_awaited_exception_is_raised_in_the_coroutine(ros, node):
    future = Future()

    async def wait():
        try:
            await future
        except ValueError as error:
            return str(error)

    task = ros.executor.create_task(wait)
    ros.executor.spin_once(timeout_sec=0.1)
    future.set_exception(ValueError("boom"))
    assert ros.result(task) == "boom"


@pytest.mark.parametrize("kind", ["timer", "guard condition"])
def test_coroutines_are_callbacks(ros, node, kind):
    future, steps = Future(), []

    async def callback():
        steps.append("begins")
        steps.append(await future)

    if kind == "timer":
        timer = node.create_timer(0.0, callback)
    else:
        node.create_guard_condition(callback).trigger()
    ros.spin_until(lambda: steps)
    if kind == "timer":
        timer.cancel()
    future.set_result("ends")
    ros.spin_until(lambda: len(steps) >= 2)
    assert steps[:2] == ["begins", "ends"]
