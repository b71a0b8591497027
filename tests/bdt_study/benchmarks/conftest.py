"""The benchmarks choose a ROS domain by their process number; here it is one that is claimed."""

from collections.abc import Callable

import pytest

from bdt_study.benchmarks import processes


@pytest.fixture(scope="session")
def bench_domain(claim_domain: Callable[[], int]) -> int:
    return claim_domain()


@pytest.fixture(autouse=True)
def benchmarks_in_a_claimed_domain(bench_domain: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(processes, "domain", lambda: bench_domain)
