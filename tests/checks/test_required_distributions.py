"""What distributions require follows from the metadata of those that are installed."""

from importlib.metadata import PackageNotFoundError

import pytest

from checks import required_distributions as module
from checks.required_distributions import locked_part, required_distributions


class Installed:
    """A distribution with requirements."""

    def __init__(self, *requires):
        self.requires = list(requires) or None


@pytest.fixture
def installed(monkeypatch):
    """Return a dict of distributions that count as installed."""
    distributions = {}

    def distribution(name):
        if name not in distributions:
            raise PackageNotFoundError(name)
        return distributions[name]

    monkeypatch.setattr(module, "distribution", distribution)
    return distributions


def test_requirements_of_requirements_count(installed):
    installed |= {"a": Installed("B_c>=1"), "b-c": Installed("d", "a"), "d": Installed()}
    assert set(required_distributions(["a"])) == {"a", "b-c", "d"}
    assert set(required_distributions(["d"])) == {"d"}


def test_markers_are_obeyed(installed):
    installed |= {"a": Installed('b; python_version < "3"', "c; python_version >= '3'")}
    installed["c"] = Installed()
    assert set(required_distributions(["a"])) == {"a", "c"}


def test_an_extra_counts_where_it_is_asked_for(installed):
    installed |= {"a": Installed("b; extra == 'more'", "c"), "b": Installed(), "c": Installed()}
    assert set(required_distributions(["a"])) == {"a", "c"}
    assert set(required_distributions(["a[more]"])) == {"a", "b", "c"}
    assert set(required_distributions(["a", "a[more]"])) == {"a", "b", "c"}


def test_what_is_left_out_brings_nothing(installed):
    installed |= {"a": Installed("b", "c"), "b": Installed("d"), "c": Installed(), "d": Installed()}
    assert set(required_distributions(["a"], without={"b"})) == {"a", "c"}


def test_what_is_not_installed_is_an_error(installed):
    installed["a"] = Installed("b")
    with pytest.raises(PackageNotFoundError, match="b"):
        required_distributions(["a"])


def test_the_part_of_a_lock_keeps_hashes():
    lock = (
        "# comment\n"
        "a.b==1 \\\n    --hash=sha256:12\n    # via -r requirements.in\n"
        "c==2 ; python_version < '3.14' \\\n    --hash=sha256:34\n"
    )
    assert locked_part(lock, {"a-b"}) == (
        "a.b==1 \\\n    --hash=sha256:12\n    # via -r requirements.in\n"
    )
    assert locked_part(lock, {"c"}).startswith("c==2 ; ")
