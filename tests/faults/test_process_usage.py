"""What a process holds is seen, and its growth told from what comes and goes."""

import mmap
import os

from process_usage import Usage, growth, usage_of

MEGABYTE = 10**6


def test_memory_and_descriptors_that_a_process_takes_are_seen(tmp_path):
    size = 8 * MEGABYTE
    before = usage_of(os.getpid())
    # Pages of its own: what Python allocates may be what it has freed before.
    with mmap.mmap(-1, size) as taken, (tmp_path / "file").open("wb"):
        taken.write(os.urandom(size))
        after = usage_of(os.getpid())
    assert after.memory - before.memory > 0.9 * size
    assert after.descriptors == before.descriptors + 1


def test_pages_of_a_file_that_it_reads_are_not_its_own(tmp_path):
    """Whether those of a library count as private depends on who else has them at the moment."""
    size = 8 * MEGABYTE
    with (tmp_path / "file").open("wb") as file:
        file.write(os.urandom(size))
        # Until it is on the disk it would be a change of the file.
        file.flush()
        os.fsync(file.fileno())
    before = usage_of(os.getpid())
    with (
        (tmp_path / "file").open("rb") as file,
        mmap.mmap(file.fileno(), size, access=mmap.ACCESS_READ) as read,
    ):
        assert sum(read[:: mmap.PAGESIZE]) > 0
        after = usage_of(os.getpid())
    assert after.memory - before.memory < 0.1 * size


def test_growth_is_that_of_the_median_whatever_single_samples_are():
    memory = [5, 5, 99, 5, 5, 6, 6, 6, 7, 7, 7, 7, 8, 8, 0, 8]
    usages = [Usage(float(number), one, 10, 4) for number, one in enumerate(memory)]
    assert growth(usages) == Usage(12.0, 3, 0, 0)


def test_a_descriptor_and_a_thread_more_are_growth():
    usages = [Usage(float(number), 1, 10 + number // 5, 4 + number // 6) for number in range(8)]
    assert growth(usages)[2:] == (1, 1)
