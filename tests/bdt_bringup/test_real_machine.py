"""A real machine in a run: when it is armed, what ends it."""

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.node import Node
from std_srvs.srv import Trigger

from bdt_bringup import real_machine
from bdt_bringup.monitor import MonitorNode
from bdt_bringup.real_machine import RealMachine
from bdt_msgs_py.command_errors import LoopError
from bdt_msgs_py.qos import qos_profile
from bdt_msgs_py.topics import DIAGNOSTICS, DRIVER_NODE


class Driver(Node):
    """Answers the driver's services as a test has it."""

    def __init__(self, **arguments):
        super().__init__(DRIVER_NODE, **arguments)
        self.answer, self.calls = (True, "armed"), []
        self.create_service(Trigger, "~/arm", lambda request, response: self.serve("arm", response))
        self.create_service(
            Trigger, "~/disarm", lambda request, response: self.serve("disarm", response)
        )
        self.diagnostics = self.create_publisher(
            DiagnosticArray, DIAGNOSTICS.name, qos_profile(DIAGNOSTICS)
        )

    def serve(self, name, response):
        self.calls.append(name)
        response.success, response.message = self.answer
        return response

    def tell(self, name, level, message):
        status = DiagnosticStatus(name=name, level=level, message=message)
        self.diagnostics.publish(DiagnosticArray(status=[status]))


class Stage:
    """A monitor, a driver, and the machine between them."""

    def __init__(self, ros, nodes=(DRIVER_NODE,)):
        self.ros = ros
        self.monitor = ros.create(MonitorNode)
        self.driver = ros.create(Driver)
        self.machine = RealMachine(self.monitor, nodes)

    def look_until(self, condition):
        def looked():
            self.machine.look()
            return condition()

        self.ros.spin_until(looked)


def test_it_is_armed_when_everybody_is_there_and_its_time_begins_then(ros):
    stage = Stage(ros, (DRIVER_NODE, "controller"))
    ros.spin_until(stage.machine._arm.service_is_ready)
    stage.machine.look()
    assert (stage.driver.calls, stage.machine.simulated_time) == ([], 0.0)
    ros.create(Node, "controller")
    stage.look_until(lambda: stage.machine.simulated_time > 0.01)
    assert stage.driver.calls == ["arm"]
    assert stage.machine.real_time_factor() is None


def test_it_is_asked_again_until_there_is_a_reading(ros):
    stage = Stage(ros)
    stage.driver.answer = False, "there is no reading yet"
    stage.look_until(lambda: len(stage.driver.calls) > 2)
    stage.driver.answer = True, "armed"
    stage.look_until(lambda: stage.machine.simulated_time > 0.0)


def test_one_that_does_not_get_armed_says_why(ros, monkeypatch):
    monkeypatch.setattr(real_machine, "ARMING_TIMEOUT", 0.5)
    stage = Stage(ros)
    stage.driver.answer = False, "platform 3 is at 0.1 m"
    with pytest.raises(LoopError, match=r"driver: is not armed: platform 3 is at 0\.1 m"):
        stage.look_until(lambda: False)


def test_a_fault_of_the_driver_ends_the_run_and_that_of_another_node_does_not(ros):
    stage = Stage(ros)
    ros.spin_until(lambda: stage.driver.diagnostics.get_subscription_count() == 1)
    stage.driver.tell("/driver", DiagnosticStatus.WARN, "late")
    stage.driver.tell("/left/driver", DiagnosticStatus.ERROR, "of another loop")
    stage.look_until(lambda: stage.machine.simulated_time > 0.05)
    stage.driver.tell("/driver", DiagnosticStatus.ERROR, "the cable is pulled")
    with pytest.raises(LoopError, match="driver: the drive is stopped: the cable is pulled"):
        stage.look_until(lambda: False)


def test_at_the_end_it_is_disarmed(ros):
    stage = Stage(ros)
    stage.look_until(lambda: stage.machine.simulated_time > 0.0)
    stage.machine.disarm(ros.executor)
    assert stage.driver.calls == ["arm", "disarm"]
