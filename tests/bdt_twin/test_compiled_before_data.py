"""What is compiled before the first batch comes: a batch that waited for it would be late."""

import json
import subprocess
import sys

import numpy as np
import pytest

PROGRAM = """
import json
import sys

import numpy as np

from bdt_controller.pid import PidGains
from bdt_controller.notch import NO_NOTCH
from bdt_plant.plant import PlantModel
from bdt_twin.decider import create_decider
from bdt_twin.decision import ControllerGains
from bdt_twin.decision_settings import DecisionSettings
from bdt_twin.estimator_choice import EstimatorChoice, create_estimator
from bdt_twin.inverse_filter import InverseFilterSettings
from bdt_twin.output_error_settings import OutputErrorSettings


def compiled():
    modules = [each for name, each in sys.modules.items() if name.startswith("bdt_")]
    loops = [loop for module in modules for loop in vars(module).values()]
    return {
        f"{loop.__module__}.{loop.__name__}"
        for loop in loops
        if getattr(loop, "__name__", "").startswith("compiled_")
        and hasattr(loop, "cache_info")
        and loop.cache_info().currsize
    }


kind, path = sys.argv[1:]
rows = np.load(path)
estimator = create_estimator(
    EstimatorChoice(kind),
    PlantModel(),
    InverseFilterSettings(sampling_rate=1000.0),
    OutputErrorSettings(),
)
decider = create_decider(
    DecisionSettings(kind="simulate", members=2),
    PlantModel(),
    ControllerGains(PidGains(), NO_NOTCH),
    ControllerGains(PidGains(), NO_NOTCH),
    estimator,
    1.0,
    1.0,
)
before, reasons = compiled(), []
for begin in range(0, len(rows), 1000):
    batch = rows[begin : begin + 1000]
    estimate = estimator.update(batch)
    decision = decider(batch, estimate, begins=begin == 0)
    if decision is not None:
        reasons.append(decision.reason)
print(json.dumps([sorted(before), sorted(compiled() - before), reasons]))
"""


@pytest.mark.parametrize("kind", ["inverse_filter", "output_error"])
def test_nothing_is_compiled_when_the_first_data_wait(closed_loop, tmp_path, kind):
    np.save(tmp_path / "rows.npy", closed_loop(12.0, 9.0).rows)
    done = subprocess.run(
        [sys.executable, "-P", "-c", PROGRAM, kind, str(tmp_path / "rows.npy")],
        check=False,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    before, late, reasons = json.loads(done.stdout)
    assert before
    assert reasons
    assert not late
