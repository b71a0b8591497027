"""A function of many arguments on an engine, with the results in order: `map` on all cores."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from bdt_study.engine.job import Engine, Result

Argument = TypeVar("Argument")


def mapped(
    engine: Engine, function: Callable[[Argument], Result], arguments: Iterable[Argument]
) -> Iterator[Result]:
    """Iterate over what a function returns, in the order of the arguments.

    Parameters
    ----------
    engine : Engine
        What works on it.
    function : callable
        A function of a module, or a partial of one.
    arguments : iterable
        Arguments, asked for as there is room for them.

    Raises
    ------
    BadInputError, LoopError
        See :meth:`bdt_study.engine.job.Engine.results`.
    """
    calls = (_Call(number, function, argument) for number, argument in enumerate(arguments))
    early: dict[int, Result] = {}
    due = 0
    for number, result in engine.results(calls):
        early[number] = result
        while due in early:
            yield early.pop(due)
            due += 1


@dataclass(frozen=True)
class _Call(Generic[Result]):
    """A function with its argument, as a job."""

    number: int
    function: Callable[[Any], Result]
    argument: Any

    @property
    def name(self) -> str:
        return f"job {self.number}"

    def run(self) -> Result:
        return self.function(self.argument)
