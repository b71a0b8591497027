"""What tests of several files share: a node that goes on while others ask, and usual signals."""

import signal
import threading

import pytest
from rclpy.executors import ExternalShutdownException


@pytest.fixture
def spin_in_thread(ros):
    """Return a function that has another thread spin the nodes until the end of the test."""

    def spin():
        try:
            ros.executor.spin()
        except ExternalShutdownException:
            return

    spinner = threading.Thread(target=spin)
    yield spinner.start
    ros.executor.shutdown()
    spinner.join(20)


@pytest.fixture
def signals_as_in_any_program():
    """Give SIGINT and SIGTERM their usual handlers, whatever nodes this process has had."""
    usual = {signal.SIGINT: signal.default_int_handler, signal.SIGTERM: signal.SIG_DFL}
    before = {number: signal.signal(number, handler) for number, handler in usual.items()}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)
