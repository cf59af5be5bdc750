"""The one way in which tasks are given out, whoever brings the workers."""

from collections import deque
from collections.abc import Callable, Iterator
from time import monotonic
from types import TracebackType
from typing import Any, Self

from trackweave.engine.protocol import (
    Actor,
    Death,
    EngineError,
    Host,
    Outcome,
    Worker,
    WorkerLostError,
)
from trackweave.engine.serving import GREETING, packed_call, unpacked_reply

__all__ = ["Pool"]

ATTEMPTS = 3
"""To so many workers a task is given before it counts as lost."""
STILLBORN = 3
"""So many workers in a row may end as they start before nobody else is tried."""
START_S = 120.0
"""So long a worker may take to start [s]."""


class _Task:
    """A call with its ticket, and how often it was given out."""

    def __init__(self, ticket: int, call: bytes) -> None:
        self.ticket, self.call, self.attempts = ticket, call, 0


class _Post:
    """A worker and what it does: starting, idle, or busy with a task until a time."""

    def __init__(self, worker: Worker, actor: "_Placed | None" = None) -> None:
        self.worker, self.actor = worker, actor
        self.is_ready, self.task, self.until = False, None, monotonic() + START_S
        worker.send(GREETING)

    task: _Task | None
    until: float | None


class Pool:
    """An engine on the workers of a host: see ``trackweave.engine.protocol.Engine``.

    A worker that dies is noticed at once and replaced; its task goes to another, three times at
    most, and then counts as lost. So does one that is over its time limit.

    Parameters
    ----------
    host
        Whoever brings workers.
    workers
        How many tasks are carried out at a time.
    time_limit
        Wall clock of one task or of one answer of an actor after which its worker counts as hung
        [s]; None for none.
    """

    def __init__(self, host: Host, workers: int, *, time_limit: float | None = None) -> None:
        self.workers = workers
        self._host, self._time_limit = host, time_limit
        self._posts: dict[Worker, _Post] = {}
        self._waiting: deque[_Task] = deque()
        self._found: dict[int, Outcome] = {}
        self._due: list[int] = []
        self._tickets = self._stillborn = 0
        self._is_closed = False

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def submit(self, work: Callable[..., Any], *args: Any) -> int:
        """Enter a task; return its ticket."""
        self._require_open()
        task = _Task(self._tickets, packed_call("do", work, args))
        self._tickets += 1
        self._due.append(task.ticket)
        self._waiting.append(task)
        return task.ticket

    def gather(self, *, in_order: bool = True) -> Iterator[Outcome]:
        """Yield what comes of all tasks entered and not yet gathered."""
        while self._due:
            ready = self._due[:1] if in_order else list(self._due)
            ready = [ticket for ticket in ready if ticket in self._found]
            for ticket in ready:
                self._due.remove(ticket)
                yield self._found.pop(ticket)
            if not ready:
                self._give_out()
                self._wait(None)

    def place(
        self,
        make: Callable[..., Any],
        *args: Any,
        lost: Callable[[Actor, str], None] | None = None,
        waits: bool = True,
    ) -> Actor:
        """Make an object in a worker of its own."""
        self._require_open()
        call = packed_call("make", make, args)
        post = _Post(self._host.hire())
        post.actor = _Placed(self, post.worker, lost)
        self._posts[post.worker] = post
        post.worker.send(call)
        post.actor.calls += 1
        if waits:
            post.actor.answer()
        return post.actor

    def look(self, seconds: float = 0.0) -> None:
        """See for at most so long whether an actor has died, and tell those who asked."""
        self._wait(seconds)

    def close(self) -> None:
        """End all workers at once."""
        self._is_closed = True
        while self._posts:
            _, post = self._posts.popitem()
            post.worker.kill()
        self._host.close()

    def dismiss(self, worker: Worker) -> None:
        """End a worker of which nobody needs to be told."""
        if self._posts.pop(worker, None) is not None:
            worker.kill()

    def until_heard(self, actor: "_Placed") -> None:
        """Wait until an actor has replied, or is dead."""
        post = self._posts.get(actor.worker)
        if post is not None and post.is_ready and self._time_limit is not None:
            post.until = monotonic() + self._time_limit
        while actor.is_alive and not actor.replies:
            self._wait(None)
        if post is not None:
            post.until = None

    def _require_open(self) -> None:
        """Refuse what would bring workers that nobody ends."""
        if self._is_closed:
            raise EngineError("engine: closed; expected work before close()")

    def _give_out(self) -> None:
        """Give tasks to idle workers, and hire as many as there is work for."""
        own = [post for post in self._posts.values() if post.actor is None]
        for post in own:
            if post.is_ready and post.task is None and self._waiting:
                post.task = self._waiting.popleft()
                post.task.attempts += 1
                limit = self._time_limit
                post.until = None if limit is None else monotonic() + limit
                post.worker.send(post.task.call)
        starting = sum(not post.is_ready for post in own)
        for _ in range(min(self.workers - len(own), len(self._waiting) - starting)):
            post = _Post(self._host.hire())
            self._posts[post.worker] = post

    def _wait(self, seconds: float | None) -> None:
        """Take in what comes next: replies, deaths, ends of patience."""
        ends = [post.until for post in self._posts.values() if post.until is not None]
        now = monotonic()
        if ends:
            nearest = max(0.0, min(ends) - now)
            seconds = nearest if seconds is None else min(nearest, seconds)
        for worker, reply in self._host.wait(list(self._posts), seconds):
            post = self._posts.get(worker)
            if post is None:  # ended by someone who was told of another's death
                continue
            if isinstance(reply, Death):
                self._bury(post, reply.reason)
            else:
                self._take(post, reply)
        for post in list(self._posts.values()):
            if post.until is not None and post.until <= monotonic():
                limit = self._time_limit if post.is_ready else START_S
                self._bury(post, f"gave no answer within {limit:g} s")

    def _take(self, post: _Post, reply: bytes) -> None:
        if not post.is_ready:
            post.is_ready, post.until, self._stillborn = True, None, 0
            return
        went_well, value = unpacked_reply(reply)
        if post.actor is not None:
            post.actor.replies.append((went_well, value))
        elif post.task is not None:
            ticket, post.task, post.until = post.task.ticket, None, None
            self._found[ticket] = Outcome(ticket, value if went_well else None,
                                          None if went_well else value)  # fmt: skip

    def _bury(self, post: _Post, reason: str) -> None:
        """Take leave of a worker: its task goes to another, whoever asked is told of an actor."""
        self.dismiss(post.worker)
        if post.actor is not None:
            post.actor.die(reason)
        elif not post.is_ready:
            self._miss(reason)
        elif post.task is not None:
            task = post.task
            if task.attempts < ATTEMPTS:
                self._waiting.appendleft(task)
            else:
                error = f"given to {ATTEMPTS} workers; the last {reason}"
                self._found[task.ticket] = Outcome(task.ticket, error=error, is_lost=True)

    def _miss(self, reason: str) -> None:
        """Go on with fewer workers where some start and others do not."""
        self._stillborn += 1
        if self._stillborn < STILLBORN:
            return
        if not any(post.is_ready for post in self._posts.values()):
            raise EngineError(
                f"engine: {STILLBORN} workers in a row did not start; the last {reason}"
            )
        self.workers = max(1, self.workers - 1)


class _Placed:
    """An actor, as its owner has it."""

    def __init__(
        self, pool: Pool, worker: Worker, lost: Callable[[Actor, str], None] | None
    ) -> None:
        self.worker, self.is_alive, self.calls = worker, True, 0
        self.replies: deque[tuple[bool, Any]] = deque()
        self._pool, self._lost, self._reason = pool, lost, "was ended"

    @property
    def has_answered(self) -> bool:
        """Whether `answer` need not wait."""
        return bool(self.replies)

    def tell(self, method: str, *args: Any) -> None:
        """Call a method and do not wait."""
        call = packed_call("ask", method, args)
        self.calls += 1
        self.worker.send(call)

    def answer(self) -> Any:
        """Return what the oldest call not yet answered returned."""
        if self.calls == 0:
            raise EngineError("actor: no call to answer; expected one by tell() before")
        self._pool.until_heard(self)
        self.calls -= 1
        if not self.replies:
            raise WorkerLostError(f"actor: its worker {self._reason}")
        went_well, value = self.replies.popleft()
        if not went_well:
            raise EngineError(value)
        return value

    def end(self) -> None:
        """End it; nobody is told."""
        self._reason = "was ended"
        self.is_alive = False
        self._pool.dismiss(self.worker)

    def die(self, reason: str) -> None:
        """Note that the worker is there no more, and tell whoever asked."""
        self.is_alive, self._reason = False, reason
        if self._lost is not None:
            self._lost(self, reason)
