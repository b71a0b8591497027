"""Hashes of type definitions."""

from typing import Final

__all__ = ["TypeHash"]

_SIZE: Final = 32


class TypeHash:
    """A version and a digest; ``RIHS01_…`` as text.

    Parameters
    ----------
    version : int
        -1: there is no hash.
    value : bytes
        Thirty-two of them.
    """

    __slots__ = ("_value", "_version")

    def __init__(self, version: int = -1, value: bytes = bytes(_SIZE)) -> None:
        assert isinstance(version, int)
        assert isinstance(value, bytes)
        self._version = version
        self._value = value

    @property
    def version(self) -> int:
        """Version of the hash."""
        return self._version

    @property
    def value(self) -> bytes:
        """Digest."""
        return self._value

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, TypeHash):
            return False
        return (self._version, self._value) == (other._version, other._value)

    __hash__ = None  # type: ignore[assignment]

    def __str__(self) -> str:
        if self._version <= 0 or len(self._value) != _SIZE:
            return "INVALID"
        return f"RIHS{self._version:02}_{self._value.hex()}"
