"""The folder: whole parts alone, for anybody's reader, and nobody else's."""

import errno
import json

import pytest

from bdt_msgs_py.command_errors import BadInputError

pa = pytest.importorskip("pyarrow", reason="beside a ROS 2 without pyarrow")

from pyarrow import dataset  # noqa: E402

from bdt_study.engine import part_folder  # noqa: E402
from bdt_study.engine.part_folder import Identity, PartFolder, part_name  # noqa: E402


class Letters(PartFolder):
    """A folder with a letter in each part."""

    def __init__(self, folder, count=4, **changes):
        text = json.dumps({"to": "aunt", "language": "en"} | changes)
        super().__init__(folder, Identity("correspondence", "plan.json", text), count)

    def table(self, result):
        return pa.table({"letter": [result]})


@pytest.fixture
def letters(tmp_path):
    return Letters(tmp_path / "letters")


def test_parts_are_read_by_anybody_whatever_the_order_in_which_they_came(letters):
    letters.create(resume=False)
    for number in (3, 0, 2, 1):
        letters.write(number, "abcd"[number])
    read = dataset.dataset(letters.parts_folder).to_table()
    assert read.column("letter").to_pylist() == list("abcd")
    assert letters.missing() == []


def test_who_reads_while_a_part_is_written_sees_those_that_are_whole(letters, monkeypatch):
    letters.create(resume=False)
    letters.write(0, "a")
    seen = []

    def read(_):
        seen.append(dataset.dataset(letters.parts_folder).to_table().num_rows)

    monkeypatch.setattr(part_folder.os, "fsync", read)
    letters.write(1, "b")
    assert seen[0] == 1


def test_it_is_taken_up_with_the_parts_that_are_whole(letters):
    letters.create(resume=False)
    letters.write(1, "b")
    left = letters.parts_folder / f".{part_name(2)}.unfinished"
    left.write_bytes(b"half a part")
    letters.create(resume=True)
    assert letters.missing() == [0, 2, 3]
    assert not left.exists()


def test_more_parts_of_the_same_are_wanted_later(letters):
    letters.create(resume=False)
    letters.write(0, "a")
    more = Letters(letters.folder, count=6)
    more.create(resume=True)
    assert more.missing() == [1, 2, 3, 4, 5]


@pytest.mark.parametrize("left", [None, ".plan.json.unfinished", "plan.json"])
def test_what_was_killed_at_its_very_beginning_begins_anew(letters, left):
    if left == "plan.json":
        letters.create(resume=False)
        letters.parts_folder.rmdir()
    else:
        letters.folder.mkdir()
    if left == ".plan.json.unfinished":
        (letters.folder / left).write_text("{")
    letters.create(resume=True)
    assert letters.missing() == [0, 1, 2, 3]


def test_a_folder_that_holds_parts_needs_to_be_told_to_go_on(letters):
    letters.create(resume=False)
    told = "already holds this correspondence: go on with --resume"
    with pytest.raises(BadInputError, match=told):
        letters.create(resume=False)


def test_parts_of_another_plan_are_left_alone(letters):
    letters.create(resume=False)
    told = "is the data set of another plan or version, which differs in to"
    with pytest.raises(BadInputError, match=told):
        Letters(letters.folder, to="uncle").create(resume=True)
    (letters.folder / "plan.json").write_text("{}")
    with pytest.raises(BadInputError, match=r"its plan\.json cannot be read"):
        letters.create(resume=True)


def test_a_folder_of_something_else_is_left_alone(letters):
    letters.folder.mkdir()
    (letters.folder / "aunt.txt").write_text("Dear aunt")
    with pytest.raises(BadInputError, match="holds something that is no correspondence"):
        letters.create(resume=True)
    (letters.folder / "aunt.txt").rename(letters.folder.with_name("file"))
    with pytest.raises(BadInputError, match=r"--output .*file"):
        Letters(letters.folder.with_name("file")).create(resume=True)


def test_a_full_disk_leaves_nothing_that_is_not_whole(letters, monkeypatch):
    letters.create(resume=False)

    def full(_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(part_folder.os, "fsync", full)
    with pytest.raises(OSError, match="No space left"):
        letters.write(0, "a")
    assert list(letters.parts_folder.iterdir()) == []
