"""README, contributing, changelog, declaration of quality and documentation name what there is."""

import re
from importlib import import_module
from itertools import chain
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
AT_THE_TOP = [ROOT / f"{name}.md" for name in ("README", "CONTRIBUTING", "CHANGELOG", "QUALITY")]
TEXTS = [*AT_THE_TOP, *sorted((ROOT / "docs" / "source").rglob("*.md"))]

DOTTED = re.compile(r"`(bdt_\w+(?:\.\w+)+)`")
LINK = re.compile(r"\]\(([^)#:\s]+)(?:#[^)\s]*)?\)")
SOURCE_FILE = re.compile(r"`((?:bdt_\w+|tests|config|embedded_ros|benchmarks)/[\w/]+\.\w+)`")


def cases(pattern, texts):
    found = ((text, name) for text in texts for name in pattern.findall(text.read_text("utf-8")))
    return [pytest.param(*case, id=f"{case[0].stem}-{case[1]}") for case in sorted(set(found))]


def resolve(name):
    """Return what a dotted name means: a module, or something in one."""
    parts = name.split(".")
    for count in range(len(parts), 0, -1):
        try:
            found = import_module(".".join(parts[:count]))
        except ModuleNotFoundError:
            continue
        for part in parts[count:]:
            found = getattr(found, part)
        return found
    raise ModuleNotFoundError(name)


@pytest.mark.parametrize(("text", "name"), cases(DOTTED, TEXTS))
def test_a_name_with_dots_is_one_of_the_code(text, name):
    del text
    assert resolve(name) is not None


@pytest.mark.parametrize(("text", "name"), cases(SOURCE_FILE, TEXTS))
def test_a_file_that_is_named_exists(text, name):
    del text
    package = name.split("/")[0]
    assert any((folder / name).is_file() for folder in (ROOT, ROOT / "src" / package)), name


@pytest.mark.parametrize(("text", "target"), cases(LINK, AT_THE_TOP))
def test_links_of_the_files_at_the_top_lead_to_files(text, target):
    # Sphinx checks those inside of docs/source.
    assert (text.parent / target).exists()


def test_the_readme_has_a_page_and_no_more():
    lines = (ROOT / "README.md").read_text("utf-8").splitlines()
    assert len(lines) <= 150


def test_the_changelog_tells_of_the_version_of_every_package():
    manifests = (path.read_text("utf-8") for path in (ROOT / "src").glob("*/package.xml"))
    versions = set(
        chain.from_iterable(re.findall(r"<version>(.*)</version>", m) for m in manifests)
    )
    assert len(versions) == 1
    changelog = (ROOT / "CHANGELOG.md").read_text("utf-8")
    assert f"## [{versions.pop()}] - " in changelog
