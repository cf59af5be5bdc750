"""Regions on an engine's workers, each on two of them: whichever answers first counts.

A region says the same wherever it is, so that it does not matter which worker that was, or which
has died: the other has taken the same calls. A new one begins with what the region packed last,
and takes the calls since.
"""

import logging
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from time import monotonic
from typing import Any

from trackweave.config import load_configuration
from trackweave.engine import Actor, EngineError, Pool, engine_of
from trackweave.errors import InvalidInputError
from trackweave.service.live_region import LiveRegion
from trackweave.service.log import say
from trackweave.service.rehearsing import Rehearsal, warm_solvers
from trackweave.service.spec import Spec

__all__ = ["Seat", "Seats", "seats_of"]

EACH = 2
"""So many workers have each region: one, and its standby."""
SPARE = 1
"""So many have none, and need not start before they take a lost one's place."""
PATIENCE_S, START_S = 5.0, 300.0
"""After so long a worker counts as hung that the other one is ahead of, or that begins [s]."""
FAILED = 5
"""So many workers of a region in a row may be lost as they begin."""
LOOK_S = 0.25
_CHANGING = ("step", "bound")
"""What a worker that begins has to be told again."""
_log = logging.getLogger("trackweave.service")


class Seat:
    """A worker's own side: makes itself ready, then has a region.

    Parameters
    ----------
    configuration
        With what it will run.
    dim
        Number of dimensions of the tracking space.
    """

    def __init__(self, configuration: Mapping[str, Any], dim: int) -> None:
        Rehearsal().run(load_configuration(configuration), dim)
        warm_solvers()
        self._region: LiveRegion | None = None

    def take(self, state: bytes | None, calls: Sequence[tuple[str, Any]]) -> tuple[int, Any]:
        """Begin with a state, if one is given, and take calls; return the last one's answer."""
        if state is not None:
            self._region = LiveRegion.unpacked(state)
        answer = None
        for method, args in calls:
            answer = getattr(self._region, method)(*args)
        return os.getpid(), answer


@dataclass(eq=False)
class _Held:
    """A seat as the service has it."""

    actor: Actor
    since: float = field(default_factory=monotonic)
    """When it was told what it has not answered yet [s]."""
    is_made: bool = False
    taken: int | None = None
    """The last call that it has taken; None as long as it has no region."""
    told: int | None = None
    """The last call that it was told; None where it has answered."""
    pid: int = 0


@dataclass(eq=False)
class _Region:
    """A region: what it packed last, what it was asked since, and who has it."""

    state: bytes
    seats: list[_Held] = field(default_factory=list)
    calls: list[tuple[str, Any]] = field(default_factory=list)
    begin: int = 1
    """The number of the first of these calls."""
    answered: int = 0
    """The last call that somebody has answered."""
    answer: Any = None
    failed: int = 0
    later: float = 0.0
    """When the next worker is tried, where the last were lost as they began [s]."""

    @property
    def last(self) -> int:
        """The number of the last call."""
        return self.begin + len(self.calls) - 1


class Seats:
    """Regions on the workers of an engine.

    Parameters
    ----------
    pool
        The engine.
    most
        How many regions there may be.
    """

    def __init__(self, pool: Pool, most: int) -> None:
        self.cpu, self.most = 0.0, most
        self._pool, self._spec = pool, Spec({})
        self._regions: list[_Region] = []
        self._ready: list[_Held] = []
        self._later = 0.0
        self._reasons: dict[Actor, str] = {}

    def prepare(self, spec: Spec) -> None:
        """Have workers that are ready for the regions of a configuration."""
        cut, self._spec = len(spec.regions or ()), spec
        if cut > self.most:
            raise InvalidInputError(
                f"workers: {self.most}, and the journal has {cut} regions; expected --workers "
                f"{cut}"
            )
        # What compiles, or is loaded, does so once on this machine.
        Seat(spec.configuration, spec.dim)
        count = EACH * cut + SPARE
        while len(self._ready) + sum(len(each.seats) for each in self._regions) < count:
            self._ready.append(self._hired())
        while any(
            each.actor.is_alive and not (each.is_made or each.actor.has_answered)
            for each in self._ready
            if not self._is_overdue(each)
        ):
            self._pool.look(LOOK_S)

    def begin(self, states: Sequence[bytes]) -> None:
        """Have the regions that were packed, and no others."""
        before, self._regions = self._regions, [_Region(state) for state in states]
        held = [seat for each in before for seat in each.seats]
        for seat in held:
            # What it is about to answer is of before.
            seat.taken, seat.told = None, None if seat.told is None else -1
        self._ready += held
        self._turn(0.0)

    def ask(self, method: str, args: Sequence[tuple[Any, ...]]) -> list[Any]:
        """Return what a method of each region gives, with arguments for each."""
        for region, own in zip(self._regions, args, strict=True):
            region.calls.append((method, own))
        self._turn(0.0)
        while any(region.answered < region.last for region in self._regions):
            self._turn(LOOK_S)
        return [region.answer for region in self._regions]

    def packed(self) -> list[bytes]:
        """Return all that each region knows, with which a worker begins from now on."""
        states: list[bytes] = self.ask("packed", [()] * len(self._regions))
        for region, state in zip(self._regions, states, strict=True):
            region.begin, region.calls, region.state = region.last + 1, [], state
        return states

    def look(self) -> None:
        """See who has died, and who has begun."""
        if self._regions:
            self._turn(0.0)

    def workers(self) -> list[list[int]]:
        """Return the processes that have each region, the longest first."""
        return [
            [seat.pid for seat in list(region.seats) if seat.taken is not None]
            for region in self._regions
        ]

    def close(self) -> None:
        """End all workers."""
        self._pool.close()

    def _turn(self, seconds: float) -> None:
        """Take in what comes within so long at most, and see to every seat."""
        self._pool.look(seconds)
        for number, region in enumerate(self._regions):
            for seat in list(region.seats):
                self._attend(number, region, seat)
            self._fill(number, region)
        if not all(each.actor.is_alive for each in self._ready):
            self._ready = [each for each in self._ready if each.actor.is_alive]
            self._later = monotonic() + START_S
        if self._regions and len(self._ready) < SPARE and monotonic() >= self._later:
            self._ready.append(self._hired())

    def _attend(self, number: int, region: _Region, seat: _Held) -> None:
        """Hear what a seat says, and tell it what it does not know."""
        if seat.actor.has_answered:
            try:
                self._heard(number, region, seat, seat.actor.answer())
            except EngineError as err:
                self._leave(number, region, seat, str(err))
                return
        if not seat.actor.is_alive:
            self._leave(number, region, seat, self._reasons.pop(seat.actor, "was lost"))
            return
        is_behind = seat.taken is None or seat.taken < region.last
        if seat.is_made and seat.told is None and is_behind:
            self._tell(region, seat)
        if self._is_overdue(seat) and (seat.taken is None or region.answered >= (seat.told or 0)):
            self._leave(number, region, seat, "gave no answer in time")

    def _heard(self, number: int, region: _Region, seat: _Held, answer: Any) -> None:
        if not seat.is_made:
            seat.is_made = True
            return
        told, seat.told = seat.told, None
        if told is None or told < 0:
            return
        seat.pid, value = answer
        if seat.taken is None:
            region.failed = 0
            say(_log, logging.INFO, "region worker ready", region=number, pid=seat.pid)
        seat.taken = told
        if region.answered < told == region.last:
            region.answered, region.answer = told, value

    def _tell(self, region: _Region, seat: _Held) -> None:
        """Tell a seat the calls that it has not taken, and the state if it is not on the way."""
        state, begin = None, region.begin
        if seat.taken is None or seat.taken < region.begin - 1:
            state = region.state
        else:
            begin = seat.taken + 1
        calls = region.calls[begin - region.begin :]
        calls = [*(each for each in calls[:-1] if each[0] in _CHANGING), *calls[-1:]]
        seat.told, seat.since = region.last, monotonic()
        seat.actor.tell("take", state, calls)

    def _is_overdue(self, seat: _Held) -> bool:
        if seat.is_made and seat.told is None:
            return False
        return monotonic() - seat.since > (START_S if seat.taken is None else PATIENCE_S)

    def _leave(self, number: int, region: _Region, seat: _Held, reason: str) -> None:
        """Go on without a seat."""
        seat.actor.end()
        region.seats.remove(seat)
        say(_log, logging.WARNING, "region worker lost", region=number, pid=seat.pid,
            reason=reason)  # fmt: skip
        if seat.taken is None:
            region.failed += 1
            region.later = monotonic() + min(2.0**region.failed, 30.0)
        if region.failed >= FAILED and not region.seats:
            raise EngineError(
                f"engine: region {number} has no worker: {FAILED} in a row were lost as they "
                f"began, the last of which {reason}"
            )

    def _fill(self, number: int, region: _Region) -> None:
        """Have as many seats as a region needs: one more where none answers for long."""
        is_stuck = bool(region.seats) and all(map(self._is_overdue, region.seats))
        while len(region.seats) < EACH + is_stuck and monotonic() >= region.later:
            region.seats.append(self._ready.pop(0) if self._ready else self._hired())
            self._attend(number, region, region.seats[-1])
        if len(region.seats) > EACH and all(each.taken == region.last for each in region.seats):
            region.seats.pop().actor.end()

    def _hired(self) -> _Held:
        spec = self._spec
        configuration = {**spec.configuration}
        actor = self._pool.place(Seat, configuration, spec.dim, lost=self._note, waits=False)
        return _Held(actor)

    def _note(self, actor: Actor, reason: str) -> None:
        self._reasons[actor] = reason


def seats_of(name: str, most: int) -> Seats:
    """Return seats for at most so many regions on an engine, by its name."""
    # One more for a region that is stuck.
    return Seats(engine_of(name, EACH * most + SPARE + 1, time_limit=PATIENCE_S), most)
