"""Which words of a command line ROS can read at all."""

from collections.abc import Iterable

__all__ = ["check_encoding"]


def check_encoding(words: Iterable[str]) -> None:
    """Raise ``UnicodeEncodeError`` for a word that is not UTF-8.

    Python hides such bytes in lone surrogates, which neither a name nor a value may hold.
    """
    for word in words:
        word.encode()
