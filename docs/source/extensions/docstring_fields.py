"""The fields of a class stand in its docstring, under "Attributes", and nowhere else.

autodoc would list them once more, without their meaning. Those of a parameter set are described by
its quantities; they are written under "Attributes" here.
"""

import inspect
from typing import Any

from sphinx.application import Sphinx


def skip_fields(
    _app: Sphinx, kind: str, _name: str, member: Any, skip: bool, _options: Any
) -> bool | None:
    """Skip what a class holds that is neither a method nor a property."""
    if skip or kind != "class":
        return None
    documented = inspect.isroutine(member) or isinstance(member, property)
    return None if documented else True


def describe_quantities(
    _app: Sphinx, kind: str, _name: str, member: Any, _options: Any, lines: list[str]
) -> None:
    """Add the fields of a parameter set with unit, default, range and meaning."""
    if kind != "class" or not hasattr(member, "__dataclass_fields__"):
        return
    from bdt_msgs_py.quantities import quantities_of  # noqa: PLC0415 - a farm has no packages

    quantities = list(quantities_of(member))
    if not quantities:
        return
    lines += ["", "Attributes", "----------"]
    for name, default, described in quantities:
        unit = f" [{described.unit}]" if described.unit else ""
        allowed = "" if described.is_free else f", {described.allowed()}"
        lines += [f"{name} : {default!r}{unit}{allowed}", f"    {described.description}"]


def setup(app: Sphinx) -> dict[str, bool]:
    """Connect both, before napoleon reads the docstrings."""
    app.connect("autodoc-skip-member", skip_fields)
    app.connect("autodoc-process-docstring", describe_quantities, priority=400)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
