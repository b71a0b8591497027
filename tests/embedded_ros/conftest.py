"""What tests of several files share: a node that goes on while others ask, and a usual Ctrl-C."""

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
def ctrl_c_as_in_any_program():
    """Give SIGINT its usual handler, whatever nodes this process has had."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)
