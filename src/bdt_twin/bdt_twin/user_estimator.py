"""Somebody's estimator: found by module and name, called as it wants, its errors told in a line."""

import inspect
import math
import os
import sys
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from importlib.util import find_spec
from numbers import Real
from pathlib import Path
from typing import Any, Never

import numpy as np
from numpy.typing import NDArray

from bdt_msgs_py.command_errors import BadInputError
from bdt_msgs_py.parameter_tables import suggestion
from bdt_plant.plant import PlantModel
from bdt_twin.estimator import Estimate, TelemetryRejectedError

MAY_BE_NAN = ("gap", "uncertainty")
"""Numbers of an estimate that may be unknown."""

NOT_NEGATIVE = ("uncertainty", "growth_uncertainty", "age", "voltage_offset_uncertainty")

MAY_BE_INFINITE = ("uncertainty", "voltage_offset_uncertainty")


class UserEstimatorError(BadInputError):
    """Somebody's estimator cannot be made or has failed: one line with its file and line."""


class UserEstimator:
    """An estimator from outside this package as one that the twin can rely on.

    Batches that are empty or not finite do not reach it. It is restarted before the first batch
    and when time goes back.

    Parameters
    ----------
    kind : str
        ``module:name`` of a class with ``restart()`` and ``update(batch)``, or of a function that
        returns such an object. The module may lie in the current folder. The class gets what it
        asks for of ``model`` and ``sampling_rate``, by these names or in this order. An `update`
        that has a parameter ``newest_only`` gets it as well.
    model : PlantModel
        Constants of the mechanism, as the twin knows them.
    sampling_rate : float
        Sampling rate of the telemetry [Hz].

    Raises
    ------
    UserEstimatorError
        If there is no such module or class, or if it fails.
    """

    def __init__(self, kind: str, model: PlantModel, sampling_rate: float) -> None:
        module, _, name = kind.partition(":")
        self._label = name
        self._file: str | None = None
        with self._errors_in_one_line():
            factory = self._find(module, name)
            given = _wanted_of(factory, {"model": model, "sampling_rate": sampling_rate})
            if given is None:
                self._fail(factory, "must take no arguments, or model and sampling_rate")
            estimator = given()
        self._restart = self._method(factory, estimator, "restart")
        batch = np.empty((0, 3))
        update = getattr(estimator, "update", None)
        self._takes_newest_only = callable(update) and _binds(update, batch, newest_only=False)
        options = {"newest_only": False} if self._takes_newest_only else {}
        self._update = self._method(factory, estimator, "update", batch, **options)
        self._last_time = -math.inf
        self.restart()

    def restart(self) -> None:
        """Forget everything; see :class:`bdt_twin.estimator.Estimator`."""
        with self._errors_in_one_line():
            self._restart()

    def update(self, batch: NDArray[np.float64], *, newest_only: bool = False) -> Estimate | None:
        """Take the next batch; see :class:`bdt_twin.estimator.Estimator`.

        Raises
        ------
        TelemetryRejectedError
            For a batch that is empty or not finite, and if the estimator raises it.
        UserEstimatorError
            For any other error of the estimator, and if it returns no estimate.
        """
        if not batch.size:
            raise TelemetryRejectedError("the batch is empty")
        if not np.isfinite(batch).all():
            raise TelemetryRejectedError("the batch is not finite")
        if batch[0, 0] < self._last_time:
            self.restart()
        self._last_time = float(batch[-1, 0])
        options = {"newest_only": newest_only} if self._takes_newest_only else {}
        with self._errors_in_one_line():
            found = self._update(batch, **options)
        return None if found is None else self._checked(found)

    def _find(self, module: str, name: str) -> Callable[..., Any]:
        with _current_folder():
            try:
                spec = find_spec(module)
            except ModuleNotFoundError as error:
                spec = None
                if error.name is None or not f"{module}.".startswith(f"{error.name}."):
                    raise
            if spec is None:
                raise UserEstimatorError(
                    f"No module named {module!r}, neither in {Path.cwd()} nor installed"
                )
            self._file = spec.origin
            has = vars(import_module(module))
        found: Callable[..., Any] | None = has.get(name)
        if not callable(found):
            raise UserEstimatorError(
                f"{self._shown(self._file)} has no class {name}{suggestion(name, has)}"
            )
        return found

    def _method(
        self, factory: Any, estimator: Any, name: str, *arguments: object, **options: object
    ) -> Callable[..., Any]:
        method: Callable[..., Any] | None = getattr(estimator, name, None)
        if not callable(method):
            self._fail(factory, f"has no method {name}({'batch' if arguments else ''})")
        if not _binds(method, *arguments, **options):
            self._fail(method, f"{name} must take {'one batch' if arguments else 'no arguments'}")
        return method

    def _checked(self, found: Any) -> Estimate:
        if not isinstance(found, Estimate):
            self._fail(self._update, f"update returned {found!r}: must be an Estimate or None")
        for name, value in found._asdict().items():
            if fault := _fault_of(name, value):
                self._fail(self._update, f"update returned {name} = {value!r}: must be {fault}")
        reason = found.reason
        if math.isnan(found.gap) and not reason:
            reason = f"{self._place_of(self._update)}: {self._label}: the gap is not a number"
        return found._replace(reason=reason)

    # Errors --------------------------------------------------------------------------------

    @contextmanager
    def _errors_in_one_line(self) -> Iterator[None]:
        try:
            yield
        except (TelemetryRejectedError, UserEstimatorError):
            raise
        # Whatever it is, it is somebody's: they need the place, and the twin goes on or ends.
        except (Exception, SystemExit) as error:
            text = error.msg if isinstance(error, SyntaxError) else str(error)
            raise UserEstimatorError(
                f"{self._place(error)}: {type(error).__name__}{f': {text}' if text else ''}"
            ) from error

    def _place(self, error: BaseException) -> str:
        """Return file and line of an error: the innermost place in the folder of the file."""
        if isinstance(error, SyntaxError) and error.filename:
            return f"{self._shown(error.filename)}:{error.lineno}"
        frames = traceback.extract_tb(error.__traceback__)
        folder = Path(self._file).parent if self._file else None
        own = [frame for frame in frames if Path(frame.filename).parent == folder] or frames
        return f"{self._shown(own[-1].filename)}:{own[-1].lineno}"

    def _fail(self, code: Any, text: str) -> Never:
        raise UserEstimatorError(f"{self._place_of(code)}: {self._label}: {text}")

    def _place_of(self, code: Any) -> str:
        """Return file and line at which a class or function begins."""
        try:
            _, line = inspect.getsourcelines(inspect.unwrap(code))
            return f"{self._shown(inspect.getsourcefile(code))}:{line}"
        except (OSError, TypeError):
            return self._shown(self._file)

    @staticmethod
    def _shown(file: str | None) -> str:
        if file is None:
            return "?"
        path = Path(file)
        return str(path.relative_to(Path.cwd()) if path.is_relative_to(Path.cwd()) else path)


@contextmanager
def _current_folder() -> Iterator[None]:
    """Look for modules in the current folder first, where ``ros2 run`` does not look at all."""
    folder = os.getcwd()  # noqa: PTH109
    sys.path.insert(0, folder)
    try:
        yield
    finally:
        sys.path.remove(folder)


def _wanted_of(factory: Callable[..., Any], offered: dict[str, Any]) -> Callable[[], Any] | None:
    """Return the call of a class or function with what it asks for; None if it asks for more."""
    try:
        names = offered.keys() & inspect.signature(factory).parameters.keys()
    except ValueError:
        names = set()
    by_name = {name: offered[name] for name in names}
    if by_name and _binds(factory, **by_name):
        return lambda: factory(**by_name)
    if _binds(factory, *offered.values()):
        return lambda: factory(*offered.values())
    return factory if _binds(factory) else None


def _binds(function: Callable[..., Any], *arguments: Any, **options: Any) -> bool:
    """Tell whether a call would have the arguments that the function takes."""
    try:
        inspect.signature(function).bind(*arguments, **options)
    except TypeError:
        return False
    except ValueError:
        return True  # compiled code without a signature: the call itself will tell
    return True


def _fault_of(name: str, value: Any) -> str:
    """Return what a field of an estimate must be; empty if it is that."""
    if name == "reason":
        return "" if isinstance(value, str) else "a text"
    if not isinstance(value, Real):
        return "a number"
    number = float(value)
    if name in NOT_NEGATIVE and number < 0.0:
        return "at least 0"
    if math.isfinite(number) or (name in MAY_BE_NAN and math.isnan(number)):
        return ""
    return "" if name in MAY_BE_INFINITE and not math.isnan(number) else "finite"
