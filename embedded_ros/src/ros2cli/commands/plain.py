"""``ros2 doctor``, ``run`` and ``pkg``: what works, what can be started, and starting it."""

import argparse

from ros2cli.grammar import Command, OneOf, Verb, flag, option, word

__all__ = ["PLAIN_COMMANDS"]

_DIAGNOSIS = (
    OneOf(
        (
            flag("-r", "--report", about="show what is here instead of checking it"),
            flag("-rf", "--report-failed", about="add what is here to each check that fails"),
        )
    ),
    flag("-iw", "--include-warnings", about="count a warning as a failed check"),
)

PLAIN_COMMANDS = (
    Verb(
        "doctor",
        "Check whether nodes can talk to each other from here.",
        "doctor:doctor",
        _DIAGNOSIS,
    ),
    Command(
        "pkg",
        "See which packages are installed.",
        (
            Verb(
                "executables",
                "List what `ros2 run` can start.",
                "packages:show_executables",
                (word("package_name", "of this package only", nargs="?"),),
            ),
            Verb("list", "List the packages.", "packages:show_packages"),
        ),
    ),
    Verb(
        "run",
        "Start a node, or another program, of a package.",
        "packages:run",
        (
            option("--prefix", about="program to start it with, such as 'gdb --args'"),
            word("package_name", "where it is from"),
            word("executable_name", "what `ros2 pkg executables` calls it"),
            word("argv", "passed on, such as --ros-args -p NAME:=VALUE", nargs=argparse.REMAINDER),
        ),
    ),
    Verb("wtf", "Another name of `doctor`.", "doctor:doctor", _DIAGNOSIS),
)
