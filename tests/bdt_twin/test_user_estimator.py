"""Somebody's estimator: the shortest class runs, and every error has its file and line."""

import math
import pickle
import sys
from pathlib import Path

import numpy as np
import pytest

from bdt_plant.plant import PlantModel
from bdt_twin.estimator import Estimate, TelemetryRejectedError
from bdt_twin.user_estimator import UserEstimator, UserEstimatorError

PAGE = Path(__file__).parents[2] / "docs/source/how-to/choose-an-estimator.md"

SHORTEST = """
from bdt_twin.estimator import Estimate

class MyEstimator:
    def restart(self):
        self.rows = 0

    def update(self, batch):
        self.rows += len(batch)
        return Estimate(batch[-1, 0], 1e-3 * self.rows)
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Return the current folder, whose module ``my_file`` is forgotten afterwards."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [entry for entry in sys.path if entry])
    yield tmp_path
    for name in ("my_file", "my_helper"):
        sys.modules.pop(name, None)


@pytest.fixture
def make(folder):
    """Return a function that writes ``my_file.py`` and makes ``my_file:MyEstimator``."""

    def make(text, name="MyEstimator"):
        (folder / "my_file.py").write_text(text)
        return UserEstimator(f"my_file:{name}", PlantModel(), 1000.0)

    return make


def with_update(*lines):
    body = "\n".join(f"        {line}" for line in lines)
    return SHORTEST.partition("        self.rows += len")[0] + body + "\n"


def with_constructor(*lines):
    body = "\n".join(f"    {line}" for line in lines)
    return SHORTEST.replace("    def restart", f"{body}\n\n    def restart", 1)


def rows(*times):
    return np.array([[time, 0.0, 0.0] for time in times])


def refusal(action, *arguments):
    with pytest.raises(UserEstimatorError) as caught:
        action(*arguments)
    assert "\n" not in str(caught.value)
    assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)  # noqa: S301
    return str(caught.value)


def test_a_class_with_restart_and_update_in_the_current_folder_is_an_estimator(make):
    before = list(sys.path)
    estimator = make(SHORTEST)
    assert estimator.update(rows(0.0, 1e-3)) == Estimate(1e-3, 2e-3, math.nan)._replace(
        uncertainty=pytest.approx(math.nan, nan_ok=True)
    )
    assert estimator.update(rows(2e-3), newest_only=True).gap == 3e-3
    assert sys.path == before


def test_the_class_of_the_documentation_is_an_estimator(make):
    blocks = PAGE.read_text(encoding="utf-8").split("```python\n")[1:]
    (text,) = (block.partition("```")[0] for block in blocks if "class MyEstimator" in block)
    assert make(text).update(rows(0.0, 1e-3)).gap == 0.1


def test_a_file_elsewhere_on_the_path_is_found_too(folder, tmp_path_factory, monkeypatch):
    elsewhere = tmp_path_factory.mktemp("elsewhere")
    (elsewhere / "my_file.py").write_text(SHORTEST)
    monkeypatch.syspath_prepend(elsewhere)
    assert UserEstimator("my_file:MyEstimator", PlantModel(), 1000.0).update(rows(0.0))


@pytest.mark.parametrize(
    ("signature", "gets"),
    [
        ("self", ()),
        ("self, model, sampling_rate", ("model", "rate")),
        ("self, plant, rate", ("model", "rate")),
        ("self, model", ("model",)),
        ("self, sampling_rate", ("rate",)),
        ("self, *, sampling_rate, window=2.0", ("rate",)),
        ("self, sampling_rate=5000.0, model=None", ("rate", "model")),
        ("self, *arguments", ("model", "rate")),
        ("self, window=2.0", ()),
    ],
)
def test_a_class_gets_what_its_constructor_asks_for(make, signature, gets):
    names = [name.split("=")[0].strip(" *") for name in signature.split(",")]
    names = [name for name in names if name not in ("self", "window", "")]
    given = f"*{names[0]}," if "*arguments" in signature else ", ".join([*names, ""])
    lines = [f"def __init__({signature}):", f"    type(self).given = ({given})"]
    make(with_constructor(*lines))
    kinds = {"model": PlantModel, "rate": float}
    assert [type(each) for each in sys.modules["my_file"].MyEstimator.given] == [
        kinds[each] for each in gets
    ]


def test_a_function_may_make_the_estimator(make):
    estimator = make(SHORTEST + "\ndef make(model, fs):\n    return MyEstimator()\n", "make")
    assert estimator.update(rows(0.0)).gap == 1e-3


def test_whoever_wants_to_know_that_somebody_waits_is_told(make):
    text = with_update("return Estimate(0.0, float(newest_only))")
    estimator = make(text.replace("(self, batch)", "(self, batch, newest_only)"))
    assert [estimator.update(rows(0.0), newest_only=each).gap for each in (True, False)] == [1, 0]


def test_the_estimator_is_restarted_when_time_goes_back(make):
    estimator = make(SHORTEST)
    estimator.update(rows(7.0, 8.0))
    assert estimator.update(rows(1.0)).gap == 1e-3


@pytest.mark.parametrize("batch", [np.empty((0, 3)), rows(math.nan), np.full((2, 3), math.inf)])
def test_batches_that_are_of_no_use_do_not_reach_it(make, batch):
    estimator = make(SHORTEST)
    with pytest.raises(TelemetryRejectedError, match="the batch is "):
        estimator.update(batch)
    assert estimator.update(rows(0.0)).gap == 1e-3


def test_it_may_reject_a_batch_itself(make):
    rejects = "from bdt_twin.estimator import TelemetryRejectedError"
    estimator = make(with_update(rejects, "raise TelemetryRejectedError('too short')"))
    with pytest.raises(TelemetryRejectedError, match="too short"):
        estimator.update(rows(0.0))


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("import no_such_package", "my_file.py:1: ModuleNotFoundError: No module named 'no_such_"),
        ("\n\nx = 1 +", "my_file.py:3: SyntaxError: invalid syntax"),
        ("\n1 / 0", "my_file.py:2: ZeroDivisionError: division by zero"),
        ("\nexit()", "my_file.py:2: SystemExit"),
        (SHORTEST.replace("My", "Mein"), "my_file.py has no class MyEstimator; did you mean Mein"),
        ("MyEstimator = 3", "my_file.py has no class MyEstimator"),
        (
            with_constructor("def __init__(self, model, rate, more):", "    pass"),
            "my_file.py:4: MyEstimator: must take no arguments, or model and sampling_rate",
        ),
        (
            with_constructor("def __init__(self):", "    self.window = self.rate"),
            "my_file.py:6: AttributeError: 'MyEstimator' object has no attribute 'rate'",
        ),
        (SHORTEST.replace("self.rows = 0", "len(3)"), "my_file.py:6: TypeError: object of type"),
        (
            SHORTEST.replace("restart", "reset"),
            "my_file.py:4: MyEstimator: has no method restart()",
        ),
        (
            SHORTEST.replace("update", "step"),
            "my_file.py:4: MyEstimator: has no method update(batch",
        ),
        (
            SHORTEST.replace("(self, batch)", "(self)"),
            "my_file.py:8: MyEstimator: update must take one batch",
        ),
        (
            SHORTEST.replace("restart(self)", "restart(self, time)"),
            "my_file.py:5: MyEstimator: restart must take no arguments",
        ),
    ],
)
def test_a_class_that_cannot_be_made_is_one_line_with_its_place(make, text, says):
    assert refusal(make, text).startswith(says)


def test_a_file_that_is_not_there_is_named_with_the_folder(folder):
    text = refusal(UserEstimator, "my_file:MyEstimator", PlantModel(), 1000.0)
    assert text == f"No module named 'my_file', neither in {folder} nor installed"


@pytest.mark.parametrize(
    ("lines", "says"),
    [
        (["return Estimate(0.0, 1 / 0)"], "my_file.py:9: ZeroDivisionError: division by zero"),
        (["import numpy as np", "np.linalg.inv([[0.0]])"], "my_file.py:10: LinAlgError: Singular"),
        (["raise KeyError"], "my_file.py:9: KeyError"),
        (["return 0.25"], "my_file.py:8: MyEstimator: update returned 0.25: must be an Estimate o"),
        (
            ["return Estimate(0.0, '0.1')"],
            "my_file.py:8: MyEstimator: update returned gap = '0.1': must be a number",
        ),
        (["return Estimate(0.0, batch)"], "my_file.py:8: MyEstimator: update returned gap = array"),
        (
            ["return Estimate(float('nan'), 0.1)"],
            "my_file.py:8: MyEstimator: update returned time ",
        ),
        (
            ["return Estimate(0.0, float('inf'))"],
            "my_file.py:8: MyEstimator: update returned gap =",
        ),
        (
            ["return Estimate(0.0, 0.1, -1.0)"],
            "my_file.py:8: MyEstimator: update returned uncertainty = -1.0: must be at least 0",
        ),
        (
            ["return Estimate(0.0, 0.1, voltage_offset=float('inf'))"],
            "my_file.py:8: MyEstimator: update returned voltage_offset = inf: must be finite",
        ),
        (
            ["return Estimate(0.0, 0.1, voltage_offset_uncertainty=float('nan'))"],
            "my_file.py:8: MyEstimator: update returned voltage_offset_uncertainty = nan: must be ",
        ),
        (
            ["return Estimate(0.0, 0.1, voltage_offset_uncertainty=-1.0)"],
            "my_file.py:8: MyEstimator: update returned voltage_offset_uncertainty = -1.0: must be",
        ),
        (
            ["return Estimate(0.0, 0.1, reason=None)"],
            "my_file.py:8: MyEstimator: update returned reason = None: must be a text",
        ),
    ],
)
def test_an_error_of_update_is_one_line_with_its_place(make, lines, says):
    estimator = make(with_update(*lines))
    assert refusal(estimator.update, rows(0.0)).startswith(says)


def test_an_error_in_a_file_beside_it_is_told_with_its_own_place(make, folder):
    (folder / "my_helper.py").write_text("def half(x):\n    return x / 0\n")
    estimator = make("from my_helper import half\n" + with_update("half(1)"))
    assert refusal(estimator.update, rows(0.0)).startswith("my_helper.py:2: ZeroDivisionError")


def test_a_gap_that_is_not_a_number_is_nothing_learned_and_says_where(make):
    estimate = make(with_update("return Estimate(0.0, float('nan'))")).update(rows(0.0))
    assert not estimate.is_known
    assert estimate.reason == "my_file.py:8: MyEstimator: the gap is not a number"
