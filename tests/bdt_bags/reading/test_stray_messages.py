"""One message of a stranger on a topic of the loop: left out, counted, and nothing else changes."""

import json
from dataclasses import fields

import numpy as np
import pytest

from bdt_bags.bag_error import BagError
from bdt_bags.reading.completeness import lost_messages
from bdt_bags.reading.recording import Recording, load_recording
from bdt_bringup.cli import run_command
from bdt_msgs_py.topics import (
    BACKLASH_ESTIMATE,
    CLOCK,
    COMMAND,
    DEAD_ZONE_JOINT,
    GAP_JOINT,
    MEASUREMENT,
    MOTOR_JOINT,
    PLATFORM_JOINT,
    REFERENCE,
    TELEMETRY,
    TELEMETRY_COLUMNS,
    TRUTH,
    TRUTH_COLUMNS,
)

WHEN = 1.005
"""Time at which a stray is received [s]."""
TIMES = {
    "late past": 0.4137,
    "past, at the time of a sample": 0.4,
    "before the run": -1.0,
    "long past": -1e6,
    "near future": 1.3137,
    "future, at the time of a sample": 1.4,
    "future": 50.0,
    "milliseconds": 1005.0,
    "far future": 2e9,
}
FEW = ("late past", "future", "far future")
ROWS = {TELEMETRY: TELEMETRY_COLUMNS, TRUTH: TRUTH_COLUMNS}
JOINTS = {
    MEASUREMENT: (PLATFORM_JOINT, "position"),
    COMMAND: (MOTOR_JOINT, "effort"),
    REFERENCE: (PLATFORM_JOINT, "position"),
    BACKLASH_ESTIMATE: (GAP_JOINT, "position"),
}


def rows_at(messages, topic, *times):
    columns = ROWS[topic]
    return messages.rows_message(
        np.array([[time, *range(1, len(columns))] for time in times]), columns
    )


def joint_at(messages, topic, time, value=7.0):
    joint, quantity = JOINTS[topic]
    return messages.joint_message(joint, time, **{quantity: [value]})


def at(messages, topic, time):
    """Return a message of one time."""
    return rows_at(messages, topic, time) if topic in ROWS else joint_at(messages, topic, time)


def copy(messages, topic, number=3):
    """Return another object with the content of a message of a topic."""
    name = "/" + topic.name.lstrip("/")
    found = [item for item in messages.items if item[0] == name][number]
    store, kind = messages.store, found[1]
    return store.deserialize_cdr(store.serialize_cdr(found[3], kind), kind)


def second_source(messages, topic):
    """Return a message for the time of another one, with other values."""
    message = copy(messages, topic)
    if topic in ROWS:
        rows = message.data.reshape(-1, len(ROWS[topic])).copy()
        rows[:, 1:] += 1.0
        message.data = rows.ravel()
    else:
        quantity = JOINTS[topic][1]
        setattr(message, quantity, getattr(message, quantity) + 1.0)
    return message


def malformed(messages, topic):
    """Yield messages that do not say what the topic is for."""
    if topic in ROWS:
        good = rows_at(messages, topic, WHEN, WHEN + 0.1)
        yield "labels", messages.rows_message(good.data.reshape(2, -1)[:, :2], ("t[s]", "x"))
        short = rows_at(messages, topic, WHEN, WHEN + 0.1)
        short.data = short.data[:-1]
        yield "one number missing", short
        plain = rows_at(messages, topic, WHEN)
        plain.layout.dim = []
        yield "no layout", plain
        yield "no rows", messages.rows_message(np.empty((0, len(ROWS[topic]))), ROWS[topic])
        yield "no time", rows_at(messages, topic, np.nan, np.nan)
        yield "infinite time", rows_at(messages, topic, np.inf)
        yield "huge time", rows_at(messages, topic, 1e300)
        yield "time goes back in it", rows_at(messages, topic, 1.4, 1.3)
        return
    quantity = JOINTS[topic][1]
    yield "another joint", messages.joint_message("elbow", WHEN, **{quantity: [1.0]})
    yield "no value", messages.joint_message(JOINTS[topic][0], WHEN)
    twice = joint_at(messages, topic, WHEN)
    twice.name = twice.name * 2
    yield "a name too many", twice
    empty = messages.joint_message("", WHEN)
    empty.name = []
    yield "nothing", empty
    if topic in (REFERENCE, BACKLASH_ESTIMATE):
        yield "not a number", joint_at(messages, topic, WHEN, np.nan)
        yield "infinite", joint_at(messages, topic, WHEN, np.inf)


def strays(messages):
    """Yield (topic, name, message) of all strays."""
    for topic in (TELEMETRY, TRUTH, MEASUREMENT, COMMAND):
        for name, time in TIMES.items():
            yield topic, name, at(messages, topic, time)
        yield topic, "second source", second_source(messages, topic)
        if topic in ROWS:
            yield topic, "rows that go on for ever", rows_at(messages, topic, 1.0001, 3e8)
    for name in ("future", "milliseconds"):
        yield BACKLASH_ESTIMATE, name, at(messages, BACKLASH_ESTIMATE, TIMES[name])
    estimate = copy(messages, BACKLASH_ESTIMATE, 0)
    estimate.name = [GAP_JOINT, DEAD_ZONE_JOINT, DEAD_ZONE_JOINT]
    estimate.position = np.array([0.1, 1e-5, 2e-5])
    yield BACKLASH_ESTIMATE, "a dead zone twice", estimate
    for topic in (*ROWS, *JOINTS):
        for name, message in malformed(messages, topic):
            yield topic, name, message


def assert_same(found: Recording, expected: Recording, *, but: tuple[str, ...]) -> None:
    for field in fields(Recording):
        if field.name in ("path", "message_counts", *but):
            continue
        values = [getattr(x, field.name) for x in (found, expected)]
        if field.name in ("measurements", "commands", "batches"):
            values = [x.stamps for x in values]
        np.testing.assert_equal(*values, err_msg=field.name)
    assert lost_messages(found) == lost_messages(expected)


@pytest.fixture(scope="module")
def loop(small_loop):
    messages = small_loop.without()
    for time in (0.2, 0.4, 0.8, 1.2):
        messages.estimate(time, 0.1 + time / 100)
    return messages


@pytest.fixture(scope="module")
def clean(loop, tmp_path_factory):
    return load_recording(loop.write(tmp_path_factory.mktemp("clean") / "bag"))


@pytest.mark.parametrize("received", [WHEN, 0.001, 2.5], ids=["during", "begin", "end"])
def test_a_stray_message_is_left_out_and_counted(loop, clean, tmp_path, received):
    cases = list(strays(loop))
    assert len(cases) > 60
    for number, (topic, name, message) in enumerate(cases):
        if received < WHEN and name == "second source":
            continue  # what comes first counts
        messages = loop.without()
        messages.add(topic, received, message)
        found = load_recording(messages.write(tmp_path / f"{number}"))
        assert found.left_out == {f"/{topic.name}": 1}, (topic.name, name)
        note = f"1 message of /{topic.name} is left out: it fits into no run"
        assert found.missing == (*clean.missing, note), (topic.name, name)
        assert_same(found, clean, but=("left_out", "missing"))


def test_the_table_of_strays_is_the_one_of_the_documentation(loop):
    """One of each kind for each topic; nothing on the clock is read at all."""
    kinds = {(topic.name, name) for topic, name, _ in strays(loop)}
    assert {name for name, _ in kinds} == {
        x.name for x in (TELEMETRY, TRUTH, MEASUREMENT, COMMAND, REFERENCE, BACKLASH_ESTIMATE)
    }


@pytest.mark.parametrize("topic", [TELEMETRY, TRUTH, MEASUREMENT, COMMAND, REFERENCE])
def test_a_message_that_comes_twice_is_no_stray(loop, clean, tmp_path, topic):
    messages = loop.without()
    messages.add(topic, WHEN, copy(messages, topic, 1))
    found = load_recording(messages.write(tmp_path / "bag"))
    assert found.left_out == {}
    times = {TELEMETRY: "batches", MEASUREMENT: "measurements", COMMAND: "commands"}
    assert_same(found, clean, but=("reference", times.get(topic, "")))


@pytest.mark.parametrize("time", [-1, 0, 2**31 - 1])
def test_a_clock_of_another_world_changes_nothing(loop, clean, tmp_path, time):
    messages = loop.without()
    clock = copy(messages, CLOCK, 0)
    clock.clock.sec = time
    messages.add(CLOCK, WHEN, clock)
    assert_same(load_recording(messages.write(tmp_path / "bag")), clean, but=())


@pytest.mark.parametrize("dropped", [(), (MEASUREMENT, COMMAND), (TELEMETRY, TRUTH)])
def test_runs_are_told_apart_past_strays(loop, shortest_loop, tmp_path, dropped):
    both = loop.without()
    both.items.extend(
        (name, kind, t + 8.0, message) for name, kind, t, message in shortest_loop.items
    )
    bare = both.without(*dropped)
    bare.write(tmp_path / "clean")
    expected = [load_recording(tmp_path / "clean", run=number) for number in (1, 2)]
    for topic in (TELEMETRY, MEASUREMENT, COMMAND):
        for name in FEW:
            for received in (WHEN, 8.1):
                both.add(topic, received, at(both, topic, TIMES[name] + 1e-4))
    bag = both.without(*dropped).write(tmp_path / "bag")
    with pytest.raises(BagError, match="holds 2 runs, choose one with bdt analyze --run 1 to"):
        load_recording(bag)
    for number in (1, 2):
        found = load_recording(bag, run=number)
        assert_same(found, expected[number - 1], but=("left_out", "missing"))
        assert set(found.left_out.values()) == {len(FEW)}


@pytest.mark.parametrize("topic", [TELEMETRY, MEASUREMENT])
def test_two_sources_of_equal_right_are_refused(loop, tmp_path, topic):
    messages = loop.without()
    for name, kind, received, _ in loop.items:
        if name == f"/{topic.name}":
            if topic in ROWS:
                message = rows_at(messages, topic, received - 0.05, received - 0.01)
            else:
                message = joint_at(messages, topic, received + 0.5)
            messages.items.append((name, kind, received + 1e-3, message))
    with pytest.raises(BagError, match=r"messages that do not fit the other \d+: must be of one"):
        load_recording(messages.write(tmp_path / "bag"))


@pytest.mark.parametrize("topic", [TELEMETRY, MEASUREMENT, REFERENCE, BACKLASH_ESTIMATE])
def test_a_topic_of_nothing_but_malformed_messages_is_refused(loop, tmp_path, topic):
    messages = loop.without(topic)
    for name, message in malformed(loop, topic):
        if name not in ("not a number", "infinite"):
            messages.add(topic, WHEN, message)
    with pytest.raises(BagError, match=rf"message 0 of /{topic.name}: .* must"):
        load_recording(messages.write(tmp_path / "bag"))


def test_what_is_left_out_stands_in_summary_report_and_terminal(loop, tmp_path, capsys):
    messages = loop.without()
    messages.add(TELEMETRY, WHEN, at(messages, TELEMETRY, 3e8))
    messages.add(TELEMETRY, WHEN, at(messages, TELEMETRY, -3e8))
    messages.add(COMMAND, WHEN, at(messages, COMMAND, 50.0))
    bag, output = messages.write(tmp_path / "bag"), tmp_path / "report"
    assert run_command(["analyze", str(bag), "--output", str(output)]) == 0
    told = "1 message of /command is left out: it fits into no run; "
    told += "2 messages of /telemetry are left out: they fit into no run"
    assert told in capsys.readouterr().out
    assert told in (output / "report.html").read_text(encoding="utf-8")
    summary = json.loads((output / "summary.json").read_text(encoding="utf-8"))
    assert summary["messages_left_out"] == {"/command": 1, "/telemetry": 2}
