"""The calls of Cyclone DDS that need care with Python's global lock or that the binding lacks.

They go through a DLL handle of our own: argument types set on the binding's handle would change
the binding. Functions called here release the global lock; taking, and ``ddspy_write`` of the
binding, keep it, which is faster where the call cannot block.
"""

import ctypes as ct
from typing import Final, NamedTuple

from cyclonedds._clayer import ddspy_write
from cyclonedds.internal import DDS

from embedded_ros.errors import RCLError

__all__ = [
    "ANY_STATE",
    "INFINITE",
    "GuardCondition",
    "SampleInfo",
    "WaitSet",
    "assert_liveliness",
    "delete",
    "get_status",
    "guid",
    "instance_handle",
    "matched",
    "read_condition",
    "set_status_mask",
    "take_one",
    "take_status",
    "wait_for_acks",
    "write",
    "write_blocking",
]

#: Sample, view and instance states: all.
ANY_STATE: Final = 0x7F
INFINITE: Final = 2**63 - 1
_TIMEOUT = -10

_lib = ct.CDLL(DDS._dll_handle._name)
_lib_with_lock = ct.PyDLL(DDS._dll_handle._name)


class _Container(ct.Structure):
    """What the binding's serializer takes for a sample: its bytes and their number."""

    _fields_ = (("data", ct.c_void_p), ("size", ct.c_size_t))


class SampleInfo(NamedTuple):
    """What is told of a sample: when it was written [ns], and the handle of the writer."""

    source_timestamp: int
    publication_handle: int


class _Info(ct.Structure):
    """The sample info of Cyclone DDS."""

    _fields_ = (
        ("states", ct.c_uint32 * 3),
        ("valid_data", ct.c_bool),
        ("source_timestamp", ct.c_int64),
        ("instance_handle", ct.c_uint64),
        ("publication_handle", ct.c_uint64),
        ("generations_and_ranks", ct.c_uint32 * 5),
    )


class _Place:
    """Where a sample is put: to make one takes as long as to take a sample."""

    def __init__(self) -> None:
        self.container, self.info = _Container(), _Info()
        self._pointer = ct.c_void_p(ct.addressof(self.container))
        self.address, self.info_address = ct.addressof(self._pointer), ct.addressof(self.info)


#: Those that nobody uses at the moment.
_places: list[_Place] = []


def _function(name: str, *arguments: object, library: ct.CDLL = _lib) -> "ct._NamedFuncPointer":
    function = getattr(library, name)
    function.argtypes = list(arguments)
    function.restype = ct.c_int32
    return function  # type: ignore[no-any-return]


_HANDLES = ct.POINTER(ct.c_uint64)
_delete = _function("dds_delete", ct.c_int32)
_write = _function("dds_write", ct.c_int32, ct.c_void_p)
_take = _function(
    "dds_take",
    ct.c_int32,
    ct.c_void_p,
    ct.c_void_p,
    ct.c_size_t,
    ct.c_uint32,
    library=_lib_with_lock,
)
_free = _function("dds_free", ct.c_void_p, library=_lib_with_lock)
_create_waitset = _function("dds_create_waitset", ct.c_int32)
_attach = _function("dds_waitset_attach", ct.c_int32, ct.c_int32, ct.c_ssize_t)
_detach = _function("dds_waitset_detach", ct.c_int32, ct.c_int32)
_wait = _function("dds_waitset_wait", ct.c_int32, ct.c_void_p, ct.c_size_t, ct.c_int64)
_create_guard = _function("dds_create_guardcondition", ct.c_int32)
_set_guard = _function("dds_set_guardcondition", ct.c_int32, ct.c_bool)
_take_guard = _function("dds_take_guardcondition", ct.c_int32, ct.POINTER(ct.c_bool))
_create_readcondition = _function("dds_create_readcondition", ct.c_int32, ct.c_uint32)
_matched_subscriptions = _function(
    "dds_get_matched_subscriptions", ct.c_int32, _HANDLES, ct.c_size_t
)
_matched_publications = _function("dds_get_matched_publications", ct.c_int32, _HANDLES, ct.c_size_t)
_instance_handle = _function("dds_get_instance_handle", ct.c_int32, _HANDLES)
_guid = _function("dds_get_guid", ct.c_int32, ct.c_char_p)
_assert_liveliness = _function("dds_assert_liveliness", ct.c_int32)
_wait_for_acks = _function("dds_wait_for_acks", ct.c_int32, ct.c_int64)
_set_status_mask = _function("dds_set_status_mask", ct.c_int32, ct.c_uint32)
_take_status = _function("dds_take_status", ct.c_int32, ct.POINTER(ct.c_uint32), ct.c_uint32)


def _check(code: int, what: str) -> int:
    if code < 0:
        raise RCLError(f"{what} failed in Cyclone DDS (code {code})")
    return code


def delete(entity: int) -> None:
    """Delete an entity and its children; one that is gone already is no error."""
    _delete(entity)


def read_condition(reader: int) -> int:
    """Create a condition that holds while the reader has a sample."""
    return _check(_create_readcondition(reader, ANY_STATE), "create a read condition")


def write(writer: int, payload: bytes) -> None:
    """Write a payload of a multiple of four bytes, keeping the global lock."""
    _check(ddspy_write(writer, payload), "write a sample")


def write_blocking(writer: int, payload: bytes) -> None:
    """Write a payload where the write may wait for readers: other threads go on meanwhile."""
    box = _Container(ct.cast(ct.c_char_p(payload), ct.c_void_p), len(payload))
    _check(_write(writer, ct.byref(box)), "write a sample")


def take_one(reader: int) -> tuple[bytes, SampleInfo] | None:
    """Take the oldest sample.

    Not by ``ddspy_take``: it calls a class of Python for each sample, where a signal may be heard,
    and crashes if the handler raises something.

    Returns
    -------
    tuple or None
        Payload and sample info; None if there is no sample, if it tells only that a writer went
        away, or if the reader is deleted.
    """
    try:
        place = _places.pop()
    except IndexError:
        place = _Place()
    sample = None
    if _take(reader, place.address, place.info_address, 1, 1) > 0:
        container, info = place.container, place.info
        if info.valid_data:
            told = SampleInfo(info.source_timestamp, info.publication_handle)
            sample = ct.string_at(container.data, container.size), told
        _free(container.data)
        container.data = None  # as Cyclone DDS expects it
    _places.append(place)
    return sample


def matched(entity: int, *, writers: bool) -> list[int]:
    """Instance handles of the matched writers of a reader, or of the readers of a writer."""
    function = _matched_publications if writers else _matched_subscriptions
    handles = (ct.c_uint64 * 64)()
    count = function(entity, handles, 64)
    if count > 64:
        handles = (ct.c_uint64 * count)()
        count = min(count, function(entity, handles, count))
    return list(handles[: max(count, 0)])


def instance_handle(entity: int) -> int:
    """Instance handle of an entity, unsigned (the binding's is signed)."""
    handle = ct.c_uint64()
    _check(_instance_handle(entity, ct.byref(handle)), "get an instance handle")
    return handle.value


def guid(entity: int) -> bytes:
    """The sixteen bytes that name an entity in the network."""
    buffer = ct.create_string_buffer(16)
    _check(_guid(entity, buffer), "get a GUID")
    return buffer.raw


def assert_liveliness(writer: int) -> None:
    """Assert the liveliness of a writer with manual liveliness."""
    _check(_assert_liveliness(writer), "assert liveliness")


def wait_for_acks(writer: int, timeout_ns: int) -> bool:
    """Wait until all matched reliable readers have acknowledged everything."""
    code = _wait_for_acks(writer, timeout_ns)
    return code != _TIMEOUT and _check(code, "wait for acknowledgments") >= 0


def set_status_mask(entity: int, mask: int) -> None:
    """Choose the statuses that trigger a wait set to which the entity itself is attached."""
    _check(_set_status_mask(entity, mask), "set a status mask")


def take_status(entity: int, mask: int) -> int:
    """Statuses of the mask that have changed since they were last taken."""
    status = ct.c_uint32()
    _take_status(entity, ct.byref(status), mask)
    return status.value


def get_status(function: str, entity: int, numbers: "ct.Array[ct.c_int32]") -> None:
    """Have a function such as ``dds_get_sample_lost_status`` fill in its structure."""
    _check(getattr(_lib, function)(ct.c_int32(entity), ct.byref(numbers)), function)


class GuardCondition:
    """A flag that wakes wait sets."""

    def __init__(self, participant: int) -> None:
        self.ref = _check(_create_guard(participant), "create a guard condition")

    def set(self) -> None:
        """Wake; a deleted condition ignores it."""
        _set_guard(self.ref, True)

    def clear(self) -> bool:
        """Reset the flag and tell whether it was set."""
        flag = ct.c_bool(False)
        _take_guard(self.ref, ct.byref(flag))
        return flag.value

    def close(self) -> None:
        """Delete the condition."""
        _delete(self.ref)


class WaitSet:
    """Blocks until one of the attached conditions holds, and says which."""

    _CAPACITY = 64

    def __init__(self, participant: int) -> None:
        self._ref = _check(_create_waitset(participant), "create a wait set")
        self._fired = (ct.c_ssize_t * self._CAPACITY)()
        self._address = ct.addressof(self._fired)

    def attach(self, condition: int) -> None:
        """Watch a condition or entity; :meth:`wait` reports it by this number."""
        _attach(self._ref, condition, condition)

    def detach(self, condition: int) -> None:
        """Stop watching; one that is gone already is no error."""
        _detach(self._ref, condition)

    def wait(self, timeout_ns: int) -> list[int]:
        """Wait for at least one condition, releasing the global lock.

        Parameters
        ----------
        timeout_ns : int
            :data:`INFINITE` waits forever.

        Returns
        -------
        list of int
            Those that hold, at most 64; empty after a time-out or if the wait set is deleted.
        """
        count = _wait(self._ref, self._address, self._CAPACITY, timeout_ns)
        return self._fired[: min(count, self._CAPACITY)] if count > 0 else []

    def close(self) -> None:
        """Delete the wait set; a thread that waits on it returns."""
        _delete(self._ref)
