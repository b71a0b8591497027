"""Renders the templates of this folder."""

from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined


def render_page(template: str, **values: Any) -> str:
    """Return a page as text.

    Parameters
    ----------
    template : str
        File in this folder.
    **values
        What the template shows; text is escaped.

    Raises
    ------
    jinja2.UndefinedError
        If the template needs a value that is missing.
    """
    environment = Environment(
        loader=PackageLoader("bdt_bringup", "pages"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(template).render(**values)
