"""Numbers used in several modules."""

from typing import Final

#: Nanoseconds in a second.
S_TO_NS: Final = 1000 * 1000 * 1000
