"""``ros2 bag`` as a process: bags that rosbag2 reads, played at the pace of their recording."""

import re
import signal
import subprocess

import pytest
import yaml
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message, serialize_message
from ros2_commands import COMMAND, TIMEOUT_S, ros2_processes
from rosbags.interfaces import (
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)
from rosbags.rosbag2 import Reader, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Float64, String

LATCHED = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)
BEST_EFFORT = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
STRING_HASH = "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"
#: Of the bag that is played: eleven numbers, one every 50 ms.
START_NS = 1_700_000_000_000_000_000
STEP_NS = 50_000_000
COUNT = 11
FOREVER = QosTime(9223372036, 854775807)


def start(*words):
    return subprocess.Popen(
        [*COMMAND, "bag", *map(str, words)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def bag_all(*commands):
    """Run verbs of ``ros2 bag`` at the same time; output, errors and exit code of each."""
    return ros2_processes(*(("bag", *map(str, words)) for words in commands))


@pytest.fixture
def robot(ros):
    """Node whose messages are recorded."""
    return ros.create(Node, "robot")


class Recording:
    """A recorder that runs while messages are published."""

    def __init__(self, ros, *words):
        self.ros = ros
        self.process = start("record", *words)

    def wait_for(self, publisher):
        """Wait until the recorder has subscribed."""
        self.ros.spin_until(publisher.get_subscription_count)

    def stop(self, number=signal.SIGINT):
        """End it with a signal; its log."""
        self.process.send_signal(number)
        _, log = self.process.communicate(timeout=TIMEOUT_S)
        assert self.process.returncode == 0, log
        return log

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.communicate()


def read(path):
    """Metadata and messages by topic."""
    metadata = yaml.safe_load((path / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    messages = {}
    with Reader(path) as reader:
        for connection, _, payload in reader.messages():
            kind = {"std_msgs/msg/String": String, "std_msgs/msg/Float64": Float64}
            message = deserialize_message(payload, kind[connection.msgtype])
            messages.setdefault(connection.topic, []).append(message.data)
    return metadata, messages


def test_a_recording_is_a_bag_of_rosbag2(ros, robot, tmp_path):
    latched = robot.create_publisher(String, "latched", LATCHED)
    latched.publish(String(data="kept"))
    numbers = robot.create_publisher(Float64, "numbers", BEST_EFFORT)
    path = tmp_path / "bag"
    with Recording(ros, "-o", path, "/latched", "numbers", "later", "--custom-data", "a=b") as run:
        run.wait_for(latched)
        run.wait_for(numbers)
        # Topics that are new while the recording runs are recorded, too.
        later = robot.create_publisher(String, "later", 10)
        run.wait_for(later)
        later.publish(String(data="new"))
        assert later.wait_for_all_acked()
        numbers.publish(Float64(data=0.5))
        latched.publish(String(data="and sent"))
        assert latched.wait_for_all_acked()
        log = run.stop()
    assert "Subscribed to topic '/later'" in log
    metadata, messages = read(path)
    assert messages == {"/latched": ["kept", "and sent"], "/numbers": [0.5], "/later": ["new"]}
    assert metadata["version"] == 9
    assert metadata["storage_identifier"] == "mcap"
    assert metadata["message_count"] == 4
    assert metadata["custom_data"] == {"a": "b"}
    topics = {
        item["topic_metadata"]["name"]: item["topic_metadata"]
        for item in metadata["topics_with_message_count"]
    }
    assert topics["/latched"]["type_description_hash"] == STRING_HASH
    (qos,) = topics["/latched"]["offered_qos_profiles"]
    assert (qos["reliability"], qos["durability"]) == ("reliable", "transient_local")
    assert qos["deadline"] == {"sec": 9223372036, "nsec": 854775807}
    (qos,) = topics["/numbers"]["offered_qos_profiles"]
    assert (qos["reliability"], qos["durability"]) == ("best_effort", "volatile")


def test_everything_is_recorded_into_sqlite(ros, robot, tmp_path):
    words = robot.create_publisher(String, "words", 10)
    secret = robot.create_publisher(String, "_secret", 10)
    left_out = robot.create_publisher(String, "left_out", 10)
    path = tmp_path / "bag"
    with Recording(ros, "-a", "-s", "sqlite3", "-o", path, "--exclude-topics", "/left_out") as run:
        run.wait_for(words)
        words.publish(String(data="hello"))
        assert words.wait_for_all_acked()
        assert not secret.get_subscription_count()
        assert not left_out.get_subscription_count()
        run.stop(signal.SIGTERM)
    metadata, messages = read(path)
    assert metadata["storage_identifier"] == "sqlite3"
    assert messages == {"/words": ["hello"]}


def test_a_publisher_that_offers_less_is_told(ros, robot, tmp_path):
    words = robot.create_publisher(String, "words", 10)
    with Recording(ros, "-e", "w.rd", "-o", tmp_path / "bag") as run:
        run.wait_for(words)
        robot.create_publisher(String, "words", BEST_EFFORT)
        lines = []
        while "it offers BEST_EFFORT" not in "".join(lines):
            lines.append(run.process.stderr.readline())
            assert lines[-1], "the recorder has ended"
        run.stop()
    assert "A new publisher of '/words' is not recorded" in lines[-1]


def offered(reliability=QosReliability.RELIABLE, durability=QosDurability.VOLATILE):
    return Qos(
        QosHistory.UNKNOWN,
        0,
        reliability,
        durability,
        FOREVER,
        FOREVER,
        QosLiveliness.AUTOMATIC,
        FOREVER,
        False,
    )


@pytest.fixture
def recorded(tmp_path):
    """Bag with numbers, a latched word in their middle, a clock and a topic of unknown type."""
    path = tmp_path / "recorded"
    store = get_typestore(Stores.ROS2_JAZZY)
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        numbers = writer.add_connection(
            "/numbers", "std_msgs/msg/Float64", typestore=store, offered_qos_profiles=[offered()]
        )
        latched = writer.add_connection(
            "/latched",
            "std_msgs/msg/String",
            typestore=store,
            offered_qos_profiles=[offered(durability=QosDurability.TRANSIENT_LOCAL)],
        )
        clock = writer.add_connection("/clock", "rosgraph_msgs/msg/Clock", typestore=store)
        unknown = writer.add_connection(
            "/unknown", "my_msgs/msg/Mine", msgdef="int8 x", rihs01="RIHS01_00"
        )
        writer.write(clock, START_NS, serialize_message(Clock()))
        writer.write(unknown, START_NS, b"\0\1\0\0\0")
        for k in range(COUNT):
            if k == COUNT // 2:
                text = serialize_message(String(data="kept"))
                writer.write(latched, START_NS + k * STEP_NS, text)
            payload = serialize_message(Float64(data=float(k)))
            writer.write(numbers, START_NS + k * STEP_NS, payload)
    return path


def test_information(recorded):
    (out, errors, code), names = bag_all(("info", recorded), ("info", "-t", recorded))
    assert (errors, code) == ("", 0)
    assert re.fullmatch(
        r"\n"
        r"Files:             recorded\.mcap\n"
        r"Bag size:          \d+\.\d KiB\n"
        r"Storage id:        mcap\n"
        r"ROS Distro:        rosbags\n"
        r"Duration:          0\.500000000s\n"
        r"Start:             Nov 1[45] 2023 \d\d:\d\d:20\.000000000 \(1700000000\.000000000\)\n"
        r"End:               Nov 1[45] 2023 \d\d:\d\d:20\.500000000 \(1700000000\.500000000\)\n"
        r"Messages:          14\n"
        r"Topic information: Topic: /numbers \| Type: std_msgs/msg/Float64 \| Count: 11 \| "
        r"Serialization Format: cdr\n"
        r"                   Topic: /latched \| Type: std_msgs/msg/String \| Count: 1 \| "
        r"Serialization Format: cdr\n"
        r"(                   Topic: .*\n){2}"
        r"Service:           0\n"
        r"Service information: \n",
        out,
    )
    assert names == ("/numbers\n/latched\n/clock\n/unknown\n", "", 0)


class Listener:
    """What arrives, and when it was published."""

    def __init__(self, ros, latched="latched"):
        self.ros = ros
        self.numbers, self.times, self.texts, self.clock = [], [], [], []
        node = ros.create(Node, "listener")
        node.create_subscription(Float64, "numbers", self._number, 100)
        node.create_subscription(String, latched, lambda m: self.texts.append(m.data), LATCHED)
        node.create_subscription(Clock, "clock", lambda m: self.clock.append(m.clock), 100)

    def _number(self, message, information):
        self.numbers.append(message.data)
        self.times.append(information["source_timestamp"] / 1e9)

    def hear(self, *words):
        """Listen to a player until it ends; its errors."""
        with start("play", *words) as process:
            self.ros.spin_until(lambda: process.poll() is not None)
            self.ros.spin_for(0.1)
            _, errors = process.communicate(timeout=TIMEOUT_S)
        assert process.returncode == 0, errors
        return errors


def test_a_bag_is_played_as_it_was_recorded(ros, recorded):
    listener = Listener(ros)
    errors = listener.hear(recorded)
    assert listener.numbers == [float(k) for k in range(COUNT)]
    assert listener.texts == ["kept"]
    assert [stamp.sec for stamp in listener.clock] == [0]
    assert listener.times[-1] - listener.times[0] > 0.4
    assert "'/unknown' is not played: Unknown message type 'my_msgs/msg/Mine'" in errors
    assert errors.count("\n") == 1


def test_a_bag_is_played_faster_with_a_clock_from_its_middle(ros, recorded):
    listener = Listener(ros, latched="renamed")
    listener.hear(
        *(recorded, "-r", "2", "--clock", "100", "--start-offset", "0.2"),
        *("--remap", "latched:=renamed"),
    )
    assert listener.numbers == [float(k) for k in range(4, COUNT)]
    assert listener.texts == ["kept"]
    assert listener.times[-1] - listener.times[0] > 0.1
    # The clock of the bag is not played: the player's own takes its place. At twice the pace,
    # 100 Hz are steps of 0.02 s; of a clock that is late only the newest message counts.
    seconds = [stamp.sec - START_NS // 10**9 + stamp.nanosec * 1e-9 for stamp in listener.clock]
    steps = [round((second - 0.2) / 0.02) for second in seconds]
    assert seconds == pytest.approx([0.2 + 0.02 * step for step in steps], abs=1e-6)
    assert steps == sorted(set(steps) & set(range(17)))
    assert steps


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_chosen_topics_are_played_again_and_again(ros, recorded, number):
    listener = Listener(ros)
    with start("play", "-l", "-r", "4", recorded, "--topics", "numbers") as process:
        ros.spin_until(lambda: len(listener.numbers) > 2 * COUNT)
        process.send_signal(number)
        assert process.communicate(timeout=TIMEOUT_S) == ("", "")
    assert process.returncode == 0
    assert listener.numbers[: 2 * COUNT] == [float(k % COUNT) for k in range(2 * COUNT)]
    assert listener.texts == []


def test_bags_that_are_none(tmp_path):
    damaged, empty, folder = tmp_path / "a.mcap", tmp_path / "b.db3", tmp_path / "c"
    incomplete, not_text = tmp_path / "d", tmp_path / "e"
    damaged.write_bytes(b"\x89MCAP0\r\nnothing")
    empty.touch()
    folder.mkdir()
    incomplete.mkdir()
    (incomplete / "metadata.yaml").write_text("rosbag2_bagfile_information: {version: 9}")
    not_text.mkdir()
    (not_text / "metadata.yaml").write_bytes(b"\xff\xfe")
    missing, nothing, without, *unreadable = bag_all(
        ("play", "/nothing"),
        ("info", "/nothing"),
        ("play", folder),
        ("info", damaged),
        ("info", empty),
        ("info", incomplete),
        ("info", not_text),
    )
    for _, errors, code in (missing, nothing):
        assert "argument bag_path: there is no '/nothing'" in errors
        assert (errors.count("\n"), code) == (1, 2)
    assert without == ("", f"{folder} is no bag: it has no metadata.yaml\n", 1)
    for path, (out, errors, code) in zip(
        (damaged, empty, incomplete, not_text), unreadable, strict=True
    ):
        assert errors.startswith(f"Could not open bag {path}: ")
        assert (out, errors.count("\n"), code) == ("", 1, 1), errors


def test_damage_in_the_middle_of_a_bag_is_one_line(ros, recorded):
    (path,) = recorded.glob("*.mcap")
    content = bytearray(path.read_bytes())
    # What is behind the summary's message counts is not looked at before it is played.
    payload = serialize_message(String(data="kept"))
    content[content.index(payload) - 31 : content.index(payload)] = b"\xff" * 31
    path.write_bytes(content)
    ((out, errors, code),) = bag_all(("play", "-r", "10", recorded))
    assert out == ""
    assert errors.splitlines()[-1].startswith(f"Could not read bag {recorded}: ")
    assert "Traceback" not in errors
    assert code == 1


def test_recordings_that_cannot_be():
    cases = {
        (): "Name topics to record, or use --all, --regex or --topic-types",
        ("-a", "-o", "."): "'.' already exists; a recording needs a new folder",
        ("-a", "--use-sim-time", "--no-discovery"): "--use-sim-time needs /clock",
        ("-a", "--custom-data", "note"): "--custom-data takes KEY=VALUE, not 'note'",
        ("/a", "--topics", "/b"): "Give topics either after --topics or without it",
        ("-a", "-o", "/proc/bag"): "Could not write bag '/proc/bag': ",
        ("-e", "("): "--regex is no regular expression: ",
        ("-a", "-s", "paper"): "invalid choice: 'paper' (choose from ",
    }
    results = bag_all(*(("record", *words) for words in cases))
    for complaint, (out, errors, code) in zip(cases.values(), results, strict=True):
        assert complaint in errors
        assert out == ""
        if "invalid choice" in complaint:
            assert code == 2
        else:
            assert (errors.count("\n"), code) == (1, 1)
