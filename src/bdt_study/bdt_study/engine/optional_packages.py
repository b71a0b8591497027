"""Packages that only data sets and clusters need, tried before any work begins."""

from importlib import import_module

from bdt_msgs_py.command_errors import BadInputError

DATA_SETS = ("pyarrow.dataset", "pyarrow.parquet")
CLUSTERS = ("distributed",)
INDICES = ("SALib.analyze",)


def check_imports(what: str, modules: tuple[str, ...]) -> None:
    """Refuse what needs modules that are missing or, too new for this numpy, cannot be imported.

    Parameters
    ----------
    what : str
        The command or option that needs them.
    modules : tuple of str
        `DATA_SETS`, `CLUSTERS` or `INDICES`.

    Raises
    ------
    BadInputError
        If one of them does not work.
    """
    for module in modules:
        try:
            import_module(module)
        except (ImportError, AttributeError, ValueError) as error:
            package = module.split(".", maxsplit=1)[0]
            raise BadInputError(f"{what}: needs the Python package {package}: {error}") from error
