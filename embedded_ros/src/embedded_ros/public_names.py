"""Where names are at home for those who use them.

The runtime defines values and errors, programs import them from a façade. Tracebacks, pickles and
type checks by name show the façade's name, so the façade says it for what it passes on. And a
program may import a name from a module that merely uses it.
"""

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any

__all__ = ["also_here", "shown_in"]


def shown_in(module: str, *classes: type) -> None:
    """Have classes report a module as theirs.

    Parameters
    ----------
    module : str
        Name of the module that passes them on: ``__name__`` there.
    *classes : type
    """
    for class_ in classes:
        class_.__module__ = module


def also_here(module: str, names: Mapping[str, str]) -> Callable[[str], Any]:
    """Make the ``__getattr__`` of a module that has names of others, loaded when asked for.

    Parameters
    ----------
    module : str
        ``__name__`` there.
    names : mapping of str to str
        By the name of their module names with spaces between; ``Name=Other`` is `Other` under
        the name `Name`.
    """
    homes: dict[str, tuple[str, str]] = {}
    for home, listed in names.items():
        for word in listed.split():
            name, _, original = word.partition("=")
            homes[name] = home, original or name

    def find(name: str) -> Any:
        if name not in homes:
            raise AttributeError(f"module {module!r} has no attribute {name!r}")
        home, original = homes[name]
        return getattr(import_module(home), original)

    return find
