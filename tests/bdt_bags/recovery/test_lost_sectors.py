"""Sectors of zeros are found wherever they lie."""

import pytest

from bdt_bags.recovery.lost_sectors import SECTOR, first_lost_sector


def with_zeros(begin, end, size=4 * SECTOR):
    data = bytearray(b"\xff" * size)
    data[begin:end] = bytes(end - begin)
    return bytes(data)


@pytest.mark.parametrize(
    ("zeros", "part", "found"),
    [
        ((0, 0), (0, 2048), 2048),
        ((1024, 1536), (0, 2048), 1024),
        ((1024, 2048), (1100, 2048), 1100),
        ((1024, 1536), (1535, 2000), 1535),
        ((1024, 1536), (1536, 2000), 2000),
        ((1024, 1536), (0, 1025), 1024),
        ((1024, 1536), (0, 1024), 1024),
        # As long as a sector, but in two: a message may hold as many zeros.
        ((1000, 1512), (0, 2048), 2048),
        ((1025, 1536), (0, 2048), 2048),
    ],
)
def test_a_sector_counts_if_the_part_has_a_byte_of_it(zeros, part, found):
    assert first_lost_sector(with_zeros(*zeros), *part) == found


def test_a_last_sector_may_be_shorter():
    assert first_lost_sector(with_zeros(512, 520, size=520), 0, 520) == 512
