"""CDR of our message classes: a writer and a reader compiled for each type.

Plain XCDR version 1, little-endian, as rmw_cyclonedds and rmw_fastrtps exchange it. Alignment
counts from the end of the four-byte encapsulation header. Runs of fixed-size members become one
``struct`` call, primitive sequences are copied in bulk; a ``JointState`` costs 1-2 µs each way.
"""

import struct
from collections.abc import Callable
from typing import Any, Final, NamedTuple

from embedded_ros.codec_source import FORMATS, SIZES, CodecSource
from embedded_ros.definitions import EMPTY_MEMBER, Field, fields_of
from embedded_ros.errors import RMWError
from embedded_ros.message_classes import CHECK_FIELDS, message_class

__all__ = ["ENCAPSULATION", "CdrError", "Codec", "codec"]

#: Header of every payload: CDR, little-endian, no options.
ENCAPSULATION: Final = b"\x00\x01\x00\x00"


class CdrError(RMWError):
    """A payload that is not a message of the expected type."""


class Codec(NamedTuple):
    """Compiled CDR of one type.

    Attributes
    ----------
    write : callable
        ``write(message, buffer)`` appends the body to a ``bytearray`` that already holds the
        encapsulation header and, for services, the 16-byte request header.
    read : callable
        ``read(payload, offset)`` makes a message of the body that begins at `offset`.
    """

    write: Callable[[Any, bytearray], None]
    read: Callable[[bytes, int], Any]


_codecs: dict[str, Codec] = {}


def codec(type_name: str) -> Codec:
    """Codec of a type, compiled on first use."""
    found = _codecs.get(type_name)
    if found is None:
        found = Codec(_compile_writer(type_name), _compile_reader(type_name))
        _codecs[type_name] = found
    return found


class _Writer(CodecSource):
    def flush(self) -> None:
        if self.format:
            call = f"{self.struct(self.format)}.pack({', '.join(self.operands)})"
            self.emit(f"b += {call}")
            self.format, self.operands = "", []

    def align_at_run_time(self, size: int) -> None:
        self.scope["P"] = [b"\0" * count for count in range(8)]
        distance = "(4 - len(b)) & 7" if size == 8 else f"-len(b) & {size - 1}"
        self.emit(f"b += P[{distance}]")

    def message(self, type_name: str, value: str) -> None:
        for field in fields_of(type_name):
            if field.name == EMPTY_MEMBER:
                self.member("B", "0")
            else:
                self.field(field, f"{value}._{field.name}")

    def field(self, field: Field, value: str) -> None:
        if field.container is None:
            self.scalar(field, value)
            return
        name = self.name()
        self.emit(f"{name} = {value}")
        if field.container == "array" or field.size:
            self.scope["check_size"] = _check_size
            exact = field.container == "array"
            self.emit(f"check_size({field.name!r}, len({name}), {field.size}, {exact})")
        if field.container == "sequence":
            self.member("I", f"len({name})")
            self.flush()
        self.elements(field, name)

    def scalar(self, field: Field, value: str) -> None:
        if field.is_message:
            self.message(field.type_name, value)
        elif field.type_name == "string":
            name = self.name()
            self.emit(f"{name} = {value}.encode()")
            self.member("I", f"len({name}) + 1")
            self.flush()
            self.emit(f"b += {name}")
            self.emit("b += b'\\0'")
            self.forget_alignment()
        else:
            self.member(FORMATS[field.type_name], value)

    def elements(self, field: Field, name: str) -> None:
        code = None if field.is_message else FORMATS.get(field.type_name)
        self.flush()
        if code is None:
            self.forget_alignment()
            item = self.name()
            self.emit(f"for {item} in {name}:")
            self.indent += 1
            self.scalar(field, item)
            self.flush()
            self.indent -= 1
            self.forget_alignment()
            return
        if SIZES[code] > 4 or field.container == "array":
            # An empty sequence is not padded for its elements.
            self.emit(f"if len({name}):")
            self.indent += 1
            self.align_at_run_time(SIZES[code])
            self.indent -= 1
        if code == "c":
            self.emit(f"b += b''.join({name})")
        elif code == "?":
            self.emit(f"b += bytes(map(bool, {name}))")
        elif field.container == "array":
            self.emit(f"b += np.asarray({name}, '{code}').tobytes()")
        else:
            self.emit(f"b += {name}")
        self.forget_alignment(min(4, SIZES[code]))


class _Reader(CodecSource):
    def flush(self) -> None:
        if self.format:
            targets = ", ".join(self.operands) + ("," if len(self.operands) == 1 else "")
            self.emit(f"{targets} = {self.struct(self.format)}.unpack_from(d, p)")
            self.emit(f"p += {struct.calcsize('<' + self.format)}")
            self.format, self.operands = "", []

    def align_at_run_time(self, size: int) -> None:
        self.emit("p += (4 - p) & 7" if size == 8 else f"p += -p & {size - 1}")

    def message(self, type_name: str) -> str:
        """Read a message into a new variable and return the variable's name."""
        cls = f"C_{type_name.replace('/', '_')}"
        self.scope[cls] = message_class(type_name)
        result = self.name()
        self.emit(f"{result} = {cls}.__new__({cls})")
        self.emit(f"{result}._check_fields = {CHECK_FIELDS}")
        for field in fields_of(type_name):
            if field.name == EMPTY_MEMBER:
                self.member("B", "_")
            else:
                self.field(field, f"{result}._{field.name}")
        return result

    def field(self, field: Field, target: str) -> None:
        if field.container is None:
            self.scalar(field, target)
            return
        count = str(field.size)
        if field.container == "sequence":
            count = self.name()
            self.member("I", count)
        self.flush()
        self.elements(field, target, count)

    def scalar(self, field: Field, target: str) -> None:
        if field.is_message:
            value = self.message(field.type_name)
            self.emit(f"{target} = {value}")
        elif field.type_name == "string":
            size = self.name()
            self.member("I", size)
            self.flush()
            self.emit(f"{target} = str(d[p:p + {size} - 1], 'utf-8') if {size} else ''")
            self.emit(f"p += {size}")
            self.forget_alignment()
        else:
            self.member(FORMATS[field.type_name], target)

    def elements(self, field: Field, target: str, count: str) -> None:
        code = None if field.is_message else FORMATS.get(field.type_name)
        if code is None:
            items, item = self.name(), self.name()
            self.emit(f"{items} = {target} = []")
            self.emit(f"for _ in range({count}):")
            self.indent += 1
            self.forget_alignment()
            self.scalar(field, item)
            self.flush()
            self.emit(f"{items}.append({item})")
            self.indent -= 1
            self.forget_alignment()
            return
        size = SIZES[code]
        if size > 4 or field.container == "array":
            self.emit(f"if {count}:")
            self.indent += 1
            self.align_at_run_time(size)
            self.indent -= 1
        end = self.name()
        self.emit(f"{end} = p + {count} * {size}")
        if code == "?":
            self.emit(f"{target} = list(map(bool, d[p:{end}]))")
        elif code == "c":
            self.emit(f"{target} = [d[i:i + 1] for i in range(p, min({end}, len(d)))]")
        elif field.container == "array":
            self.emit(f"{target} = np.frombuffer(d, '{code}', {count}, p).copy()")
        else:
            values = self.name()
            self.emit(f"{values} = {target} = array('{code}')")
            self.emit(f"{values}.frombytes(d[p:{end}])")
        self.emit(f"p = {end}")
        self.forget_alignment(min(4, size))


def _check_size(name: str, count: int, size: int, exact: bool) -> None:
    if count > size or (exact and count != size):
        raise ValueError(f"field {name!r} holds {count} elements, not {size}")


def _compile_writer(type_name: str) -> Callable[[Any, bytearray], None]:
    source = _Writer()
    source.message(type_name, "m")
    run = source.finish("def run(m, b):", ["return None"], f"<CDR writer of {type_name}>")

    def write(message: Any, buffer: bytearray) -> None:
        try:
            run(message, buffer)
        except (struct.error, AttributeError, TypeError, ValueError, OverflowError) as error:
            raise TypeError(f"a field of the {type_name} has a wrong value: {error}") from error

    return write


def _compile_reader(type_name: str) -> Callable[[bytes, int], Any]:
    source = _Reader()
    result = source.message(type_name)
    source.flush()
    tail = ["if p > len(d): raise ValueError('it ends too early')", f"return {result}"]
    run = source.finish("def run(d, p):", tail, f"<CDR reader of {type_name}>")

    def read(payload: bytes, offset: int = len(ENCAPSULATION)) -> Any:
        if payload[:2] != b"\x00\x01":
            raise CdrError(f"not little-endian CDR: {bytes(payload[:4]).hex()}")
        try:
            return run(payload, offset)
        except (struct.error, ValueError) as error:
            raise CdrError(
                f"failed to deserialize ROS message: not a {type_name}: {error}"
            ) from error

    return read
