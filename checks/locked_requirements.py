"""Prints the part of requirements.lock that distributions need, with hashes, for ``pip install``.

Run as ``python -m checks.locked_requirements NAME ...`` where they are installed.
"""

import sys
from pathlib import Path

from checks.required_distributions import locked_part, required_distributions

LOCK = Path("requirements.lock")


def main() -> None:
    """Print the entries for the distributions on the command line."""
    names = required_distributions(sys.argv[1:])
    print(locked_part(LOCK.read_text(encoding="utf-8"), names), end="")


if __name__ == "__main__":
    main()
