"""What an engine promises to those who use it, and what it asks of those who bring workers."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from trackweave.errors import TrackweaveError

__all__ = [
    "Actor",
    "Death",
    "Engine",
    "EngineError",
    "Host",
    "Outcome",
    "Worker",
    "WorkerLostError",
]


class EngineError(TrackweaveError):
    """No worker can be had: a library is missing, a cluster does not answer, none starts.

    Examples
    --------
    >>> import trackweave as tw
    >>> issubclass(tw.EngineError, tw.TrackweaveError)
    True
    """


class WorkerLostError(TrackweaveError):
    """The worker of an actor was killed, or did not answer in time; its state is lost."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """What came of a task.

    Parameters
    ----------
    ticket
        Its number, as ``submit`` returned it.
    value
        What it returned, None where it failed.
    error
        Why it failed, in one line; None where it did not.
    is_lost
        Whether it failed because its workers were lost, each time; else it raised by itself.
    """

    ticket: int
    value: Any = None
    error: str | None = None
    is_lost: bool = False


class Actor(Protocol):
    """An object that lives in a worker of its own."""

    @property
    def is_alive(self) -> bool:
        """Whether its worker was there when it was last looked for."""

    @property
    def has_answered(self) -> bool:
        """Whether an answer was there when it was last looked for."""

    def tell(self, method: str, *args: Any) -> None:
        """Call a method and do not wait; calls are taken one after the other."""

    def answer(self) -> Any:
        """Return what the oldest call not yet answered returned, waiting for it.

        Raises ``EngineError`` with the method's own error, and ``WorkerLostError`` where the
        actor is dead.
        """

    def end(self) -> None:
        """End it; nobody is told of this death."""


class Engine(Protocol):
    """Workers that carry out tasks and house actors."""

    workers: int
    """How many tasks are carried out at a time."""

    def submit(self, work: Callable[..., Any], *args: Any) -> int:
        """Enter a task, a function of an importable module with its arguments; return its ticket.

        Tickets count from 0. Work begins once somebody gathers.
        """

    def gather(self, *, in_order: bool = True) -> Iterator[Outcome]:
        """Yield what comes of all tasks entered and not yet gathered.

        In the order in which they were entered, or each as soon as it is there.
        """

    def place(
        self,
        make: Callable[..., Any],
        *args: Any,
        lost: Callable[[Actor, str], None] | None = None,
        waits: bool = True,
    ) -> Actor:
        """Make an object in a worker of its own, beside those of tasks.

        ``lost`` is called once with the actor and the reason when its worker dies, from within
        the next call that waits: ``gather``, ``look`` or ``answer``. Where nobody waits, the
        actor's first answer, which is None, says that it is made.
        """

    def look(self, seconds: float = 0.0) -> None:
        """See for at most so long whether an actor has died, and tell those who asked."""

    def close(self) -> None:
        """End all workers at once; who submits or places after that is refused."""


@dataclass(frozen=True, slots=True)
class Death:
    """That a worker is there no more, and why."""

    reason: str


class Worker(Protocol):
    """A process that answers calls, one at a time."""

    def send(self, call: bytes) -> None:
        """Send a call, whose reply ``Host.wait`` returns; a dead worker says nothing."""

    def kill(self) -> None:
        """End it at once, whatever it does."""


class Host(Protocol):
    """Whoever brings workers."""

    def hire(self) -> Worker:
        """Return a new worker, which may not have started yet."""

    def wait(
        self, workers: Sequence[Worker], seconds: float | None
    ) -> list[tuple[Worker, bytes | Death]]:
        """Return replies and deaths as soon as there are any, nothing when the time is over."""

    def close(self) -> None:
        """Leave whatever workers came from."""
