"""Nodes as processes: strays end none of them, and one that is killed is named."""

import os
import signal
import subprocess
import sys
import time
from itertools import groupby
from pathlib import Path

import numpy as np
import pytest
from disturbed_loop import message_class
from rclpy.node import Node
from stray_messages import STRAYS

from bdt_msgs_py.qos import qos_profile
from bdt_msgs_py.reading import nanoseconds_from_stamp, read_samples
from bdt_msgs_py.topics import ALL_TOPICS, MEASUREMENT, PROGRESS, TELEMETRY, TELEMETRY_COLUMNS

CONFIG = Path(__file__).parents[1] / "config" / "paper.yaml"
DEADLINE = 180.0
ONE_SECOND = 250_000
"""Size of the recording of a second [byte]."""


class Stranger:
    """A node that hears everything and sends strays."""

    def __init__(self, ros):
        self.ros, self.node = ros, ros.create(Node, "stranger")
        self.heard = {}
        self.telemetry = []
        for topic in ALL_TOPICS:
            kind = message_class(topic.message_type)
            self.node.create_subscription(
                kind, topic.name, lambda m, topic=topic: self.hear(topic, m), qos_profile(topic)
            )

    def hear(self, topic, message):
        if topic is TELEMETRY and len(message.layout.dim) == 2 and message.layout.data_offset == 0:
            try:
                self.telemetry.append(read_samples(message, TELEMETRY_COLUMNS).copy())
            except ValueError:
                return
        self.heard.setdefault(topic, message)
        if topic is MEASUREMENT:
            self.heard[topic] = message

    def disturb(self, topic, strays):
        """Send strays of a topic, beside its publisher: a plant does not start beside a clock."""
        publisher = self.node.create_publisher(
            message_class(topic.message_type), topic.name, qos_profile(topic)
        )
        listeners = self.node.count_subscribers(topic.name)
        self.ros.spin_until(lambda: publisher.get_subscription_count() >= listeners)
        for stray in strays:
            publisher.publish(stray.build(self.heard[topic], self.now))
            self.ros.spin_for(0.02)
        self.node.destroy_publisher(publisher)

    @property
    def now(self):
        return nanoseconds_from_stamp(self.heard[MEASUREMENT].header.stamp)


def test_no_stray_message_ends_a_process(ros, tmp_path):
    stranger = Stranger(ros)
    arguments = ["--mode", "realtime", "--duration", "10", "--no-bag", "--output", tmp_path / "run"]
    process = subprocess.Popen(
        [sys.executable, "-m", "bdt_bringup.cli", "run", "--config", CONFIG, *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    wanted = {MEASUREMENT, TELEMETRY, PROGRESS}
    ros.spin_until(lambda: wanted <= set(stranger.heard), DEADLINE)
    for topic, strays in groupby(STRAYS, key=lambda stray: stray.topic):
        if topic in stranger.heard:
            stranger.disturb(topic, strays)
    ros.spin_until(lambda: process.poll() is not None, DEADLINE)
    _, err = process.communicate(timeout=DEADLINE)
    assert process.returncode == 0, err
    logs = [err, *(log.read_text() for log in (tmp_path / "run" / "log").iterdir())]
    assert not any("Traceback" in log for log in logs)
    rows = np.concatenate(stranger.telemetry)
    # Strays among them are copies of what the plant said, save for those that no machine has.
    genuine = rows[(np.abs(rows) < 1e100).all(axis=1)]
    assert np.abs(genuine[:, 1]).max() <= 48.0
    assert np.abs(genuine[:, 2]).max() <= 0.05


@pytest.mark.parametrize("victim", ["twin", "recorder"])
def test_a_follower_that_is_killed_is_named_though_the_other_one_lives(
    tmp_path, claim_domain, victim
):
    modules = {
        "controller": ("bdt_controller.controller_node", "use_sim_time:=true"),
        "twin": ("bdt_twin.twin_node", "use_sim_time:=true"),
        "recorder": ("bdt_bags.recorder.recorder_node", f"bag:={tmp_path / 'bag'}"),
    }
    environment = os.environ | {"ROS_DOMAIN_ID": str(claim_domain())}

    def start(module, *parameters):
        options = [word for parameter in parameters for word in ("-p", parameter)]
        return subprocess.Popen(
            [sys.executable, "-m", module, "--ros-args", *options],
            stderr=subprocess.PIPE,
            text=True,
            env=environment,
        )

    started = {name: start(*arguments) for name, arguments in modules.items()}
    plant = start(
        "bdt_plant.plant_node", "lockstep_followers:=[twin, recorder]", "lockstep_timeout:=3.0"
    )
    try:
        end = time.monotonic() + DEADLINE
        while sum(file.stat().st_size for file in tmp_path.glob("bag/*.mcap")) < ONE_SECOND:
            assert plant.poll() is None
            assert time.monotonic() < end
            time.sleep(0.02)
        started[victim].send_signal(signal.SIGKILL)
        _, err = plant.communicate(timeout=DEADLINE)
    finally:
        for process in (*started.values(), plant):
            process.kill()
            process.communicate()
    assert plant.returncode == 1
    assert f"for progress of {victim} at t =" in err
