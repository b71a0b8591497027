"""What tests of the ``ros2`` command share: a node that goes on while commands ask for it."""

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
