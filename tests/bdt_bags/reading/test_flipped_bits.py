"""A bit that is flipped in a bag of ours shows: the bag is refused, or read as it was."""

import zlib

import numpy as np
import pytest
import yaml

from bdt_bags.bag_error import BagError
from bdt_bags.reading.bag_reader import read_bag
from bdt_bags.reading.recording import load_recording
from bdt_bags.recovery.recover_bag import recover_bag
from bdt_bags.writing.bag_files import BagFiles
from bdt_bags.writing.topic_metadata import SerializedMessage, topic_metadata
from bdt_msgs_py.topics import PARAMETER_EVENTS

KINDS = [("mcap", "none"), ("mcap", "zstd"), ("sqlite3", "none"), ("sqlite3", "zstd")]
FLIPS = 60


@pytest.fixture(scope="module")
def own_bag(shortest_loop, tmp_path_factory):
    """Return a function that writes the shortest loop as the recorder does."""

    def write(storage, compression):
        folder = tmp_path_factory.mktemp("own") / "bag"
        bag = BagFiles(folder, storage=storage, compression=compression)
        numbers = {}
        for name, kind, received, message in sorted(shortest_loop.items, key=lambda item: item[2]):
            if name not in numbers:
                numbers[name] = bag.add_topic(topic_metadata(name, kind, ""))
            data = bytes(shortest_loop.store.serialize_cdr(message, kind))
            time = round((1e9 + received) * 1e9)
            bag.append([SerializedMessage(numbers[name], time, time, data)])
        bag.close()
        return folder

    return write


def content(bag):
    raw = read_bag(bag)
    return raw.message_counts, {x.name: (x.received, x.data) for x in raw.topics.values()}


def storage_file(bag):
    (found,) = (file for file in bag.iterdir() if file.name != "metadata.yaml")
    return found


def unnoticed(bag, places):
    """Return at which of some places of its file a flipped bit changes what is read."""
    file, whole = storage_file(bag), content(bag)
    data = file.read_bytes()
    bits = np.random.default_rng(8)
    changed, refused = [], 0
    for place in places:
        flipped = bytearray(data)
        flipped[place] ^= 1 << bits.integers(8)
        file.write_bytes(flipped)
        try:
            if content(bag) != whole:
                changed.append(int(place))
        except BagError:
            refused += 1
    file.write_bytes(data)
    assert refused > len(places) / 3
    return changed


@pytest.mark.parametrize(("storage", "compression"), KINDS)
def test_no_flipped_bit_goes_unnoticed(own_bag, storage, compression):
    bag = own_bag(storage, compression)
    places = np.random.default_rng(7).integers(storage_file(bag).stat().st_size, size=FLIPS)
    assert unnoticed(bag, places) == []


def test_nor_does_one_outside_the_chunks_of_an_mcap(own_bag, mcap):
    """Index, topics and counts stand there: a flipped bit hid a topic."""
    bag = own_bag("mcap", "none")
    data = storage_file(bag).read_bytes()
    chunks = [(place, len(body)) for place, opcode, body in mcap.records(data) if opcode == 6]
    outside = np.ones(len(data), dtype=np.bool_)
    for place, length in chunks:
        outside[place + 9 : place + 9 + length] = False
    places = np.random.default_rng(9).choice(np.flatnonzero(outside), 3 * FLIPS, replace=False)
    assert unnoticed(bag, places) == []


def test_metadata_tell_the_checksum_of_a_sqlite_file_which_has_none(own_bag):
    bag = own_bag("sqlite3", "none")
    text = (bag / "metadata.yaml").read_text(encoding="utf-8")
    custom = yaml.safe_load(text)["rosbag2_bagfile_information"]["custom_data"]
    checksum = f"{zlib.crc32((bag / 'bag_0.db3').read_bytes()):08x}"
    assert custom == {"crc32 of bag_0.db3": checksum}
    # That of the old file says nothing of the new one.
    recovered = recover_bag(bag).output
    assert content(recovered) == content(bag)


def test_a_zstd_frame_has_a_checksum(own_bag):
    frame = storage_file(own_bag("sqlite3", "zstd")).read_bytes()
    assert frame[4] & 0b100


def test_messages_that_are_declared_must_be_there(stored_bags, mcap, tmp_path):
    """Of a recorder that writes no checksums: the index hides messages, the statistics do not."""
    bag = stored_bags["mcap_none"]
    data = bytearray(bag.files[bag.storage])
    place, body = next(
        (place, body) for place, opcode, body in mcap.records(bytes(data)) if opcode == 11
    )
    first = place + 9 + len(body) - 10
    count = int.from_bytes(data[first + 2 : first + 10], "little")
    data[first + 2 : first + 10] = (count + 5).to_bytes(8, "little")
    folder = bag.write(tmp_path / "bag")
    footer = len(data) - 8 - 20
    data[footer + 16 : footer + 20] = bytes(4)
    (folder / bag.storage).write_bytes(data)
    with pytest.raises(BagError, match=rf"declares {count + 5} messages of .*: only {count} can"):
        read_bag(folder)


def test_without_parameter_events_reconfigurations_are_unknown(shortest_loop, tmp_path):
    recording = load_recording(shortest_loop.without(PARAMETER_EVENTS).write(tmp_path / "bag"))
    assert recording.reconfigurations is None
    assert "no parameter_events: number of reconfigurations unknown" in recording.missing
