"""Links of the files that Sphinx does not build lead somewhere, their headings included."""

import re
from pathlib import Path

import pytest
from markdown_it import MarkdownIt

ROOT = Path(__file__).parents[2]
TEXTS = [*sorted(ROOT.glob("*.md")), ROOT / "embedded_ros" / "README.md"]


def tokens_of(text):
    for token in MarkdownIt().enable("table").parse(text.read_text(encoding="utf-8")):
        yield token
        yield from token.children or ()


def targets(text):
    """Return what a file links to and shows, other than addresses on the network."""
    attributes = ((token.attrGet("href"), token.attrGet("src")) for token in tokens_of(text))
    found = {target for pair in attributes for target in pair if target}
    return sorted(target for target in found if "://" not in target)


def anchors(text):
    """Return the anchors that GitHub, and MyST after it, make of the headings of a file."""
    lines = text.read_text(encoding="utf-8").splitlines()
    headings = [line.lstrip("# ").lower() for line in lines if re.match(r"#+ ", line)]
    return {re.sub(r"[^\w\- ]", "", heading).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("text", TEXTS, ids=lambda text: str(text.relative_to(ROOT)))
def test_every_link_leads_to_a_file_and_a_heading(text):
    for target in targets(text):
        path, _, anchor = target.partition("#")
        file = text.parent / path if path else text
        assert file.exists(), target
        assert not anchor or anchor in anchors(file), target
