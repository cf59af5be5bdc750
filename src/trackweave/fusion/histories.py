"""What is remembered of the local tracks of all sensors, time by time."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray
from trackweave.errors import InvalidInputError
from trackweave.filters.kalman import predicted, transition
from trackweave.fusion._pairs import Live
from trackweave.fusion._statistic import Rings
from trackweave.fusion.pictures import LocalPicture
from trackweave.fusion.statistic import Statistic

__all__ = ["Histories", "Source"]

FIRST_ROWS = 64
FIRST_SLOTS = 16
UNKNOWN = 10.0
"""A sensor that has reported once only may be this many times slower than the steps."""
SHRUNK = 0.95
"""Most of a covariance that may be taken off as common to all sensors."""


@dataclass(slots=True, eq=False)
class Source:
    """One sensor: its last picture, the rows of its tracks, and how often it reports.

    ``common`` is the part of each track's covariance that process noise put there, which other
    sensors' errors share.
    """

    number: int
    picture: LocalPicture
    row: IntArray
    common: FloatArray
    interval: float = 0.0
    is_fresh: bool = True

    def is_live(self, time: float, patience: float, step: float) -> bool:
        """Tell whether its tracks still count: it is not silent for far longer than usual."""
        usual = self.interval or UNKNOWN * step
        return time - self.picture.time <= patience * max(usual, step)


@dataclass(slots=True, eq=False)
class Histories:
    """Estimates of all local tracks at the last common times, which are called slots.

    A slot is complete when every live sensor has reported in it; until then it holds what is
    known by now. So no estimate counts twice, and sensors may have periods of their own. ``held``
    is the object of each row's track, -1 for none, ``owner`` counts the tracks that had the row.
    """

    statistic: Statistic
    process_noise: float
    patience: float
    names: list[str]
    time: float | None = None
    sources: dict[str, Source] = field(default_factory=dict)
    rings: Rings | None = None
    free: list[int] = field(default_factory=list)
    slot_time: list[float] = field(default_factory=list)
    n_slots: int = 0
    held: IntArray = field(default_factory=lambda: np.full(FIRST_ROWS, -1, dtype=np.int64))
    owner: IntArray = field(default_factory=lambda: np.zeros(FIRST_ROWS, dtype=np.int64))

    def take(self, time: float, pictures: Mapping[str, LocalPicture]) -> Live:
        """Enter what sensors say by a time; return the live tracks in the order of the chain."""
        # What cannot be entered is refused before anything is.
        self._require(time, pictures)
        step = 0.0 if self.time is None else time - self.time
        live = [s for s in self.sources.values() if s.is_live(time, self.patience, step)]
        if not self.n_slots or all(source.is_fresh for source in live):
            self._open_slot()
        self.time = float(time)
        self.slot_time[self._slot] = self.time
        for name in sorted(set(pictures) - set(self.names)):
            self.names.append(name)
        for name in sorted(pictures):
            self._enter(name, pictures[name])
        return self._live(step)

    def tracks(self, live: Live) -> IntArray:
        """Return the sensors' own numbers of live tracks."""
        number = np.empty(self.held.shape[0], dtype=np.int64)
        for source in self.sources.values():
            number[source.row] = source.picture.track
        return number[live.row]

    @property
    def slots(self) -> IntArray:
        """The slots that count, from the oldest to the newest."""
        assert self.rings is not None
        most = self.rings.is_fresh.shape[1]
        count = min(self.n_slots, most)
        return np.asarray((self.n_slots - count + np.arange(count)) % most, dtype=np.int64)

    @property
    def _slot(self) -> int:
        assert self.rings is not None
        return int((self.n_slots - 1) % self.rings.is_fresh.shape[1])

    def _require(self, time: float, pictures: Mapping[str, LocalPicture]) -> None:
        """Refuse what cannot be entered."""
        if self.time is not None and time < self.time:
            raise InvalidInputError(
                f"time: {time:g} s after {self.time:g} s; expected times that do not go back"
            )
        dims = {source.picture.dim for source in self.sources.values()}
        for name, picture in pictures.items():
            if not isinstance(picture, LocalPicture) or picture.sensor != name:
                raise InvalidInputError(
                    f"pictures: {name!r:.80}: {picture!r:.80}; expected that sensor's LocalPicture"
                )
            if picture.time > time:
                raise InvalidInputError(
                    f"sensor {name}: tracks of {picture.time:g} s at {time:g} s; "
                    "expected none from the future"
                )
            before = self.sources.get(name)
            if before is not None and picture.time < before.picture.time:
                raise InvalidInputError(
                    f"sensor {name}: tracks of {picture.time:g} s after those of "
                    f"{before.picture.time:g} s; expected times that do not go back"
                )
            dims.add(picture.dim)
        if len(dims) > 1:
            raise InvalidInputError(
                "pictures: tracks in 2 and in 3 dimensions; expected one number of dimensions"
            )
        if not dims:
            raise InvalidInputError("pictures: none so far; expected one sensor's at least")
        if self.rings is None:
            self._allocate(2 * dims.pop())

    def _allocate(self, n: int) -> None:
        most = self.statistic.n_slots or FIRST_SLOTS
        shape = (FIRST_ROWS, most)
        self.rings = Rings(
            np.zeros((*shape, n)), np.zeros((*shape, n, n)), np.zeros((*shape, n, n)),
            np.zeros(shape, dtype=np.bool_), np.zeros(shape), np.zeros((*shape, n, n)),
        )  # fmt: skip
        self.free = list(range(FIRST_ROWS - 1, -1, -1))
        self.slot_time = [0.0] * most

    def _open_slot(self) -> None:
        """Begin a new slot, in place of the oldest unless all are remembered."""
        if self.rings is None:
            return
        most = self.rings.is_fresh.shape[1]
        if self.statistic.n_slots is None and self.n_slots == most:
            self.rings = _padded(self.rings, 1)
            self.slot_time += [0.0] * most
        self.n_slots += 1
        self.rings.is_fresh[:, self._slot] = False
        for source in self.sources.values():
            source.is_fresh = False

    def _enter(self, name: str, picture: LocalPicture) -> None:
        """Enter one sensor's news: begin rows of new tracks, free those of ended ones."""
        old = self.sources.get(name)
        if old is not None and picture.time == old.picture.time:
            # Said before: counts once.
            return
        number = self.names.index(name)
        row = np.full(len(picture), -1, dtype=np.int64)
        common = np.zeros_like(picture.covariance)
        interval = 0.0
        if old is not None:
            interval = picture.time - old.picture.time
            _, new, before = np.intersect1d(
                picture.track, old.picture.track, assume_unique=True, return_indices=True
            )
            row[new] = old.row[before]
            if self.statistic.takes_off_common:
                common[new] = self._common(picture, new, old, before)
            self._release(np.delete(old.row, before))
        row[row < 0] = self._rows(int(np.count_nonzero(row < 0)))
        self.sources[name] = Source(number, picture, row, common, interval)

    def _release(self, rows: IntArray) -> None:
        assert self.rings is not None
        self.rings.is_fresh[rows] = False
        self.held[rows] = -1
        self.owner[rows] += 1
        self.free.extend(rows.tolist()[::-1])

    def _rows(self, count: int) -> list[int]:
        """Return free rows, and make more where there are too few."""
        assert self.rings is not None
        while len(self.free) < count:
            n_rows = self.rings.is_fresh.shape[0]
            self.rings = _padded(self.rings, 0)
            self.held = np.concatenate([self.held, np.full(n_rows, -1, dtype=np.int64)])
            self.owner = np.concatenate([self.owner, np.zeros(n_rows, dtype=np.int64)])
            self.free[:0] = range(2 * n_rows - 1, n_rows - 1, -1)
        return [self.free.pop() for _ in range(count)]

    def _live(self, step: float) -> Live:
        """Write what is known now into the open slot, and return the live tracks."""
        assert self.time is not None
        parts: list[tuple[IntArray, IntArray, FloatArray, FloatArray]] = []
        for name in self.names:
            source = self.sources.get(name)
            if source is None or not source.is_live(self.time, self.patience, step):
                continue
            mean, spread, whole = self._now(source)
            if source.is_fresh and len(source.row):
                self._write(source.row, mean, spread, whole)
            number = np.full(len(source.row), source.number, dtype=np.int64)
            parts.append((source.row, number, mean, spread))
        if not parts:
            none = np.empty(0, dtype=np.int64)
            return Live(none, none, none, np.empty((0, 4)), np.empty((0, 4, 4)))
        row, number, mean, spread = (np.concatenate(part) for part in zip(*parts, strict=True))
        return Live(row, number, self.held[row], mean, spread)

    def _now(self, source: Source) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return a sensor's tracks now, the covariances that the test reckons with, and all."""
        assert self.time is not None
        picture = source.picture
        mean, whole = picture.mean, picture.covariance
        apart = whole - source.common if self.statistic.takes_off_common else whole
        if picture.time < self.time:
            interval = np.full(len(picture), self.time - picture.time)
            if self.statistic.takes_off_common:
                # New noise is common, too, so it stays off.
                _, apart = predicted(mean, apart, interval, 0.0)
            mean, whole = predicted(mean, whole, interval, self.process_noise)
            if not self.statistic.takes_off_common:
                apart = whole
        return mean, self.statistic.scale * apart, whole

    def _write(
        self, row: IntArray, mean: FloatArray, spread: FloatArray, whole: FloatArray
    ) -> None:
        assert self.rings is not None
        slot = self._slot
        if self.statistic.correlation in {"effective", "both"} and self.n_slots > 1:
            before = (self.n_slots - 2) % self.rings.is_fresh.shape[1]
            gap = self.slot_time[slot] - self.slot_time[before]
            likeness = _likeness(
                (self.rings.spread[row, before], spread),
                (self.rings.whole[row, before], whole),
                gap,
                self.process_noise,
            )
            self.rings.likeness[row, slot] = np.where(
                self.rings.is_fresh[row, before], likeness, 0.0
            )
        self.rings.mean[row, slot] = mean
        self.rings.spread[row, slot] = spread
        self.rings.information[row, slot] = np.linalg.inv(spread)
        self.rings.whole[row, slot] = whole
        self.rings.is_fresh[row, slot] = True

    def _common(
        self, picture: LocalPicture, new: NDArray[np.intp], old: Source, before: NDArray[np.intp]
    ) -> FloatArray:
        """Return the part of covariances that process noise put there, one update later."""
        # An update leaves the share P⁺ (P⁻)⁻¹ = I − K H of the predicted error.
        gap = np.full(new.shape[0], picture.time - old.picture.time)
        moving, noise = transition(gap, self.process_noise, picture.dim)
        turned = moving.swapaxes(1, 2)
        ahead = moving @ old.picture.covariance[before] @ turned + noise
        left = picture.covariance[new] @ np.linalg.inv(ahead)
        common = left @ (moving @ old.common[before] @ turned + noise) @ left.swapaxes(1, 2)
        common = (common + common.swapaxes(1, 2)) / 2.0
        # Rounding, or a filter of another kind, must not leave a covariance indefinite.
        whole = picture.covariance[new]
        root = np.linalg.inv(np.linalg.cholesky(whole))
        most = np.linalg.eigvalsh(root @ common @ root.swapaxes(1, 2))[:, -1]
        shrink = np.minimum(1.0, SHRUNK / np.maximum(most, 1e-12))
        return np.asarray(shrink[:, None, None] * common)


def _likeness(
    spread: tuple[FloatArray, FloatArray],
    whole: tuple[FloatArray, FloatArray],
    gap: float,
    noise: float,
) -> FloatArray:
    """Return the mean squared correlation of errors now with those a gap [s] before."""
    # Both pairs are of then and now: what the test reckons with, and the whole, which tells gains.
    n = spread[0].shape[1]
    moving, q = transition(np.array([gap]), noise, n // 2)
    size = np.trace(whole[1], axis1=1, axis2=2)[:, None, None]
    # Rows that were not there before hold zeros; they are not used.
    ahead = moving[0] @ whole[0] @ moving[0].T + q[0] + 1e-12 * size * np.eye(n)
    carried = whole[1] @ np.linalg.inv(ahead) @ moving[0]
    left = carried @ spread[0] @ carried.swapaxes(1, 2)
    share = np.einsum("kij,kji->k", np.linalg.inv(spread[1]), left) / n
    return np.asarray(np.clip(share, 0.0, 1.0))


def _padded(rings: Rings, axis: int) -> Rings:
    """Return the rings with as many zeros again along an axis."""
    return Rings._make(np.concatenate([each, np.zeros_like(each)], axis=axis) for each in rings)
