"""Somebody's class, found by module and name, and its errors told in one line with their place.

For what users add to a node without changing this project: an estimator, a drive.
"""

import inspect
import os
import sys
import traceback
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Never

from bdt_msgs_py.command_errors import BadInputError
from bdt_msgs_py.parameter_tables import suggestion


class UserCode:
    """Code from outside this project.

    Parameters
    ----------
    kind : str
        ``module:name`` of a class, or of a function that returns an object. The module may lie in
        the current folder.
    error : type
        What is raised when the code cannot be found or fails.

    Attributes
    ----------
    factory : callable
        The class or function.
    name : str
        Its name.

    Raises
    ------
    BadInputError
        Of the kind `error`, if there is no such module or class, or if the module fails.
    """

    def __init__(self, kind: str, error: type[BadInputError]) -> None:
        module, _, self.name = kind.partition(":")
        self._error = error
        self._file: str | None = None
        with self.errors_in_one_line():
            self.factory = self._find(module)

    def _find(self, module: str) -> Callable[..., Any]:
        with _current_folder():
            try:
                spec = find_spec(module)
            except ModuleNotFoundError as error:
                spec = None
                if error.name is None or not f"{module}.".startswith(f"{error.name}."):
                    raise
            if spec is None:
                raise self._error(
                    f"No module named {module!r}, neither in {Path.cwd()} nor installed"
                )
            self._file = spec.origin
            has = vars(import_module(module))
        found: Callable[..., Any] | None = has.get(self.name)
        if not callable(found):
            raise self._error(
                f"{_shown(self._file)} has no class {self.name}{suggestion(self.name, has)}"
            )
        return found

    def method(
        self, owner: Any, name: str, *arguments: object, takes: str, **options: object
    ) -> Callable[..., Any]:
        """Return a method that takes such arguments.

        Parameters
        ----------
        owner : object
            What the class or function returned.
        name : str
            Name of the method.
        *arguments, **options
            Examples of what it will be called with.
        takes : str
            What it must take, in words; empty for no arguments.

        Raises
        ------
        BadInputError
            If there is none.
        """
        method: Callable[..., Any] | None = getattr(owner, name, None)
        if not callable(method):
            self.fail(self.factory, f"has no method {name}({takes.rpartition(' ')[2]})")
        if not binds(method, *arguments, **options):
            self.fail(method, f"{name} must take {takes or 'no arguments'}")
        return method

    @contextmanager
    def errors_in_one_line(self, *passing: type[Exception]) -> Iterator[None]:
        """Raise what the code raises as one line with file and line.

        Parameters
        ----------
        *passing : type
            Exceptions that the code may raise, and that stay as they are.
        """
        try:
            yield
        except (self._error, *passing):
            raise
        # Whatever it is, it is somebody's: they need the place, and the node goes on or ends.
        except (Exception, SystemExit) as error:
            text = error.msg if isinstance(error, SyntaxError) else str(error)
            kind = type(error).__name__
            line = " ".join(f"{kind}: {text}".split()) if text else kind
            raise self._error(f"{self._place(error)}: {line}") from error

    def fail(self, code: Any, text: str) -> Never:
        """Raise an error about a class or function.

        Parameters
        ----------
        code : object
            What it is about: tells file and line.
        text : str
            What is wrong with it.
        """
        raise self._error(f"{self.place_of(code)}: {self.name}: {text}")

    def place_of(self, code: Any) -> str:
        """Return file and line at which a class or function begins."""
        try:
            _, line = inspect.getsourcelines(inspect.unwrap(code))
            return f"{_shown(inspect.getsourcefile(code))}:{line}"
        except (OSError, TypeError):
            return _shown(self._file)

    def _place(self, error: BaseException) -> str:
        """Return file and line of an error: the innermost place in the folder of the file."""
        if isinstance(error, SyntaxError) and error.filename:
            return f"{_shown(error.filename)}:{error.lineno}"
        frames = traceback.extract_tb(error.__traceback__)
        folder = Path(self._file).parent if self._file else None
        own = [frame for frame in frames if Path(frame.filename).parent == folder] or frames
        return f"{_shown(own[-1].filename)}:{own[-1].lineno}"


def wanted_of(factory: Callable[..., Any], offered: Mapping[str, Any]) -> Callable[[], Any] | None:
    """Return the call of a class or function with what it asks for of what is offered.

    Parameters
    ----------
    factory : callable
        The class or function.
    offered : mapping
        Arguments by name, in the order in which one without names gets them.

    Returns
    -------
    callable or None
        None if it asks for more.
    """
    try:
        names = offered.keys() & inspect.signature(factory).parameters.keys()
    except ValueError:
        names = set()
    by_name = {name: offered[name] for name in names}
    if by_name and binds(factory, **by_name):
        return lambda: factory(**by_name)
    if binds(factory, *offered.values()):
        return lambda: factory(*offered.values())
    return factory if binds(factory) else None


def binds(function: Callable[..., Any], *arguments: Any, **options: Any) -> bool:
    """Tell whether a call would have the arguments that the function takes."""
    try:
        inspect.signature(function).bind(*arguments, **options)
    except TypeError:
        return False
    except ValueError:
        return True  # compiled code without a signature: the call itself will tell
    return True


@contextmanager
def _current_folder() -> Iterator[None]:
    """Look for modules in the current folder first, where ``ros2 run`` does not look at all."""
    folder = os.getcwd()  # noqa: PTH109
    sys.path.insert(0, folder)
    try:
        yield
    finally:
        sys.path.remove(folder)


def _shown(file: str | None) -> str:
    if file is None:
        return "?"
    path = Path(file)
    return str(path.relative_to(Path.cwd()) if path.is_relative_to(Path.cwd()) else path)
