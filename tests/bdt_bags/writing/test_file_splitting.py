"""Where a bag is cut into files: by size, by time of reception, never before a first message."""

from hypothesis import given
from hypothesis import strategies as st

from bdt_bags.writing.file_splitting import MESSAGE_OVERHEAD, SMALLEST_PIECE, FileSplitting
from bdt_bags.writing.metadata_file import FileInformation
from bdt_bags.writing.topic_metadata import SerializedMessage


def message(received, length=10):
    return SerializedMessage(0, received, received, bytes(length))


def filled(*received):
    file = FileInformation("bag_0.mcap")
    for each in received:
        file.add(each)
    return file


def test_without_limits_everything_goes_into_one_file():
    splitting = FileSplitting()
    waiting = [message(time) for time in range(1000)]
    assert not splitting.is_full(filled(0), 1 << 40, message(1 << 60))
    assert splitting.next_piece(filled(0), 1 << 40, waiting) == waiting


def test_a_file_without_a_message_is_never_full():
    splitting = FileSplitting(size=1, duration=1)
    assert not splitting.is_full(filled(), 1000, message(5))
    assert splitting.next_piece(filled(), 1000, [message(5)]) == [message(5)]


def test_a_file_ends_before_the_message_that_comes_its_duration_after_the_first():
    splitting = FileSplitting(duration=100)
    assert not splitting.is_full(filled(50), 0, message(149))
    assert splitting.is_full(filled(50), 0, message(150))
    waiting = [message(time) for time in (60, 149, 150, 151)]
    assert splitting.next_piece(filled(50), 0, waiting) == waiting[:2]


def test_a_file_of_the_wanted_size_is_full():
    splitting = FileSplitting(size=1000)
    assert not splitting.is_full(filled(0), 999, message(1))
    assert splitting.is_full(filled(0), 1000, message(1))


@given(
    lengths=st.lists(st.integers(0, 3 * SMALLEST_PIECE), min_size=1, max_size=30),
    size=st.integers(1, 1 << 22),
    written=st.integers(0, 1 << 22),
)
def test_a_piece_exceeds_the_room_by_one_message_at_most(lengths, size, written):
    waiting = [message(number, length) for number, length in enumerate(lengths)]
    piece = FileSplitting(size=size).next_piece(filled(), written, waiting)
    assert piece
    assert piece == waiting[: len(piece)]
    room = max(size - written, SMALLEST_PIECE)
    taken = [len(each.data) + MESSAGE_OVERHEAD for each in piece]
    assert sum(taken[:-1]) <= room
    assert len(piece) == len(waiting) or sum(taken) > room
