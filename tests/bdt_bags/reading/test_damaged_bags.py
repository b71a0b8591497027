"""Seeded fuzz: whatever happens to the bytes of a bag, one line or an analysis comes out."""

import random
import signal
import struct
import warnings
from contextlib import contextmanager

import pytest

from bdt_analysis.analyze import analyze
from bdt_bags.bag_error import BagError

CASES = 130
"""Damaged bags of each storage and compression; there are eight of them."""

DEADLINE = 60.0
"""Wall time [s] after which reading one counts as endless."""

KINDS = [
    "mcap_none",
    "mcap_message",
    "mcap_file",
    "mcap_storage",
    "mcap_lz4",
    "sqlite3_none",
    "sqlite3_message",
    "sqlite3_file",
]


@pytest.mark.parametrize("kind", KINDS)
def test_damaged_bag_gives_one_line_or_an_analysis(stored_bags, tmp_path, kind):
    source = random.Random(f"damage of {kind}")  # noqa: S311 - a seed makes it repeatable
    good = stored_bags[kind]
    others = [data for bag in stored_bags.values() for data in bag.files.values()]
    reasons, analyzed = [], 0
    for case in range(CASES):
        name = "metadata.yaml" if case % 6 == 0 else good.storage
        content = good.files[name]
        for _ in range(source.choice([1, 1, 1, 2])):
            content = damaged(content, source.choice(others), source)
        bag = good.write(tmp_path / "bag")
        (bag / name).write_bytes(content)
        before = {x.name: x.read_bytes() for x in bag.iterdir()}
        try:
            with deadline(), warnings.catch_warnings():
                warnings.simplefilter("error")
                analyze(bag / name if case % 4 == 1 else bag)
            analyzed += 1
        except BagError as error:
            reasons.append(str(error))
        assert {x.name: x.read_bytes() for x in bag.iterdir()} == before
    assert all(reason.isprintable() and str(tmp_path) in reason for reason in reasons)
    assert len(reasons) > CASES / 3, "damage that nobody notices tests nothing"
    assert analyzed > CASES / 50, "damage that always shows at once tests little"


@pytest.mark.parametrize("kind", ["mcap_none", "sqlite3_none", "sqlite3_file"])
def test_a_torn_bag_names_the_command_that_saves_it(stored_bags, tmp_path, kind):
    good = stored_bags[kind]
    bag = good.write(tmp_path / "bag")
    (bag / good.storage).write_bytes(good.files[good.storage][:-3000])
    with pytest.raises(BagError, match=rf"; bdt recover {bag} makes a whole bag of what is left$"):
        analyze(bag)


@contextmanager
def deadline():
    def end(*_):
        raise TimeoutError(f"not within {DEADLINE} s")

    previous = signal.signal(signal.SIGALRM, end)
    signal.setitimer(signal.ITIMER_REAL, DEADLINE)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, previous)


def damaged(data: bytes, other: bytes, source: random.Random) -> bytes:
    """Return data that was cut, flipped, overwritten, shortened, repeated, spliced or edited."""
    content = bytearray(data)
    place = source.randrange(max(len(content), 1))
    kind = source.choice(["cut", "flip", "noise", "field", "shorten", "repeat", "splice", "length"])
    if kind == "cut":
        del content[place:]
    elif kind == "flip" and content:
        content[place] ^= 1 << source.randrange(8)
    elif kind == "noise":
        content[place : place + 50] = source.randbytes(50)
    elif kind == "field":
        width = source.choice([1, 2, 4, 8])
        content[place : place + width] = source.choice([b"\x00", b"\xff"]) * width
    elif kind == "shorten":
        del content[place : place + source.randrange(1, 200)]
    elif kind == "repeat":
        start = source.randrange(max(len(content), 1))
        content[place:place] = content[start : start + source.randrange(1, 300)]
    elif kind == "splice":
        start = source.randrange(len(other))
        content[place : place + 64] = other[start : start + 64]
    elif kind == "length":
        # Lengths stand where there are zeros: most of them are small numbers of many bytes.
        place = content.find(b"\x00\x00\x00", place)
        value = source.choice([0, 1, 2**31 - 1, 2**32 - 1, 2**40, 2**63])
        content[max(place - 1, 0) : max(place, 1) + 7] = struct.pack("<Q", value)
    return bytes(content)
