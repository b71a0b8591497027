"""A child process ends within a limited time, whatever it makes of signals."""

import signal
import subprocess
import sys
import time

import pytest

from bdt_msgs_py.process_end import ProcessEnd

LISTENER = """
import signal, sys, time
for number in map(int, sys.argv[1:]):
    signal.signal(number, signal.SIG_IGN)
print("ready", flush=True)
while True:
    time.sleep(60)
"""


@pytest.fixture
def deaf_to():
    """Return a function that starts a process which ignores signals."""
    started = []

    def start(*numbers):
        process = subprocess.Popen(
            [sys.executable, "-c", LISTENER, *(str(int(number)) for number in numbers)],
            stdout=subprocess.PIPE,
        )
        started.append(process)
        assert process.stdout.readline() == b"ready\n"
        return process

    yield start
    for process in started:
        process.kill()
        process.communicate()


@pytest.mark.parametrize(
    ("ignored", "exit_code"),
    [
        ([], -signal.SIGTERM),
        ([signal.SIGTERM], -signal.SIGKILL),
    ],
)
def test_the_first_signal_that_works_ends_the_process(deaf_to, ignored, exit_code):
    process = deaf_to(*ignored)
    end = ProcessEnd(process, ((signal.SIGTERM, 1.0), (signal.SIGKILL, 20.0)))
    end.ask()
    assert end.wait() == exit_code


def test_each_signal_is_sent_once(deaf_to, monkeypatch):
    process = deaf_to(signal.SIGINT)
    sent = []
    real = process.send_signal
    monkeypatch.setattr(process, "send_signal", lambda number: (sent.append(number), real(number)))
    end = ProcessEnd(process, ((signal.SIGINT, 0.1), (signal.SIGTERM, 20.0)))
    end.ask()
    end.ask()
    assert end.wait() == -signal.SIGTERM
    assert sent == [signal.SIGINT, signal.SIGTERM]


def test_one_that_outlives_everything_is_an_error_and_no_endless_wait(deaf_to):
    process = deaf_to(signal.SIGTERM)
    begun = time.monotonic()
    with pytest.raises(RuntimeError, match=f"process {process.pid} does not end"):
        ProcessEnd(process, ((signal.SIGTERM, 0.1),)).wait()
    assert time.monotonic() - begun < 20.0


def test_one_that_has_ended_already_gets_no_signal(deaf_to):
    process = deaf_to()
    process.kill()
    process.wait()
    assert ProcessEnd(process).wait() == -signal.SIGKILL
