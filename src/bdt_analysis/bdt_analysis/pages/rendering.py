"""Renders the templates of pages; those of other packages extend ``base.html`` of this folder."""

from typing import Any

from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined

_OWN_FOLDER = "bdt_analysis.pages"


def render_page(template: str, folder: str = _OWN_FOLDER, **values: Any) -> str:
    """Return a page as text.

    Parameters
    ----------
    template : str
        File name of the template.
    folder : str
        Python package in whose folder it is.
    **values
        What the template shows; text is escaped.

    Raises
    ------
    jinja2.UndefinedError
        If the template needs a value that is missing.
    """
    folders = dict.fromkeys((folder, _OWN_FOLDER))
    environment = Environment(
        loader=ChoiceLoader([PackageLoader(package, "") for package in folders]),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(template).render(**values)
