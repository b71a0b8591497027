"""A tutorial as its reader types it: its console blocks in order, compared with what it shows.

What the pages may use, beside ``...`` for what differs from run to run:

- a block without a caption is typed in the first terminal, ``:caption: Terminal 2`` in another one;
- a command whose terminal goes on in a later block with more output, or with ``^C``, keeps running
  until then; what its own block shows must have appeared before the next command is typed;
- a block of code with a file's name as caption is that file;
- a command must succeed, unless ``echo $?`` comes next.
"""

import os
import re
import signal
import subprocess
import threading
from dataclasses import dataclass
from doctest import ELLIPSIS, NORMALIZE_WHITESPACE, REPORT_NDIFF, Example, OutputChecker
from pathlib import Path

import pytest
from markdown_it import MarkdownIt

ROOT = Path(__file__).parents[2]
TUTORIALS = ROOT / "docs" / "source" / "tutorials"
PAGES = sorted(page for page in TUTORIALS.glob("*.md") if page.stem != "index")
IN_REAL_TIME = ("look-at-a-loop-live", "with-ros-2", "your-machine", "your-own-bag")
"""Tutorials whose loops, or recorders, do not wait for a busy computer."""
DEADLINE = 240.0
"""Wall time [s] after which a command hangs."""
BUSY = re.compile(
    r"^\[INFO\] \[[\d.]+\] \[plant\]: waiting for .*\n|  (degraded|stopped): plant: .*",
    re.MULTILINE,
)
"""What a busy machine makes the plant say."""
FLAGS = ELLIPSIS | NORMALIZE_WHITESPACE
INTERRUPTED = 130


@dataclass
class Step:
    """Something typed in a terminal, or waited for, and the output that the page shows."""

    line: int
    terminal: str
    typed: str
    expected: str = ""
    file: str = ""
    keeps_running: bool = False
    may_fail: bool = False


def steps_of(text):
    """Return what a page asks its reader to do, in order."""
    steps = []
    for token in MarkdownIt().parse(text):
        if token.type != "fence":
            continue
        language = token.info.removeprefix("{code-block}").strip()
        options = dict(re.findall(r"^:(\w+): (.*)$", token.content, re.MULTILINE))
        body = re.sub(r"^(:\w+:.*\n)+\n?", "", token.content)
        caption = options.get("caption", "")
        if language == "console":
            steps += console_steps(body, caption or "Terminal 1", token.map[0] + 1)
        elif caption:
            steps.append(Step(token.map[0] + 1, "", body, file=caption))
    for number, step in enumerate(steps):
        later = [other for other in steps[number + 1 :] if other.terminal == step.terminal]
        if later and not step.file:
            step.keeps_running = later[0].typed in ("", "^C")
            step.may_fail = later[0].typed == "echo $?"
    return steps


def console_steps(body, terminal, line):
    """Return the steps of one block: prompt, lines that go on, output."""
    steps = []
    for text in body.splitlines():
        if text.startswith("$ "):
            steps.append(Step(line, terminal, text[2:]))
        elif text.startswith("> ") and steps and not steps[-1].expected:
            steps[-1].typed += "\n" + text[2:]
        elif text == "^C":
            steps.append(Step(line, terminal, "^C"))
        else:
            if not steps:
                steps.append(Step(line, terminal, ""))
            steps[-1].expected += text + "\n"
    return steps


class Terminal:
    """A shell whose commands come through a pipe of their own."""

    def __init__(self, folder, environment):
        script, self._keyboard = os.pipe()
        self._shell = subprocess.Popen(
            ["/bin/bash", "--noprofile", "--norc", f"/dev/fd/{script}"],
            cwd=folder,
            env=environment,
            pass_fds=[script],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        os.close(script)
        self.command = self.shown = ""
        self._changed = threading.Condition()
        self._output = ""
        self._end = f"end-of-command-{id(self)}"
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()
        self._write("trap : INT\n")

    def type(self, command):
        """Begin a command."""
        self.command, self.shown = command, ""
        self._output = ""
        self._write(f"{command}\ncode=$?; printf '\\n{self._end} %s\\n' $code; (exit $code)\n")

    def interrupt(self):
        """Press Ctrl-C."""
        os.killpg(self._shell.pid, signal.SIGINT)

    def wait_for(self, expected):
        """Wait until the running command has printed this, or ended."""
        self._wait(lambda: begins(expected, self.output) or self._has_ended())
        return self.output

    def wait_for_end(self):
        """Return output and exit code of the running command; None for one that hangs."""
        ended = self._wait(self._has_ended)
        return self.output, int(ended[1]) if ended else None

    def close(self):
        """End the shell and all that it started."""
        os.close(self._keyboard)
        for number in (signal.SIGINT, signal.SIGKILL):
            try:
                os.killpg(self._shell.pid, number)
                self._shell.wait(timeout=60.0)
            except (subprocess.TimeoutExpired, ProcessLookupError):
                continue
        self._reader.join()
        self._shell.stdout.close()

    @property
    def output(self):
        """What the running command has printed."""
        return BUSY.sub("", self._output.partition(f"\n{self._end}")[0])

    def _has_ended(self):
        return re.search(rf"{self._end} (\d+)\n", self._output)

    def _wait(self, condition):
        with self._changed:
            return self._changed.wait_for(condition, DEADLINE)

    def _write(self, text):
        os.write(self._keyboard, text.encode())

    def _read(self):
        while chunk := self._shell.stdout.read1():
            with self._changed:
                # A line that is drawn again and again shows its last state.
                self._output += re.sub(r"[^\n]*\r(?!\n)", "", chunk.decode(errors="replace"))
                self._changed.notify_all()


def matches(expected, got):
    return OutputChecker().check_output(expected, got, FLAGS)


def begins(expected, got):
    """Return whether the output so far begins as expected."""
    return matches(expected, got) or matches(expected + "...\n", got)


def difference(expected, got):
    """Return expected and actual output line by line; what ``...`` stands for is no difference."""
    return OutputChecker().output_difference(Example("", expected), got, FLAGS | REPORT_NDIFF)


def run_tutorial(page, folder, environment):
    """Type what a page says and compare what is printed with what it shows."""
    terminals = {}
    try:
        for step in steps_of(page.read_text(encoding="utf-8")):
            if step.file:
                (folder / step.file).write_text(step.typed, encoding="utf-8")
                continue
            if step.terminal not in terminals:
                terminals[step.terminal] = Terminal(folder, environment)
            fault = fault_of(step, terminals[step.terminal])
            if fault:
                where = f"{page.name}, block at line {step.line}, {step.terminal}"
                pytest.fail(f"{where}\n{fault}", pytrace=False)
    finally:
        for terminal in terminals.values():
            terminal.close()


def fault_of(step, terminal):
    """Do a step; return what is not as the page says, or nothing."""
    if step.typed == "^C":
        terminal.interrupt()
    elif step.typed:
        terminal.type(step.typed)
    terminal.shown += step.expected
    what = f"$ {terminal.command}"
    if step.keeps_running:
        got = terminal.wait_for(terminal.shown)
        agree, code = begins(terminal.shown, got), 0
    else:
        got, code = terminal.wait_for_end()
        agree = matches(terminal.shown, got)
    if code is None:
        return f"{what}\nhangs after\n{got}"
    if not agree:
        return f"{what}\n{difference(terminal.shown, got)}"
    if code and not step.may_fail and (step.typed, code) != ("^C", INTERRUPTED):
        return f"{what}\nexit code {code}\n{got}"
    return ""
