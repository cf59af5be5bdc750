"""Reports that come one after the other become the scans that ``track`` cuts from a recording.

A scan is complete once its sensor has told something later, or once it is said that nothing is
waited for any more. Scans of several sensors go on in order of time; between two of a sensor that
scans, the empty ones are put where ``trackweave.run.scans`` puts them.
"""

import heapq
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.domain.foreign_kind import ForeignKind
from trackweave.domain.measurements import MeasurementKind
from trackweave.domain.scans import Scan
from trackweave.models.rotation import Rotation
from trackweave.models.sensors import Sensor
from trackweave.run.batches import Batch
from trackweave.run.doubles import repeats_within
from trackweave.run.held import HeldPlaces
from trackweave.run.scans import FULL, LAST, MOST_MISSING, N_SECTORS, Sectors, missing_times
from trackweave.service.blocks import (
    Block,
    joined,
    keys_of,
    scan_of,
    without_copies,
    without_held,
    without_pieces,
)

__all__ = ["Cutter", "SensorCut"]

MISSED = 1.5
"""So many periods after the last scan the next is missed, where nothing is waited for."""
EARLY = -np.inf
REMEMBERED = 16
"""A copy is known of so many scans, or turns; what is older comes too late for any window."""


@dataclass(slots=True)
class SensorCut:
    """One sensor's reports, on their way into scans."""

    name: str
    place: int
    """Among the sensors: of scans of one time the lesser goes first."""
    width: int
    """How many numbers an empty scan's reports would have."""
    period: float | None
    rotation: Rotation | None
    scans: bool
    """Whether what stands still is reported anew at each scan."""
    within: float  # For how long it may repeat what it has said [s]
    kind: MeasurementKind | ForeignKind
    extent: float
    """How far each of several reports of one object is from the next at most [m]."""
    pending: dict[float, list[Block]] = field(default_factory=dict)
    """Reports of scans that are open, by time, by the scan's number or by that of the sector."""
    told: float = EARLY
    """The latest time of its reports [s]."""
    until: float = EARLY
    """Up to when nothing is waited for any more [s]."""
    last: float | None = None
    """Time of the last scan [s], of a turning sensor the number of the last sector."""
    n_missed: int = 0
    """Empty scans since the last that was not."""
    heard: dict[float, int] = field(default_factory=dict)
    """How many reports its last scans had by time, or the sectors of its last turns by number."""
    said: dict[float, list[bytes]] = field(default_factory=dict)
    """What the reports of the same scans said, so that copies that come late are known."""
    numbered: bool = False
    """Whether its reports say the numbers of their scans."""
    platform: tuple[float, FloatArray] | None = None
    """When and where it was last, where its reports say so."""
    recent: dict[bytes, float] = field(default_factory=dict)  # What it said last, and when first
    held: HeldPlaces | None = None  # Places that it may go on saying of what has moved on

    @classmethod
    def of(cls, sensor: Sensor, place: int, dim: int, *, is_on_earth: bool) -> "SensorCut":
        """Return a sensor before its first report."""
        width = sensor.measurement.n_components(dim)
        return cls(
            sensor.name, place, width, sensor.scan_period, sensor.rotation,
            sensor.scans is not False, repeats_within(sensor), sensor.measurement, sensor.extent,
            held=HeldPlaces.of(sensor, is_on_earth=is_on_earth),
        )  # fmt: skip

    def feed(self, block: Block) -> None:
        """Take reports in."""
        if self.within > 0.0:
            block = self._heard_once(block)
        if not len(block.time):
            return
        self.numbered = block.scan.size > 0
        keys = self._keys(block)
        self.told = max(self.told, float(block.time.max()))
        for key in np.unique(keys).tolist():
            own = block.at(np.flatnonzero(keys == key))
            self.pending.setdefault(key, []).append(own)

    def complete(self) -> Iterator[Scan]:
        """Yield scans that are complete, and take them out; empty ones are between them."""
        if not (self.scans or self.numbered):
            yield from self._batches()
            return
        for key in sorted(self.pending):
            block = self.pending[key]
            if not self._is_complete(key, block):
                continue
            del self.pending[key]
            yield from self._closed(key, joined(block))
        if not self.pending:
            yield from self._missed()

    def _batches(self) -> Iterator[Scan]:
        """Yield the batches that are complete, and take them out."""
        batch, keys, now = Batch(), list[float](), max(self.told, self.until)
        for key in sorted(self.pending):
            if not self._is_complete(key, self.pending[key]):
                break
            if self.last is not None and key <= self.last:
                yield from self._closed(key, joined(self.pending.pop(key)))
                continue
            names = [name for part in self.pending[key] for name in part.identity.tolist()]
            if not batch.takes(key, names):
                yield from self._batch(keys)
                batch, keys = Batch(), []
                batch.takes(key, names)
            keys.append(key)
        if keys and batch.is_over(now):
            yield from self._batch(keys)

    def _batch(self, keys: list[float]) -> Iterator[Scan]:
        blocks = [part for key in keys for part in self.pending.pop(key)]
        yield from self._closed(keys[-1], joined(blocks))

    def bound(self) -> tuple[float, bool]:
        """Return before which time no scan can come any more, and whether one of it can."""
        if self.rotation is not None:
            return self._end_of_next(), True
        first = min(self.pending, default=None)
        if first is not None:
            if self.numbered:
                first = min(float(part.time.min()) for part in self.pending[first])
            if self.last is not None and self.period is not None and self._most_missed() > 0:
                first = next(missing_times([self.last, first], self.period), first)
            return first, True
        return max(self.told, self._until()), False

    def jumped(self, time: float) -> None:
        """Begin anew at a time: what was before has nothing to do with it."""
        self.pending.clear()
        self.recent.clear()
        self.held = None if self.held is None else HeldPlaces()
        self.heard.clear()
        self.said.clear()
        self.told, self.until, self.last, self.n_missed = time, EARLY, None, 0

    def _until(self) -> float:
        if self.period is None or self.last is None or self.n_missed >= self._most_missed():
            return self.until
        return min(self.until, self.last + self.period)

    def _keys(self, block: Block) -> FloatArray:
        if self.rotation is not None:
            return Sectors(self.rotation, block.time).number.astype(np.float64)
        return block.scan.astype(np.float64) if self.numbered else block.time

    def _is_complete(self, key: float, blocks: list[Block]) -> bool:
        if self.rotation is not None:
            begun = float(self.rotation.turned(self.told)) * N_SECTORS
            return np.floor(begun) > key or self.until >= self._end(int(key))
        if not self.numbered:
            return key < self.told or key <= self.until
        newest = max(float(part.time.max()) for part in blocks)
        wait = (self.period or 1.0) / 2.0
        return newest < self.told or newest + wait <= self.until

    def _closed(self, key: float, block: Block) -> Iterator[Scan]:
        end = float(block.time.max())
        own_times = bool(np.any(block.time != end))
        if self.rotation is not None:
            end, own_times = max(self._end(int(key)), end), True
        block = without_copies(block, at_any_time=self.numbered)
        block = without_pieces(block, self.kind, self.extent)
        mark = key if self.rotation is not None else end
        is_next = self.last is None or mark > self.last
        block = without_held(block, self.held, end) if is_next else block
        if not len(block.time):
            return
        said = self._said_by(block)
        if not is_next:
            known = {what for each in self.said.values() for what in each}
            new = [row for row, what in enumerate(said) if what not in known]
            if not new:
                return
            block, said = block.at(np.array(new)), [said[row] for row in new]
        self.said.setdefault(mark, []).extend(said)
        if is_next:
            yield from self._empty_before(mark, block)
            self.last, self.n_missed = mark, 0
            self.heard[mark] = len(block.time)
            last = sorted(self.heard)[-LAST:]
            if self.rotation is not None:
                last = [sector for sector in self.heard if sector > mark - LAST * N_SECTORS]
            self.heard = {key: self.heard[key] for key in last}
            most = REMEMBERED if self.rotation is None else REMEMBERED * N_SECTORS
            self.said = {key: self.said[key] for key in sorted(self.said)[-most:]}
        if not np.isnan(block.platform[:, 0]).any():
            self.platform = float(block.time[-1]), block.platform[-1]
        yield scan_of(block, self.name, end, own_times=own_times)

    def _said_by(self, block: Block) -> list[bytes]:
        """Return of each report what its copies say: all, but for the time in a numbered scan."""
        keys = keys_of(block)
        if self.numbered:
            return [key + b"%d" % number for key, number in zip(keys, block.scan, strict=True)]
        return [key + time.tobytes() for key, time in zip(keys, block.time, strict=True)]

    def _empty_before(self, mark: float, block: Block) -> Iterator[Scan]:
        if self.last is None:
            return
        if self.rotation is not None:
            between = self._between(int(self.last), int(mark))
            times = [self._end(number) for number in between]
        elif self.period is not None:
            times = list(missing_times([self.last, mark], self.period))
            times = times if self.n_missed < MOST_MISSING else times[-MOST_MISSING:]
            times = times if self._most_missed() else []
        else:
            return
        after = float(block.time[0]), block.platform[0]
        for time in times:
            yield self._empty(time, after)

    def _empty(self, time: float, after: tuple[float, FloatArray] | None = None) -> Scan:
        where = None
        if self.platform is not None:
            where = self.platform[1]
            if after is not None and not np.isnan(after[1][0]):
                moments = [self.platform[0], after[0]]
                both = np.stack([self.platform[1], after[1]])
                where = np.array([np.interp(time, moments, both[:, k]) for k in range(6)])
        scan = Scan(time, self.name, np.empty((0, self.width)), platform=where)
        return replace(scan, moments=np.empty(0)) if self.rotation is not None else scan

    def _missed(self) -> Iterator[Scan]:
        """Yield the scans in which a sensor has surely seen nothing."""
        if self.last is None or not np.isfinite(self.until):
            return
        most = self._most_missed()
        if self.rotation is not None:
            while self.n_missed < most and self._end(int(self.last) + 1) <= self.until:
                self.last += 1
                self.n_missed += 1
                yield self._empty(self._end(int(self.last)))
        elif self.period is not None:
            while self.n_missed < most and self.last + MISSED * self.period <= self.until:
                self.last += self.period
                self.n_missed += 1
                yield self._empty(self.last)

    def _most_missed(self) -> int:
        """Return how many empty scans, or sectors, a sensor has had before it counts as silent."""
        if sum(self.heard.values()) >= LAST * FULL:
            return 0 if self.rotation is None else N_SECTORS
        return MOST_MISSING if self.rotation is None else MOST_MISSING * N_SECTORS

    def _between(self, before: int, after: int) -> list[int]:
        """Return the sectors between two, of a long silence only those near its two ends."""
        most = self._most_missed()
        early = range(before + 1, min(before + 1 + max(most - self.n_missed, 0), after))
        if most == N_SECTORS:
            return list(early)
        return [*early, *range(max(early.stop, after - most), after)]

    def _end(self, sector: int) -> float:
        assert self.rotation is not None
        return float(self.rotation.when((sector + 1) / N_SECTORS))

    def _end_of_next(self) -> float:
        assert self.rotation is not None
        if self.last is not None and self.n_missed < self._most_missed():
            return self._end(int(self.last) + 1)
        if self.pending:
            return self._end(int(min(self.pending)))
        if not np.isfinite(max(self.told, self.until)):
            return max(self.told, self.until)
        now = float(self.rotation.turned(max(self.told, self.until))) * N_SECTORS
        return self._end(int(np.floor(now)))

    def _heard_once(self, block: Block) -> Block:
        """Return reports without those that say again what was said a moment before."""
        kept, order = [], np.argsort(block.time, kind="stable").tolist()
        keys = keys_of(block)
        for row in order:
            time = float(block.time[row])
            first = self.recent.get(keys[row])
            if first is None or not 0.0 <= time - first <= self.within:
                self.recent[keys[row]] = time
                kept.append(row)
        since = float(block.time.max(initial=EARLY)) - self.within
        self.recent = {key: time for key, time in self.recent.items() if time >= since}
        return block if len(kept) == len(order) else block.at(np.asarray(kept, dtype=np.int64))


@dataclass(slots=True)
class Cutter:
    """The reports of all sensors, on their way into scans in order of time."""

    sensors: dict[str, SensorCut]
    waiting: list[tuple[float, int, int, Scan]] = field(default_factory=list)
    """Complete scans, a heap by time and sensor."""
    serial: int = 0

    @classmethod
    def of(cls, sensors: tuple[Sensor, ...], dim: int, *, is_on_earth: bool) -> "Cutter":
        """Return a cutter before the first report; scans of one time are in this order."""
        cuts = [
            SensorCut.of(each, k, dim, is_on_earth=is_on_earth) for k, each in enumerate(sensors)
        ]
        return cls({cut.name: cut for cut in cuts})

    @property
    def latest(self) -> float:
        """The latest time that any sensor has told [s]."""
        return max((cut.told for cut in self.sensors.values()), default=EARLY)

    def now(self) -> float:
        """Return up to when all was told [s]."""
        return max((max(cut.told, cut.until) for cut in self.sensors.values()), default=EARLY)

    def feed(self, blocks: Mapping[str, Block]) -> None:
        """Take reports in."""
        for name, block in blocks.items():
            self.sensors[name].feed(block)
            self._gather(self.sensors[name])

    def close(self, until: float, names: tuple[str, ...] = ()) -> None:
        """Wait for nothing of up to a time any more [s], of some sensors or of all."""
        for name in names or self.sensors:
            cut = self.sensors.get(name)
            if cut is not None and cut.told > EARLY:
                cut.until = max(cut.until, until)
                self._gather(cut)

    def ready(self) -> Iterator[Scan]:
        """Yield, and take out, the scans before which none can come any more, in order."""
        heard = [cut for cut in self.sensors.values() if cut.told > EARLY]
        bounds = [(*cut.bound(), cut.place) for cut in heard]
        while self.waiting:
            time, place, _, scan = self.waiting[0]
            if any(_holds(bound, time, place) for bound in bounds):
                return
            heapq.heappop(self.waiting)
            yield scan

    def rest(self) -> Iterator[Scan]:
        """Yield, and take out, everything there is, as at the end of a recording."""
        self.close(np.inf)
        for cut in self.sensors.values():
            cut.until = cut.told
        while self.waiting:
            yield heapq.heappop(self.waiting)[-1]

    def jumped(self, time: float) -> None:
        """Begin anew at a time [s]."""
        self.waiting.clear()
        for cut in self.sensors.values():
            if cut.told > EARLY:
                cut.jumped(time)

    def follow(self, before: "Cutter", unchanged: Collection[str]) -> None:
        """Go on with what another has taken in and not handed on, some sensors as they are."""
        for name in self.sensors.keys() & before.sensors.keys():
            if name in unchanged:
                before.sensors[name].place = self.sensors[name].place
                self.sensors[name] = before.sensors[name]
            else:
                before.close(np.inf, (name,))
        for time, _, _, scan in sorted(before.waiting, key=lambda each: each[:3]):
            if scan.sensor in self.sensors:
                self.serial += 1
                place = self.sensors[scan.sensor].place
                heapq.heappush(self.waiting, (time, place, self.serial, scan))

    def _gather(self, cut: SensorCut) -> None:
        for scan in cut.complete():
            self.serial += 1
            heapq.heappush(self.waiting, (scan.time, cut.place, self.serial, scan))


def _holds(bound: tuple[float, bool, int], time: float, place: int) -> bool:
    """Tell whether a sensor may still send a scan that goes before one of a time."""
    first, may_equal, other = bound
    return first < time or (first == time and may_equal and other < place)
