"""`bdt status` beside loops that run, and beside none."""

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node

from bdt_bringup.loop_health import LoopHealth
from bdt_bringup.loop_state import DEGRADED, OK, STOPPED, LoopState
from bdt_bringup.status import ChangesOfState
from bdt_msgs_py.qos import qos_profile
from bdt_msgs_py.topics import DIAGNOSTICS


class Bench:
    """A listener in a namespace, and a node that plays all others."""

    def __init__(self, ros, namespace=""):
        self.ros = ros
        node = ros.create(lambda **options: Node("status", namespace=namespace, **options))
        self.health = LoopHealth(node)
        self.publisher = ros.create(Node, "all").create_publisher(
            DiagnosticArray, DIAGNOSTICS.name, qos_profile(DIAGNOSTICS)
        )
        ros.spin_until(lambda: self.publisher.get_subscription_count() == 1)

    def say(self, name, level=0, message="well", **values):
        pairs = [KeyValue(key=key, value=value) for key, value in values.items()]
        status = DiagnosticStatus(level=bytes([level]), name=name, message=message, values=pairs)
        self.publisher.publish(DiagnosticArray(status=[status]))


def test_the_state_is_that_of_the_nodes_of_the_own_loop(ros):
    bench = Bench(ros)
    bench.say("/left/plant", 2, "stopped")
    bench.say("/camera", 2, "lens cap")
    bench.say("/plant")
    bench.say("/controller")
    bench.say("/twin", 1, "estimator failed")
    ros.spin_until(lambda: "twin" in bench.health.reports)
    assert bench.health.state == LoopState(DEGRADED, "twin", "estimator failed")
    assert set(bench.health.reports) == {"plant", "controller", "twin"}


def test_a_loop_in_a_namespace_is_told_by_its_own_nodes(ros):
    bench = Bench(ros, "/left")
    bench.say("/driver", state="armed")
    bench.say("/left/driver", state="open", message="open")
    bench.say("/left/controller")
    ros.spin_until(lambda: len(bench.health.reports) == 2)
    assert bench.health.state == LoopState(STOPPED, "driver", "open")


def test_a_node_that_is_there_and_says_nothing_is_silent(ros, monkeypatch):
    monkeypatch.setattr("bdt_bringup.loop_state.SILENCE", 0.3)
    bench = Bench(ros)
    ros.create(Node, "controller")
    bench.say("/plant")
    ros.spin_until(lambda: bench.health.reports)
    ros.spin_until(lambda: not bench.health.look_for_nodes())
    assert bench.health.state.word == OK, "it may just have come"

    def is_silent():
        bench.say("/plant")
        bench.health.look_for_nodes()
        return bench.health.state[:2] == (STOPPED, "controller")

    ros.spin_until(is_silent)


def test_what_a_stranger_says_does_not_move_the_cursor(ros):
    bench = Bench(ros)
    bench.say("/plant", 2, "\x1b[2J\nstopped")
    ros.spin_until(lambda: bench.health.reports)
    assert bench.health.reports["plant"].text == "?[2J stopped"


@pytest.mark.parametrize(
    ("second", "is_news"),
    [
        (LoopState(DEGRADED, "twin", "another reason"), False),
        (LoopState(DEGRADED, "plant", "late"), True),
        (LoopState(OK, "", "well"), True),
    ],
)
def test_another_word_or_cause_is_news_and_another_reason_is_none(second, is_news):
    changes = ChangesOfState()
    assert changes.is_news(LoopState(DEGRADED, "twin", "late"))
    assert changes.is_news(second) is is_news
