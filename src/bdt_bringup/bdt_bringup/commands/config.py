"""The command ``bdt config``: which configurations come with the package, and where they are."""

from argparse import ArgumentParser, Namespace
from pathlib import Path

from bdt_msgs_py.command_errors import BadInputError
from bdt_msgs_py.commands import Command


def _add_arguments(parser: ArgumentParser) -> None:
    parser.add_argument(
        "name", nargs="?", metavar="NAME", help="configuration whose path is printed"
    )


def _config(options: Namespace) -> int:
    # The list of commands needs no YAML parser.
    from bdt_msgs_py.configuration_files import packaged_configurations  # noqa: PLC0415
    from bdt_msgs_py.parameter_tables import suggestion  # noqa: PLC0415

    packaged = packaged_configurations()
    if options.name is None:
        width = max(map(len, packaged))
        for name, path in packaged.items():
            print(f"{name:{width}}  {_first_sentence(path)}")
        return 0
    if options.name not in packaged:
        raise BadInputError(
            f"configuration {options.name!r}: must be one of {', '.join(packaged)}"
            f"{suggestion(options.name, packaged)}"
        )
    print(packaged[options.name])
    return 0


def _first_sentence(path: Path) -> str:
    lines = path.read_text(encoding="utf-8").splitlines()
    comment = " ".join(line.removeprefix("# ") for line in lines if line.startswith("# "))
    return f"{comment.partition('. ')[0].rstrip('.')}."


COMMAND = Command(
    summary="list the configurations that come with the package, or print the path of one",
    description="List the configurations that come with the package, or print the path of one, "
    "for `ros2 run ... --params-file` or to copy it.",
    add_arguments=_add_arguments,
    run=_config,
)
