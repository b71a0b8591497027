"""The error of everything that is wrong with a bag."""


class BagError(ValueError):
    """A bag or an output folder cannot be used; one line that says why and what is required.

    A damaged bag holds names and texts of any kind: what would leave the line or move the cursor
    is replaced.
    """

    def __init__(self, reason: str) -> None:
        super().__init__(_printable(reason))


def one_line(error: BaseException) -> str:
    """Return what an exception says, in one line of at most 300 characters, never empty."""
    text = _printable(str(error)) or type(error).__name__
    return text if len(text) <= 300 else text[:297] + "..."


def _printable(text: str) -> str:
    line = " ".join(text.split())
    return "".join(character if character.isprintable() else "?" for character in line)
