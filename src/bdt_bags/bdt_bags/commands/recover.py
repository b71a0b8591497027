"""The command ``bdt recover``."""

import json
from argparse import ArgumentParser, Namespace
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bdt_msgs_py.commands import Command

if TYPE_CHECKING:
    from bdt_bags.recovery.recover_bag import Recovery


def _add_arguments(parser: ArgumentParser) -> None:
    parser.add_argument("bag", type=Path, metavar="BAG", help="bag folder, .mcap or .db3 file")
    parser.add_argument(
        "--output", type=Path, metavar="DIR", help="new folder (default: BAG_recovered)"
    )
    parser.add_argument("--json", action="store_true", help="print the result as JSON")


def _recover(options: Namespace) -> int:
    # The list of commands needs none of the libraries of the storages.
    from bdt_bags.recovery.recover_bag import recover_bag  # noqa: PLC0415

    recovery = recover_bag(options.bag, options.output)
    if options.json:
        print(json.dumps(_as_dictionary(recovery), indent=2))
        return 0
    for line in _lines(recovery):
        print(line)
    return 0


def _lines(recovery: "Recovery") -> list[str]:
    last = datetime.fromtimestamp(recovery.end * 1e-9).astimezone()
    duration = (recovery.end - recovery.start) * 1e-9
    lines = [f"{count:>9} {name}" for name, count in sorted(recovery.messages.items())]
    for name, damage in recovery.damage.items():
        lines += [f"{name}: {remark}" for remark in damage.remarks]
    total = f"{recovery.messages.total()} messages over {duration:.3f} s"
    rest = f"{_byte_count(recovery)} bytes not understood"
    return [
        *lines,
        f"{total}, the last of {last:%Y-%m-%d %H:%M:%S.%f}; {rest}",
        f"bag: {recovery.output}",
    ]


def _as_dictionary(recovery: "Recovery") -> dict[str, Any]:
    return {
        "source": str(recovery.source),
        "output": str(recovery.output),
        "messages": dict(sorted(recovery.messages.items())),
        "start_ns": recovery.start,
        "end_ns": recovery.end,
        "bytes_not_understood": _byte_count(recovery),
        "remarks": {name: damage.remarks for name, damage in recovery.damage.items()},
    }


def _byte_count(recovery: "Recovery") -> int:
    return sum(damage.byte_count for damage in recovery.damage.values())


COMMAND = Command(
    summary="make a whole bag of what a crash, a full disk or a power cut has left",
    description="Read a bag without index, end or metadata, also a torn or damaged one, and "
    "write what is in it to a new bag beside it. The damaged bag stays as it is.",
    add_arguments=_add_arguments,
    run=_recover,
)
