"""Runs of which the answers are known."""

from collections.abc import Callable

import numpy as np
import pytest

from bdt_bags.run_signals import RunSignals


@pytest.fixture(scope="session")
def pitch() -> float:
    """Return the pitch of the lead screw of :func:`known_run` [m/rad]."""
    return 2e-4


@pytest.fixture(scope="session")
def known_run(pitch: float) -> Callable[..., RunSignals]:
    """Return a function that makes a run of rows; what is not given is empty."""

    def make(estimates=(), dead_zones=(), requests=(), *, truth=None, held_gaps=()) -> RunSignals:
        return RunSignals(
            telemetry=np.zeros((2, 3)),
            truth=truth,
            reference=np.empty((0, 2)),
            estimates=np.array(estimates).reshape(-1, 2),
            dead_zones=np.array(dead_zones).reshape(-1, 2),
            pitch=pitch,
            requests=np.array(requests).reshape(-1, 4),
            held_gaps=np.array(held_gaps).reshape(-1, 2),
        )

    return make
