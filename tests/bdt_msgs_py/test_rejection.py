"""Rejections: one line, counted by topic and reason, told at most once a second."""

from bdt_msgs_py.rejection import LONGEST_TEXT, MessageRejectedError, Reason, RejectedMessages
from bdt_msgs_py.topics import CLOCK, COMMAND


class Log:
    """Keeps what is logged."""

    def __init__(self):
        self.lines = []

    def warning(self, text, throttle_duration_sec):
        assert throttle_duration_sec == 1.0
        self.lines.append(text)


def test_what_a_stranger_wrote_stays_one_line_of_limited_length():
    error = MessageRejectedError(Reason.LAYOUT, "names\n\x1b[2J" + "x" * 10_000)
    assert "\n" not in str(error)
    assert "\x1b" not in str(error)
    assert len(str(error)) == LONGEST_TEXT


def test_rejections_are_counted_by_topic_and_reason():
    log = Log()
    rejected = RejectedMessages(log)
    assert rejected.values() == {
        "rejected_messages": 0,
        "rejected_messages_by_reason": "",
        "last_rejected_message": "",
    }
    rejected.count(COMMAND, MessageRejectedError(Reason.TIME, "late"))
    rejected.count(CLOCK, MessageRejectedError(Reason.STAMP, "negative"))
    rejected.count(COMMAND, MessageRejectedError(Reason.TIME, "later"))
    assert rejected.total == 3
    assert rejected.values() == {
        "rejected_messages": 3,
        "rejected_messages_by_reason": "clock stamp: 1, command time: 2",
        "last_rejected_message": "command: later",
    }
    assert log.lines[0] == "rejected command: late"
