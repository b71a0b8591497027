"""A node's process, tied to the one that has started it."""

import os
import signal
import subprocess
import sys

INTERRUPTED = """
import os, signal
os.kill(os.getpid(), signal.SIGINT)
raise AssertionError("it goes on")
"""

ENDED_BY_CTRL_C = """
import os, signal
def main(arguments):
    try:
        os.kill(os.getpid(), signal.SIGINT)
    except KeyboardInterrupt:
        print("interrupted", *arguments[1:])
"""


def run_child(folder, text, parent=None):
    (folder / "its_module.py").write_text(text)
    guard = [sys.executable, "-m", "bdt_bringup.child_node", str(parent or os.getpid())]
    places = f"{folder}{os.pathsep}{os.environ.get('PYTHONPATH', '')}"
    return subprocess.run(
        [*guard, "its_module", "an argument"],
        env={**os.environ, "PYTHONPATH": places},
        capture_output=True,
        text=True,
        check=False,
        timeout=60.0,
    )


def test_a_node_that_is_interrupted_while_it_is_imported_ends_without_a_word(tmp_path):
    done = run_child(tmp_path, INTERRUPTED)
    assert (done.returncode, done.stdout, done.stderr) == (-signal.SIGINT, "", "")


def test_a_node_that_runs_may_clean_up_after_an_interrupt(tmp_path):
    done = run_child(tmp_path, ENDED_BY_CTRL_C)
    assert (done.returncode, done.stdout, done.stderr) == (0, "interrupted an argument\n", "")


def test_a_node_without_the_process_that_has_started_it_does_not_begin(tmp_path):
    done = run_child(tmp_path, ENDED_BY_CTRL_C, parent=1)
    assert done.stderr == "the process that started this node is gone\n"
