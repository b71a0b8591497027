"""Formulas as MathML, converted at build time by docutils.

Browsers of 2023 or later draw it by themselves, so that a page shows its formulas from disk without
network. Sphinx's default is MathJax, which a page fetches from the internet. Chosen with
``html_math_renderer = "mathml"``.
"""

from typing import Any

from docutils import nodes
from docutils.utils.math import MathError
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.application import Sphinx
from sphinx.errors import ExtensionError

_WIDE = "overflow-x: auto; overflow-y: hidden; padding: 0.5em 0"
"""A formula that is wider than a telephone's screen scrolls."""


def setup(app: Sphinx) -> dict[str, bool]:
    """Offer the renderer ``mathml``."""
    app.add_html_math_renderer("mathml", (_inline, None), (_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def _inline(writer: Any, node: nodes.math) -> None:
    writer.body.append(_mathml(node, as_block=False))
    raise nodes.SkipNode


def _block(writer: Any, node: nodes.math_block) -> None:
    writer.body.append(writer.starttag(node, "div", CLASS="notranslate", STYLE=_WIDE))
    writer.body.append(_mathml(node, as_block=True))
    writer.body.append("</div>\n")
    raise nodes.SkipNode


def _mathml(node: nodes.Element, *, as_block: bool) -> str:
    formula = node.astext()
    try:
        return str(tex2mathml(formula, as_block=as_block))
    except MathError as error:
        raise ExtensionError(f"{formula!r}: {error}") from error
