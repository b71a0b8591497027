"""Which engine the options mean, and which make no sense."""

import pytest

from bdt_msgs_py.command_errors import BadInputError
from bdt_study.engine.chosen_engine import chosen_engine
from bdt_study.engine.local_workers import LocalWorkers


@pytest.mark.parametrize("workers", [None, 1, 1024])
def test_without_a_scheduler_processes_of_this_computer_do_it(workers):
    assert isinstance(chosen_engine(workers), LocalWorkers)


@pytest.mark.parametrize("workers", [-1, 0, 1025])
def test_a_number_of_workers_that_makes_no_sense_is_refused(workers):
    with pytest.raises(BadInputError, match=f"^--workers {workers}: must be 1 to 1024$"):
        chosen_engine(workers)


def test_workers_of_here_and_of_a_scheduler_are_not_both_asked_for():
    with pytest.raises(BadInputError, match="a --scheduler has workers of its own"):
        chosen_engine(1, "tcp://127.0.0.1:1")
