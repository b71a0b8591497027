"""Signals that come while Cyclone DDS calls Python functions."""

import signal
import threading

import pytest
from embedded_ros.held_signals import HeldSignals
from embedded_ros.service_calls import _client_id

pytestmark = pytest.mark.usefixtures("signals_as_in_any_program")


def interrupted_work(done):
    with HeldSignals():
        signal.raise_signal(signal.SIGINT)
        done.append("work")


def test_the_handler_runs_after_the_block():
    done = []
    with pytest.raises(KeyboardInterrupt):
        interrupted_work(done)
    assert done == ["work"]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_one_block_in_another_waits_for_the_outer_one():
    def outer():
        with HeldSignals():
            interrupted_work(done)
            done.append("more")

    done = []
    with pytest.raises(KeyboardInterrupt):
        outer()
    assert done == ["work", "more"]


def test_what_python_does_not_handle_stays_as_it_is():
    assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL
    with HeldSignals():
        assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL


def test_a_signal_between_two_handlers_leaves_both_as_they_were(monkeypatch):
    """SIGTERM's handler raises while that of SIGINT is exchanged already."""

    def refuse(_number, _handler):
        monkeypatch.undo()
        raise SystemExit(3)

    before = signal.signal(signal.SIGTERM, lambda *_: None)
    exchange = signal.signal
    try:
        monkeypatch.setattr(
            signal, "signal", lambda *two: (refuse if two[0] == signal.SIGTERM else exchange)(*two)
        )
        with pytest.raises(SystemExit), HeldSignals():
            pass
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    finally:
        signal.signal(signal.SIGTERM, before)


def test_other_threads_do_without():
    done = []

    def work():
        with HeldSignals():
            done.append(signal.getsignal(signal.SIGINT))

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert done == [signal.default_int_handler]


def test_ctrl_c_while_a_client_is_looked_up_is_that():
    done = []

    def lookup(*_):
        signal.raise_signal(signal.SIGINT)
        done.append("looked up")

    with pytest.raises(KeyboardInterrupt):
        _client_id(lookup, 0, 0)
    assert done == ["looked up"]
