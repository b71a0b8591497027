"""Comparison of values that are one number each."""

import operator
from collections.abc import Callable

__all__ = ["Ordered"]


class Ordered:
    """Base of values that compare by one number, and that have no hash."""

    __slots__ = ()

    def _compared(self, other: object, holds: Callable[[int, int], bool]) -> bool:
        """Tell whether a relation holds; ``NotImplemented`` for an `other` of another kind."""
        raise NotImplementedError

    def __eq__(self, other: object) -> bool:
        return self._compared(other, operator.eq)

    def __lt__(self, other: object) -> bool:
        return self._compared(other, operator.lt)

    def __le__(self, other: object) -> bool:
        return self._compared(other, operator.le)

    def __gt__(self, other: object) -> bool:
        return self._compared(other, operator.gt)

    def __ge__(self, other: object) -> bool:
        return self._compared(other, operator.ge)

    __hash__ = None  # type: ignore[assignment]
