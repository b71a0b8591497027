"""Waiting for work and handing it out, a job at a time: what is below executors.

Work comes from three sides. Sources in the network (subscriptions, services, …) and guard
conditions trigger a wait set of Cyclone DDS; timers come due; tasks are put in by anybody. Each
source may belong to a group that decides whether its work may run now.
"""

import threading
from collections import deque
from collections.abc import Callable, Coroutine, Iterable
from typing import Any, Protocol, cast

from embedded_ros import cyclone
from embedded_ros.deadline import Deadline
from embedded_ros.errors import ExternalShutdownException
from embedded_ros.futures import Task, TaskRunner
from embedded_ros.session import Session

__all__ = ["Group", "Job", "Source", "TimedSource", "WatchedSource", "WorkLoop"]

Call = tuple[Callable[..., Any], tuple[Any, ...]]


class Group(Protocol):
    """Which work may run at the same time: a callback group."""

    def can_execute(self, entity: Any) -> bool:
        """Tell whether the work of a source may run now."""
        ...

    def beginning_execution(self, entity: Any) -> bool:
        """Claim the right to run; False if it is not to be had now."""
        ...

    def ending_execution(self, entity: Any) -> None:
        """Give the right back."""
        ...


class Source(Protocol):
    """What work comes from."""

    @property
    def callback_group(self) -> Group | None:
        """Group of the work; None: it may always run."""
        ...

    def _take(self, runner: TaskRunner | None = None) -> Call | None:
        """Take one piece of work: a function and its arguments; None if there is none."""
        ...


class TimedSource(Source, Protocol):
    """Work that comes due."""

    def _due_in(self) -> int | None:
        """Nanoseconds to wait; 0 if it is due, None if waiting does not help."""
        ...


class WatchedSource(Source, Protocol):
    """Work that Cyclone DDS tells of."""

    @property
    def _wait_ref(self) -> int:
        """What a wait set watches."""
        ...


#: Work that was taken: from where, the function and its arguments. The group of the source is held
#: until :meth:`WorkLoop.finish`.
Job = tuple[Source, Callable[..., Any], tuple[Any, ...]]


class WorkLoop:
    """Knows when there is work, and gives it to those who ask.

    Parameters
    ----------
    session : Session
        Whose context this lives in.
    sources : callable
        Gives all sources in the order in which they are served when several are ready.
    """

    def __init__(self, session: Session, sources: Callable[[], Iterable[Source]]) -> None:
        self.is_closed = False
        self._session = session
        self._sources = sources
        self._bell = cyclone.GuardCondition(session.ref)
        self._wait_set = cyclone.WaitSet(session.ref)
        self._wait_set.attach(self._bell.ref)
        self._lock = threading.Lock()
        # Places in the order of serving: of timers, and of what the wait set watches by the number
        # that it reports.
        self._timers: list[tuple[int, TimedSource]] = []
        self._watched: dict[int, tuple[int, WatchedSource]] = {}
        self._is_outdated = True
        # Whether a source waits for its group. It is not watched meanwhile: it would wake the wait
        # set again and again.
        self._has_parked = False
        self._ready: deque[Source] = deque()
        self._tasks: deque[Task] = deque()
        # Coroutines that yielded without waiting for anything: they go on after a look around.
        self._idling: deque[Task] = deque()

    # ------------------------------------------------------------------ from any thread

    def interrupt(self) -> None:
        """Come out of the wait to see whether to stop."""
        self._bell.set()

    def look_again(self) -> None:
        """Ask for the sources again: there are others, or a group is free."""
        self._is_outdated = True
        self._bell.set()

    def put(self, task: Task) -> None:
        """Hand a task out soon."""
        self._tasks.append(task)
        self._bell.set()

    def create_task(
        self, callback: Callable[..., Any] | Coroutine[Any, Any, Any], *args: Any, **kwargs: Any
    ) -> Task:
        """Hand a function or coroutine out soon; the task is the future of its result."""
        task = Task(callback, args, kwargs, executor=self)
        self.put(task)
        return task

    def put_aside(self, task: Task) -> None:
        """Hand a task out when everything else has had a chance."""
        self._idling.append(task)

    def finish(self, source: Source) -> None:
        """Give the group of a job back."""
        group = source.callback_group
        if group is not None:
            group.ending_execution(source)
        if self._has_parked:
            self.look_again()

    def close(self) -> None:
        """Hand nothing out any more; who waits returns."""
        with self._lock:
            self.is_closed = True
            self._bell.set()
            self._wait_set.close()
            self._bell.close()
            self._timers = []
            self._watched = {}
        self._ready.clear()

    # ------------------------------------------------------------------ from those who work

    def next(self, deadline: Deadline, stop: Callable[[], bool]) -> Job | Task | None:
        """Wait for work.

        Returns
        -------
        Job, Task or None
            None after the deadline, after :meth:`close`, and when `stop` says so: it is asked
            first, and after each interruption.

        Raises
        ------
        ExternalShutdownException
            If the context is shut down.
        """
        while not self.is_closed and not stop():
            work = self._pop()
            if work is not None:
                return work
            if self._is_outdated:
                # In this order: what the bell has been rung for is all looked at after this.
                self._bell.clear()
                self._ask_for_sources()
                continue
            is_last_look = self._session.valid and self._look(deadline.nanoseconds_left())
            if self.is_closed:
                break
            if not self._session.valid:
                raise ExternalShutdownException
            if is_last_look and not self._ready and not self._tasks:
                break
        return None

    def _pop(self) -> Job | Task | None:
        if self._tasks:
            return self._tasks.popleft()
        while self._ready:
            source = self._ready.popleft()
            group = source.callback_group
            if group is not None and not group.beginning_execution(source):
                self._park()
                continue
            try:
                call = source._take(self)
            except BaseException:
                self.finish(source)
                raise
            if call is not None:
                return source, *call
            self.finish(source)
        return None

    def _park(self) -> None:
        # In this order: the group may be freed at this very moment.
        self._has_parked = True
        self._is_outdated = True

    def _look(self, left: int) -> bool:
        """Wait up to `left` nanoseconds for something to be ready; tell whether none are left."""
        wait = 0 if self._tasks or self._idling else self._until_next_timer(left)
        fired = self._wait_set.wait(wait)
        if self._bell.ref in fired:
            # Before the looks at what it may have been rung for: the next wait would miss it.
            self._bell.clear()
            fired.remove(self._bell.ref)
        if self.is_closed:
            return True
        ready: list[tuple[int, Source]] = []
        for ref in fired:
            seen = self._watched.get(ref)
            if seen is not None:
                ready.append(seen)
        # A timer that came due while something else ended the wait makes the next one short.
        if wait == 0 or not fired:
            ready += [(place, timer) for place, timer in self._timers if timer._due_in() == 0]
        if len(ready) > 1:
            ready.sort(key=_place)
        for _, source in ready:
            self._ready.append(source)
        while self._idling:
            self._tasks.append(self._idling.popleft())
        return left <= 0

    def _until_next_timer(self, left: int) -> int:
        for _, timer in self._timers:
            due = timer._due_in()
            if due is None or due >= left:
                continue
            group = timer.callback_group
            if due == 0 and group is not None and not group.can_execute(timer):
                self._has_parked = True
                if not group.can_execute(timer):
                    continue
            left = due
        return left

    def _ask_for_sources(self) -> None:
        self._is_outdated = False
        # Up while we look: who frees a group meanwhile must have us look again.
        self._has_parked = True
        has_parked = False
        timers: list[tuple[int, TimedSource]] = []
        watched: dict[int, tuple[int, WatchedSource]] = {}
        alive: set[int] = set()
        for place, source in enumerate(self._sources()):
            group = source.callback_group
            if hasattr(source, "_due_in"):
                timers.append((place, cast("TimedSource", source)))
            elif group is None or group.can_execute(source):
                seen = cast("WatchedSource", source)
                watched[seen._wait_ref] = (place, seen)
            else:
                has_parked = True
                continue
            alive.add(id(source))
        self._has_parked = has_parked
        with self._lock:
            if self.is_closed:
                return
            for ref in self._watched.keys() - watched.keys():
                self._wait_set.detach(ref)
            for ref in watched.keys() - self._watched.keys():
                self._wait_set.attach(ref)
            self._watched = watched
            self._timers = timers
        for source in [source for source in self._ready if id(source) not in alive]:
            self._ready.remove(source)


def _place(ready: tuple[int, Source]) -> int:
    return ready[0]
