"""``bdt record`` records beside a loop until Ctrl-C and says what it has."""

import os
import shutil
import signal
import subprocess
import sys
import threading

import pytest
import yaml
from rclpy.node import Node
from sensor_msgs.msg import JointState

from bdt_bringup.cli import run_command
from bdt_msgs_py.qos import qos_profile
from bdt_msgs_py.topics import MEASUREMENT
from bdt_msgs_py.writing import platform_position


def test_the_topics_of_a_namespace_are_recorded_until_ctrl_c(ros, tmp_path):
    bag = tmp_path / "bag"
    options = ["--output", bag, "--namespace", "left", "--compression", "zstd"]
    command = [sys.executable, "-m", "bdt_bringup.cli", "record", *options]
    talker = ros.create(Node, "talker")
    publisher = talker.create_publisher(JointState, "/left/measurement", qos_profile(MEASUREMENT))
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        try:
            ros.spin_until(lambda: publisher.get_subscription_count() == 1)
            assert ("bag_recorder", "/left") in talker.get_node_names_and_namespaces()
            for stamp in range(10):
                publisher.publish(platform_position(stamp, 0.0))
            # A message on its way would be lost with the subscription.
            ros.spin_until(publisher.wait_for_all_acked)
            ros.spin_until(lambda: (bag / "bag_0.mcap").stat().st_size > 2000)
            os.kill(process.pid, signal.SIGINT)
            output, _ = process.communicate(timeout=60)
        finally:
            process.kill()
    assert process.returncode == 0
    assert " 0 dropped because of the disk, 0 lost on the way" in output
    assert output.endswith(f"bag: {bag}\n")
    text = (bag / "metadata.yaml").read_text(encoding="utf-8")
    topics = yaml.safe_load(text)["rosbag2_bagfile_information"]["topics_with_message_count"]
    counts = {one["topic_metadata"]["name"]: one["message_count"] for one in topics}
    assert counts["/left/measurement"] == 10
    assert "/left/clock" in counts, "as bdt run --namespace and -r /clock:=clock move it"


def test_a_bag_that_is_deleted_is_told_at_once_and_ends_with_1(ros, tmp_path):
    bag = tmp_path / "bag"
    command = [sys.executable, "-m", "bdt_bringup.cli", "record", "--output", str(bag)]
    talker = ros.create(Node, "talker")
    publisher = talker.create_publisher(JointState, "/measurement", qos_profile(MEASUREMENT))
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True) as process:
        try:
            ros.spin_until(lambda: publisher.get_subscription_count() == 1)
            shutil.rmtree(bag)
            limit = threading.Timer(60, process.kill)
            limit.start()
            lines = iter(process.stderr.readline, "")
            assert any("bag_0.mcap was deleted or moved" in line for line in lines)
            limit.cancel()
            process.send_signal(signal.SIGINT)
            process.communicate(timeout=20)
        finally:
            process.kill()
    assert process.returncode == 1


def test_dropped_messages_end_with_1(tmp_path, monkeypatch, capsys):
    class Recorder:
        summary = "5 messages recorded, 3 dropped because of the disk"
        dropped = 3

    monkeypatch.setattr("bdt_bags.recorder.recorder_node.RecorderNode", Recorder)
    monkeypatch.setattr(
        "bdt_msgs_py.node_main.run_node", lambda create, _, spin: 0 * bool(create())
    )
    assert run_command(["record", "--output", str(tmp_path / "bag")]) == 1
    assert "is incomplete, the disk did not take all" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        (["--storage", "tape"], "--storage = 'tape': must be one of mcap, sqlite3"),
        (["--compression", "lz4"], "--compression = 'lz4': must be one of none, zstd"),
        (["--split-size", "-1"], "--split-size = -1 B: must be 0 to 1e+12 B"),
        (["--split-duration", "nan"], "--split-duration = nan s: must be 0 to 1e+06 s"),
        (["--output", "."], "--output .: exists already"),
        (["0bad"], "parameter topics = '0bad'"),
    ],
)
def test_bad_options_are_refused_in_one_line(tmp_path, capsys, options, reason, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert run_command(["record", *options]) == 2
    error = capsys.readouterr().err
    assert error.startswith("error: ")
    assert reason in error
    assert error.count("\n") == 1
    assert list(tmp_path.iterdir()) == []
