"""``ros2 bag record``: write the messages of topics into a bag."""

import argparse
import datetime as dt
import re
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from rclpy.executors import SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions
from ros2cli.bag_recorder import Recorder, Selection
from ros2cli.errors import CommandError
from ros2cli.node_session import command_node, full_topic_name

__all__ = ["record"]

_FINISH_S = 1.0
#: One spin may run a callback that is no message's.
_IDLE_SPINS = 3


def record(arguments: argparse.Namespace) -> None:
    """``bag record``."""
    path = Path(arguments.output or f"{dt.datetime.now():rosbag2_%Y_%m_%d-%H_%M_%S}")
    _check(arguments, path)
    # A signal must not end this in the middle of a write: it only asks for the end.
    with (
        _stop_on_signals() as stop,
        _open_writer(path, arguments) as writer,
        command_node(
            name=arguments.node_name,
            use_sim_time=arguments.use_sim_time,
            signals=SignalHandlerOptions.NO,
        ) as node,
    ):
        topics = arguments.topics or arguments.topics_positional
        selection = Selection(
            topics=frozenset(full_topic_name(node, topic) for topic in topics),
            types=frozenset(arguments.topic_types),
            all_topics=arguments.all,
            pattern=arguments.regex,
            excluded=frozenset(full_topic_name(node, topic) for topic in arguments.exclude_topics),
            excluded_pattern=arguments.exclude_regex,
            hidden=arguments.include_hidden_topics,
            unpublished=arguments.include_unpublished_topics,
        )
        recorder = Recorder(node, writer, selection)
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        try:
            _run(recorder, executor, stop, arguments)
            _finish(recorder, executor)
        finally:
            executor.shutdown()
        node.get_logger().info("Recording stopped")


def _run(
    recorder: Recorder,
    executor: SingleThreadedExecutor,
    stop: threading.Event,
    arguments: argparse.Namespace,
) -> None:
    log = recorder.node.get_logger()
    log.info("Listening for topics...")
    log.info("Recording...")
    interval = arguments.polling_interval * 1e-3
    # Peers that are there take a while to be seen.
    last_look = time.monotonic() + 0.5 if arguments.no_discovery else float("inf")
    next_look = 0.0
    while not stop.is_set():
        now = time.monotonic()
        if next_look <= now:
            recorder.look_for_topics()
            next_look = now + interval if now < last_look else float("inf")
        # Never wait for long: Python runs signal handlers only between two waits.
        executor.spin_once(timeout_sec=min(interval, max(next_look - time.monotonic(), 0.0)))


def _finish(recorder: Recorder, executor: SingleThreadedExecutor) -> None:
    """Write what has arrived but was not taken yet; busy topics must not prolong this."""
    end = time.monotonic() + _FINISH_S
    idle = 0
    while idle < _IDLE_SPINS and time.monotonic() < end:
        before = recorder.message_count
        executor.spin_once(timeout_sec=0.0)
        idle = 0 if recorder.message_count > before else idle + 1


def _check(arguments: argparse.Namespace, path: Path) -> None:
    if arguments.topics and arguments.topics_positional:
        raise CommandError("Give topics either after --topics or without it")
    chosen = (arguments.topics, arguments.topics_positional, arguments.topic_types, arguments.regex)
    if not arguments.all and not any(chosen):
        raise CommandError("Name topics to record, or use --all, --regex or --topic-types")
    if path.exists():
        raise CommandError(f"'{path}' already exists; a recording needs a new folder")
    if arguments.use_sim_time and arguments.no_discovery:
        raise CommandError("--use-sim-time needs /clock, which --no-discovery may miss; use one")
    for option in ("regex", "exclude_regex"):
        try:
            re.compile(getattr(arguments, option))
        except re.error as error:
            name = option.replace("_", "-")
            raise CommandError(f"--{name} is no regular expression: {error}") from None
    for item in arguments.custom_data:
        if "=" not in item:
            raise CommandError(f"--custom-data takes KEY=VALUE, not '{item}'")


@contextmanager
def _open_writer(path: Path, arguments: argparse.Namespace) -> Iterator[Any]:
    """Open a bag for writing; it is complete when the context ends without an error.

    Yields
    ------
    rosbags.rosbag2.Writer
    """
    from rosbags.rosbag2 import StoragePlugin, Writer, WriterError

    plugin = StoragePlugin[arguments.storage.upper()]
    try:
        with Writer(path, version=Writer.VERSION_LATEST, storage_plugin=plugin) as writer:
            for item in arguments.custom_data:
                key, _, value = item.partition("=")
                writer.set_custom_data(key, value)
            yield writer
    except (WriterError, OSError) as error:
        raise CommandError(f"Could not write bag '{path}': {error}") from None


@contextmanager
def _stop_on_signals() -> Iterator[threading.Event]:
    """Yield an event that SIGINT and SIGTERM set."""
    stop = threading.Event()

    def ask_to_stop(_number: int, _frame: object) -> None:
        stop.set()

    before: dict[signal.Signals, Callable[..., Any] | int | None] = {
        number: signal.signal(number, ask_to_stop) for number in (signal.SIGINT, signal.SIGTERM)
    }
    try:
        yield stop
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
