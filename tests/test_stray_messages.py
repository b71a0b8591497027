"""One stray message must not drive the motor: every topic, every field, every fault, in the loop.

What each node did is kept in ``docs/source/reference/stray_messages.json``, and the table of the
documentation is made of it. ``make stray-messages`` writes both anew.
"""

import json
import os

import numpy as np
import pytest
from disturbed_loop import DisturbedLoop
from stray_messages import REFERENCE_STRAYS, SECOND_REFERENCE, STRAYS
from stray_table import TABLE, TABLE_DATA, markdown_table, table_row

# A module of it: in a checkout the folder of that name counts as a package.
pytest.importorskip(
    "embedded_ros.session",
    reason="rclpy's executor is too slow for this many nodes: six steps a second",
)

BEGIN = 1.5
SPACING = 0.3
"""Simulated time of the first stray, and from one to the next [s]."""
CLOSE = 5e-6
"""How near the loop is to one that was not disturbed, one second after the last stray [m]."""
VOLTAGE_LIMIT, POSITION_LIMIT = 40.0, 0.02

LOOPS = {
    "square": (STRAYS, []),
    "topic": (REFERENCE_STRAYS, [SECOND_REFERENCE]),
}
"""Strays for each kind of reference, and what is obeyed because it cannot be told apart."""


@pytest.fixture(scope="module", params=LOOPS)
def disturbed(request, ros_loops, tmp_path_factory):
    """Return a loop with strays in it, one that was left alone, and what each node did."""
    reference = request.param
    strays, obeyed = LOOPS[reference]
    folder = tmp_path_factory.mktemp(reference)
    end = BEGIN + SPACING * len(strays) + 1.0
    duration = round(end + 1.0, 1)
    arguments = duration, VOLTAGE_LIMIT, POSITION_LIMIT, reference
    loop = DisturbedLoop(ros_loops(), folder / "disturbed", *arguments)
    rows = []
    for number, stray in enumerate(strays):
        loop.run_until(BEGIN + SPACING * number)
        rows.append(table_row(stray, loop.disturb(stray)))
    loop.run_until(end)
    rows += [table_row(stray, loop.disturb(stray)) for stray in obeyed]
    loop.finish()
    expected = DisturbedLoop(ros_loops(), folder / "alone", *arguments)
    expected.finish()
    return loop, expected, end, rows


def test_one_second_after_the_last_stray_the_loop_is_where_it_was(disturbed):
    loop, expected, end, _ = disturbed
    actual, alone = (one.samples(end) for one in (loop, expected))
    assert len(actual) == len(alone)
    assert np.abs(actual[-5:, 2] - alone[-5:, 2]).max() < CLOSE


def test_on_the_way_there_it_is_never_elsewhere(disturbed):
    """In lockstep nothing that is rejected leaves a trace, not in the last bit."""
    loop, expected, end, _ = disturbed
    actual, alone = (one.samples(end) for one in (loop, expected))
    np.testing.assert_array_equal(actual, alone)


def test_voltage_and_position_stay_within_the_limits_also_for_what_is_obeyed(disturbed):
    loop, _, _, _ = disturbed
    samples = loop.samples()
    assert np.abs(samples[:, 1]).max() <= VOLTAGE_LIMIT
    assert np.abs(samples[:, 2]).max() <= POSITION_LIMIT


def test_the_diagnostics_name_every_topic_and_reason_of_what_was_rejected(disturbed):
    loop, _, _, rows = disturbed
    for node in ("plant", "controller", "twin", "recorder"):
        said = loop.diagnostics_of(node)
        for row in rows:
            _, _, reasons = row[node].partition("rejected: ")
            for reason in filter(None, reasons.split(", ")):
                assert (
                    f"{row['topic'].lstrip('/')} {reason}: " in said["rejected_messages_by_reason"]
                )
        assert said["last_rejected_message"] or not int(said["rejected_messages"])


def test_each_node_does_what_the_documentation_says(disturbed):
    _, _, _, rows = disturbed
    documented = json.loads(TABLE_DATA.read_text()) if TABLE_DATA.exists() else []
    if "WRITE_STRAY_MESSAGES" in os.environ:
        own = [row["topic"] for row in rows]
        topic = REFERENCE_STRAYS[0].topic.name
        others = [row for row in documented if (row["topic"] == topic) is not (own[0] == topic)]
        documented = sorted([*others, *rows], key=lambda row: row["topic"].lstrip("/"))
        TABLE_DATA.parent.mkdir(parents=True, exist_ok=True)
        TABLE_DATA.write_text(json.dumps(documented, indent=1) + "\n")
        TABLE.write_text(markdown_table(documented))
    assert [row for row in rows if row not in documented] == []


def test_the_table_of_the_documentation_is_made_of_what_was_found():
    documented = json.loads(TABLE_DATA.read_text())
    assert TABLE.read_text() == markdown_table(documented)
    strays = [*STRAYS, *REFERENCE_STRAYS, SECOND_REFERENCE]
    found = {(row["topic"], row["field"], row["fault"]) for row in documented}
    assert found == {(stray.topic.name, stray.field, stray.fault) for stray in strays}
