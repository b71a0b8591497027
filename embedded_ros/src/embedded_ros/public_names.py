"""Where a class is at home for those who use it.

The runtime defines values and errors, programs import them from a façade. Tracebacks, pickles and
type checks by name show the façade's name, so the façade says it for what it passes on.
"""

__all__ = ["shown_in"]


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
