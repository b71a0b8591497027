"""Which commands a plant obeys."""

import pytest

from bdt_msgs_py.awaited_commands import AwaitedCommands
from bdt_msgs_py.message_checks import VoltageCommand
from bdt_msgs_py.rejection import MessageRejectedError, Reason

PERIOD = 2_000_000
TIMEOUT = 0.1


@pytest.fixture
def commands():
    """Two measurements that await an answer."""
    commands = AwaitedCommands(TIMEOUT)
    for stamp in (0, PERIOD):
        commands.published(stamp, 0, now=0.0)
    return commands


def is_rejected(commands, reason, stamp, voltage=1.0, source="/controller", now=0.0):
    with pytest.raises(MessageRejectedError) as caught:
        commands.accept(VoltageCommand(stamp, voltage, source), now)
    assert caught.value.reason is reason
    return str(caught.value)


def test_the_answer_to_a_measurement_is_obeyed_once(commands):
    command = VoltageCommand(PERIOD, 1.0, "/controller")
    assert commands.accept(command, 0.0)
    assert not commands.accept(command, 0.0)


@pytest.mark.parametrize("stamp", [1, 2 * PERIOD, (2**31 - 1) * 10**9])
def test_what_answers_nothing_is_rejected(commands, stamp):
    assert "awaits no answer" in is_rejected(commands, Reason.TIME, stamp)


def test_another_answer_to_the_same_measurement_is_rejected(commands):
    commands.accept(VoltageCommand(PERIOD, 1.0, ""), 0.0)
    text = is_rejected(commands, Reason.REPEATED, PERIOD, 2.0, "")
    assert text == "stamp 0.002 s: a measurement of this time is answered already"


def test_an_older_measurement_needs_no_answer_any_more(commands):
    commands.accept(VoltageCommand(PERIOD, 1.0, "/controller"), 0.0)
    is_rejected(commands, Reason.TIME, 0)


def test_what_is_too_old_is_forgotten(commands):
    commands.published(2 * PERIOD, PERIOD, now=0.0)
    is_rejected(commands, Reason.TIME, 0)
    assert commands.accept(VoltageCommand(PERIOD, 1.0, ""), 0.0)


def test_the_first_source_is_obeyed_and_no_other(commands):
    commands.accept(VoltageCommand(0, 1.0, "/controller"), 0.0)
    text = is_rejected(commands, Reason.SOURCE, PERIOD, 1.0, "/other")
    assert text == "from '/other': commands are taken from '/controller' alone"
    assert commands.accept(VoltageCommand(PERIOD, 1.0, "/controller"), 0.0)


def test_a_command_that_answers_nothing_is_too_early_or_late_whoever_sends_it(commands):
    commands.accept(VoltageCommand(PERIOD, 1.0, "/controller"), 0.0)
    is_rejected(commands, Reason.TIME, 10**9, source="/other")
    is_rejected(commands, Reason.SOURCE, PERIOD, source="/other")


def test_another_source_takes_over_when_an_answer_has_not_come_for_a_while(commands):
    commands.accept(VoltageCommand(PERIOD, 1.0, "/controller"), 0.0)
    # A plant that waits for somebody else asks nothing: silence is none then.
    commands.published(2 * PERIOD, 0, now=50.0)
    commands.published(2 * PERIOD, 0, now=50.09)
    is_rejected(commands, Reason.SOURCE, 2 * PERIOD, 1.0, "/other", now=50.09)
    assert commands.accept(VoltageCommand(2 * PERIOD, 1.0, "/other"), 50.11)
    commands.published(3 * PERIOD, 0, now=50.11)
    is_rejected(commands, Reason.SOURCE, 3 * PERIOD, 1.0, "/controller", now=50.12)
