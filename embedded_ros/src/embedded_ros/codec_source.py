"""Python source of a codec under construction: runs of fixed-size members, and alignment."""

import struct
from array import array
from typing import Any

import numpy as np

from embedded_ros.field_checks import ARRAY_CODES

__all__ = ["FORMATS", "SIZES", "CodecSource"]

FORMATS = {**ARRAY_CODES, "bool": "?", "byte": "c"}
SIZES = {code: struct.calcsize(f"<{code}") for code in "?cbBhHiIqQfd"}


class CodecSource:
    """Python source under construction, with what is known of the alignment at its end."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self.scope: dict[str, Any] = {"array": array, "np": np}
        self.indent = 1
        self._names = 0
        self._structs: dict[str, str] = {}
        # The position is congruent to `offset` modulo `modulus`. A body starts aligned.
        self.modulus = 8
        self.offset = 0
        # Members waiting to be merged into one struct call.
        self.format = ""
        self.operands: list[str] = []

    def emit(self, line: str) -> None:
        """Add a line."""
        self.lines.append("    " * self.indent + line)

    def name(self) -> str:
        """Return the name of a new variable."""
        self._names += 1
        return f"v{self._names}"

    def struct(self, fmt: str) -> str:
        """Return the name of the ``struct.Struct`` of a format."""
        if fmt not in self._structs:
            self._structs[fmt] = f"S{len(self._structs)}"
            self.scope[self._structs[fmt]] = struct.Struct(f"<{fmt}")
        return self._structs[fmt]

    def forget_alignment(self, modulus: int = 1) -> None:
        """Note that the position is a multiple of `modulus`, and nothing more."""
        self.modulus, self.offset = modulus, 0

    def member(self, code: str, operand: str) -> None:
        """Add a fixed-size member to the pending run."""
        size = SIZES[code]
        if size > self.modulus:
            self.flush()
            self.align_at_run_time(size)
            self.forget_alignment(size)
        else:
            padding = -self.offset % size
            self.format += "x" * padding
            self.offset += padding
        self.format += code
        self.operands.append(operand)
        self.offset = (self.offset + size) % self.modulus

    def flush(self) -> None:
        """Add the call that moves the pending run of members."""
        raise NotImplementedError

    def align_at_run_time(self, size: int) -> None:
        """Add the lines that bring the position to a multiple of `size`."""
        raise NotImplementedError

    def finish(self, head: str, tail: list[str], file: str) -> Any:
        """Compile what was added, between `head` and `tail`, and return the function ``run``."""
        self.flush()
        source = "\n".join([head, *self.lines, *(f"    {line}" for line in tail)])
        exec(compile(source, file, "exec"), self.scope)  # noqa: S102 - made from definitions
        return self.scope["run"]
