"""What the telemetry stream accepts, what it rejects and where it begins anew."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bdt_twin.estimator import TelemetryRejectedError
from bdt_twin.telemetry_stream import TelemetryStream

RATE = 5000
EPOCH = 1_763_680_000


def batch(begin, count, epoch=0, rate=RATE):
    """Return telemetry of the samples from `begin` on."""
    rows = np.zeros((count, 3))
    rows[:, 0] = [epoch + sample / rate for sample in range(begin, begin + count)]
    return rows


def reject(stream, rows, text):
    with pytest.raises(TelemetryRejectedError, match=text):
        stream.accept(rows)


@pytest.fixture
def stream():
    """Return a stream that has taken the samples 0 to 99."""
    begun = TelemetryStream(RATE)
    assert begun.accept(batch(0, 100))
    return begun


@pytest.mark.parametrize("begin", [0, 12_345])
def test_the_first_batch_begins_the_stream_at_any_time(begin):
    stream = TelemetryStream(RATE)
    assert stream.accept(batch(begin, 10))


@pytest.mark.parametrize("epoch", [0, EPOCH])
@given(sizes=st.lists(st.integers(1, 300), min_size=2, max_size=20))
def test_batches_that_follow_each_other_continue_the_stream(epoch, sizes):
    stream, begin = TelemetryStream(RATE), 0
    begins = []
    for size in sizes:
        begins.append(stream.accept(batch(begin, size, epoch)))
        begin += size
    assert begins == [True] + [False] * (len(sizes) - 1)


def test_a_fast_stream_forgives_the_resolution_of_epoch_times():
    """A float64 of 1.8e9 s resolves 2.4e-7 s, more than a hundredth of a sample at 50 kHz."""
    stream = TelemetryStream(50_000)
    assert stream.accept(batch(0, 100, EPOCH, 50_000))
    assert not stream.accept(batch(100, 100, EPOCH, 50_000))
    reject(stream, batch(201, 100, EPOCH, 50_000), "time step")


def test_an_empty_batch_is_rejected(stream):
    reject(stream, np.empty((0, 3)), "the batch is empty")


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("column", [0, 1, 2])
def test_a_value_that_is_not_finite_is_rejected_with_its_row(stream, value, column):
    rows = batch(100, 10)
    rows[7, column] = value
    reject(stream, rows, "row 7 is not finite")


@pytest.mark.parametrize("epoch", [0, EPOCH])
def test_a_hole_inside_a_batch_is_rejected(epoch):
    rows = np.delete(batch(100, 10, epoch), 5, axis=0)
    stream = TelemetryStream(RATE)
    stream.accept(batch(0, 100, epoch))
    reject(stream, rows, rf"time step of 0\.000400 s instead of 0\.000200 s at t = {epoch}\.0212")


@pytest.mark.parametrize("epoch", [0, EPOCH])
@pytest.mark.parametrize("missing", [1, 10, 5000])
def test_a_hole_between_batches_is_rejected(epoch, missing):
    stream = TelemetryStream(RATE)
    stream.accept(batch(0, 100, epoch))
    reject(stream, batch(100 + missing, 10, epoch), r"time step of .* instead of 0\.000200 s at t")


def test_a_hole_in_the_first_batch_is_rejected():
    stream = TelemetryStream(RATE)
    reject(stream, np.delete(batch(0, 10), 5, axis=0), r"time step of 0\.000400 s .* t = 0\.001200")


def test_the_same_batch_twice_is_rejected(stream):
    reject(stream, batch(0, 100), r"time goes back by 0\.019800 s at t = 0\.000000 s")


def test_the_same_sample_twice_is_rejected(stream):
    reject(stream, batch(99, 1), r"time goes back by -?0\.000000 s at t = 0\.019800 s")


def test_time_that_goes_back_inside_a_batch_is_rejected(stream):
    rows = np.concatenate([batch(100, 5), batch(102, 5)])
    reject(stream, rows, r"time goes back by 0\.000400 s at t = 0\.020400 s")


def test_another_sampling_rate_is_rejected():
    stream = TelemetryStream(RATE / 2)
    reject(stream, batch(0, 10), r"time step of 0\.000200 s instead of 0\.000400 s")


@pytest.mark.parametrize(("error", "accepted"), [(1e-6, True), (-1e-6, True), (5e-6, False)])
def test_a_time_may_be_a_hundredth_of_a_sample_off(error, accepted):
    stream, rows = TelemetryStream(RATE), batch(0, 3)
    rows[1, 0] += error
    if accepted:
        stream.accept(rows)
    else:
        reject(stream, rows, "time step")


def test_the_batch_after_a_rejection_begins_a_new_stream(stream):
    reject(stream, batch(200, 10), "time step")
    assert stream.accept(batch(210, 10))
    assert not stream.accept(batch(220, 10))


def test_a_rejected_batch_leaves_no_time_behind(stream):
    """After a fault, even the batch that would have continued the stream begins a new one."""
    reject(stream, np.empty((0, 3)), "empty")
    assert stream.accept(batch(100, 10))


def test_the_first_stream_may_begin_after_a_rejection():
    stream = TelemetryStream(RATE)
    reject(stream, np.empty((0, 3)), "empty")
    assert stream.accept(batch(0, 10))


def test_after_rejections_in_a_row_one_stream_begins(stream):
    for _ in range(3):
        reject(stream, np.full((2, 3), np.nan), "row 0 is not finite")
    assert stream.accept(batch(500, 10))
    assert not stream.accept(batch(510, 10))


def test_a_rejection_can_be_caught_as_a_value_error(stream):
    with pytest.raises(ValueError, match="empty"):
        stream.accept(np.empty((0, 3)))
