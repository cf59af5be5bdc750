"""System tracks out of the tracks of many sensors, one update at a time."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from trackweave.arrays import FloatArray, IntArray, require_instance
from trackweave.domain.tracks import COASTING, CONFIRMED, TrackTable
from trackweave.errors import InvalidInputError
from trackweave.fields import settle
from trackweave.filters.kalman import predicted
from trackweave.fusion.associator import Association, TrackAssociator
from trackweave.fusion.combine import Combination, SharedPrior
from trackweave.fusion.pictures import LocalPicture
from trackweave.fusion.registration import Registration
from trackweave.randomness import RandomSource
from trackweave.summaries import summary

__all__ = ["FusedPicture", "TrackFuser"]

VAGUE = 1e8
"""How many times wider than the estimate a prior is that knows nothing."""


@dataclass(frozen=True, slots=True, eq=False)
class FusedPicture:
    """What all sensors together say at one time.

    Parameters
    ----------
    time
        That time [s].
    tracks
        One row per object, by its lasting number. Its status is confirmed where a sensor has news
        of it, else coasting; ``score`` is half of what its statistic exceeds the threshold by
        [nats], 0 for an object that one sensor sees; ``hits`` counts the local estimates that it
        has taken; ``last_update`` is the time of the last of them.
    association
        Which local track is of which object, and why that changed.

    Examples
    --------
    >>> import numpy as np
    >>> import trackweave as tw
    >>> state = [[100.0, 50.0, 10.0, 0.0]]  # x, y [m], vx, vy [m/s]
    >>> spread = np.diag([25.0, 25.0, 1.0, 1.0])[None]
    >>> pictures = {n: tw.LocalPicture(n, 0.0, [1], state, spread) for n in ("A", "B")}
    >>> picture = tw.TrackFuser().step(0.0, pictures, rng=np.random.default_rng(1))
    >>> picture.time, picture.tracks.mean.tolist()  # s; m, m/s
    (0.0, [[100.0, 50.0, 10.0, 0.0]])
    """

    time: float
    tracks: TrackTable
    association: Association

    __repr__ = summary


@dataclass(slots=True, eq=False)
class _Known:
    """What is remembered of objects and tracks from one update to the next."""

    hits: dict[int, int] = field(default_factory=dict)
    fused: dict[int, tuple[FloatArray, FloatArray]] = field(default_factory=dict)
    fused_time: float = 0.0
    # What each local track said when it was last combined, and when that was.
    told: dict[tuple[str, int], tuple[float, FloatArray, FloatArray]] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, eq=False)
class _Rows:
    """Live local tracks, all of an object one after the other, at the time of the update.

    ``said`` is when their sensors last spoke, ``start`` where each object's rows begin, and the
    number of rows last.
    """

    object: IntArray
    sensor: IntArray
    track: IntArray
    mean: FloatArray
    covariance: FloatArray
    said: FloatArray
    is_new: np.ndarray
    start: IntArray


@dataclass(slots=True, eq=False)
class TrackFuser:
    """Makes system tracks: associates local tracks, registers sensors, combines estimates.

    Parameters
    ----------
    associator
        What decides which tracks are of one object; it must not have been used.
    combination
        How local estimates become one. By default covariance intersection in closed form, which is
        consistent whatever the sensors' errors share, as trackers of one object share its turns,
        and takes something from each of them, where the best weights often take one alone.
    registrations
        What is wrong with sensors, by name; their pictures are put right before anything else.

    Raises
    ------
    InvalidInputError
        If an argument is of another kind, or a registration is another sensor's.

    Notes
    -----
    "information-matrix" takes off each estimate what the same track had told before, predicted to
    now, so that only what was learned since counts.

    Examples
    --------
    >>> import numpy as np
    >>> import trackweave as tw
    >>> state = [[100.0, 50.0, 10.0, 0.0]]  # x, y [m], vx, vy [m/s]
    >>> spread = np.diag([25.0, 25.0, 1.0, 1.0])[None]
    >>> pictures = {n: tw.LocalPicture(n, 0.0, [1], state, spread) for n in ("A", "B")}
    >>> picture = tw.TrackFuser().step(0.0, pictures, rng=np.random.default_rng(1))
    >>> len(picture.tracks)  # one object, seen by both
    1
    """

    associator: TrackAssociator = field(default_factory=TrackAssociator)
    combination: Combination | str = "fast-covariance-intersection"
    registrations: Mapping[str, Registration] = field(default_factory=dict)
    _how: Combination = field(init=False, repr=False)
    _pictures: dict[str, LocalPicture] = field(init=False, repr=False, default_factory=dict)
    _known: _Known = field(init=False, repr=False, default_factory=_Known)

    def __post_init__(self) -> None:
        settle(self)
        how = self.combination
        self._how = Combination(how) if isinstance(how, str) else how
        for name, registration in self.registrations.items():
            if registration.sensor != name:
                raise InvalidInputError(
                    f"registrations, {name}: of sensor {registration.sensor}; expected that of "
                    f"{name}"
                )

    def step(
        self, time: float, pictures: Mapping[str, LocalPicture], *, rng: RandomSource = 0
    ) -> FusedPicture:
        """Take what sensors say by a time, and return the objects.

        Parameters
        ----------
        time
            That time [s], not before the last one. All tracks are brought to it by prediction.
        pictures
            For each sensor that has news its tracks, all of them. A sensor that is left out has
            none; one that is silent for long is not reckoned with until it returns.
        rng
            Source of randomness: a generator, or a seed, which draws alike at each step.

        Returns
        -------
        The objects, and which local tracks are theirs.

        Raises
        ------
        InvalidInputError
            If times go back, or a picture does not fit; nothing has changed then.
        """
        require_instance(pictures, Mapping, "pictures")
        right = {name: self._registered(name, picture) for name, picture in pictures.items()}
        association = self.associator.step(time, right, rng=rng)
        news = {
            name
            for name, picture in right.items()
            if name not in self._pictures or picture.time > self._pictures[name].time
        }
        self._pictures.update({name: right[name] for name in news})
        rows = self._rows(association, news)
        if not len(association):
            dim = next((picture.dim for picture in self._pictures.values()), 2)
            return FusedPicture(float(time), TrackTable.empty(dim), association)
        mean, covariance = self._combined(rows, association)
        tracks = self._table(rows, association, mean, covariance)
        return FusedPicture(float(time), tracks, association)

    def _registered(self, name: str, picture: LocalPicture) -> LocalPicture:
        if name not in self.registrations or not isinstance(picture, LocalPicture):
            return picture
        return self.registrations[name].apply(picture)

    def _rows(self, association: Association, news: set[str]) -> _Rows:
        """Return the live local tracks at the association's time, object by object."""
        n = next((2 * picture.dim for picture in self._pictures.values()), 4)
        mean = np.empty((len(association), n))
        covariance = np.empty((len(association), n, n))
        said = np.empty(len(association))
        for number, name in enumerate(association.names):
            mine = np.flatnonzero(association.sensor == number)
            if not mine.size:
                continue
            picture = self._pictures[name].predicted(
                association.time, self.associator.process_noise
            )
            order = np.argsort(picture.track)
            place = order[np.searchsorted(picture.track[order], association.track[mine])]
            said[mine] = self._pictures[name].time
            mean[mine], covariance[mine] = picture.mean[place], picture.covariance[place]
        is_new = np.isin(association.sensor, [association.names.index(name) for name in news])
        order = np.lexsort((association.track, association.sensor, association.object))
        label = association.object[order]
        start = np.append(np.flatnonzero(np.diff(label, prepend=-1)), label.shape[0])
        return _Rows(
            label, association.sensor[order], association.track[order], mean[order],
            covariance[order], said[order], is_new[order], start.astype(np.int64),
        )  # fmt: skip

    def _combined(self, rows: _Rows, association: Association) -> tuple[FloatArray, FloatArray]:
        if self._how.method != "information-matrix":
            return self._how(rows.mean, rows.covariance, rows.start)
        prior = self._prior(rows, association)
        mean, covariance = self._how(rows.mean, rows.covariance, rows.start, prior)
        known = self._known
        numbers = rows.object[rows.start[:-1]].tolist()
        known.fused = {
            number: (mean[place], covariance[place]) for place, number in enumerate(numbers)
        }
        known.fused_time = association.time
        known.told = {
            key: (association.time, rows.mean[place], rows.covariance[place])
            for place, key in enumerate(_keys(rows, association))
        }
        return mean, covariance

    def _prior(self, rows: _Rows, association: Association) -> SharedPrior:
        """Return what objects and tracks said at the last update, predicted to this one."""
        known, time = self._known, association.time
        # Who is new knew nothing, and to an object that is new everything is.
        local_mean, local_spread = rows.mean.copy(), VAGUE * rows.covariance
        there = [
            (place, *known.told[key])
            for place, key in enumerate(_keys(rows, association))
            if key in known.told and int(rows.object[place]) in known.fused
        ]
        if there:
            places = np.array([entry[0] for entry in there])
            gap = np.array([time - entry[1] for entry in there])
            local_mean[places], spread = self._ahead(there, gap)
            local_spread[places] = _not_narrower(spread, rows.covariance[places])
        first = rows.start[:-1]
        mean, covariance = rows.mean[first].copy(), VAGUE * rows.covariance[first]
        objects = [
            (place, 0.0, *known.fused[number])
            for place, number in enumerate(rows.object[first].tolist())
            if number in known.fused
        ]
        if objects:
            places = np.array([entry[0] for entry in objects])
            gap = np.full(len(objects), time - known.fused_time)
            mean[places], covariance[places] = self._ahead(objects, gap)
        return SharedPrior(mean, covariance, local_mean, local_spread)

    def _ahead(
        self, told: list[tuple[int, float, FloatArray, FloatArray]], gap: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return estimates predicted over gaps of time."""
        mean = np.stack([entry[2] for entry in told])
        spread = np.stack([entry[3] for entry in told])
        mean, spread = predicted(mean, spread, gap, self.associator.process_noise)
        return mean, (spread + spread.swapaxes(1, 2)) / 2.0

    def _table(
        self, rows: _Rows, association: Association, mean: FloatArray, covariance: FloatArray
    ) -> TrackTable:
        known, first = self._known, rows.start[:-1]
        number = rows.object[first]
        fresh = np.add.reduceat(rows.is_new.astype(np.int64), first)
        for which, count in zip(number.tolist(), fresh.tolist(), strict=True):
            known.hits[which] = known.hits.get(which, 0) + count
        of_object = {
            int(which): (value - limit) / 2.0
            for which, value, limit in zip(
                association.object, association.statistic, association.threshold, strict=True
            )
        }
        return TrackTable(
            time=np.full(number.shape[0], association.time),
            track=number,
            status=np.where(fresh > 0, CONFIRMED, COASTING),
            mean=mean,
            covariance=covariance,
            score=np.array([of_object[which] for which in number.tolist()]),
            hits=np.array([known.hits[which] for which in number.tolist()], dtype=np.int64),
            last_update=np.maximum.reduceat(rows.said, first),
        )


def _keys(rows: _Rows, association: Association) -> list[tuple[str, int]]:
    return [
        (association.names[sensor], track)
        for sensor, track in zip(rows.sensor.tolist(), rows.track.tolist(), strict=True)
    ]


def _not_narrower(before: FloatArray, now: FloatArray) -> FloatArray:
    """Return covariances widened until nothing was known before that is not known now."""
    # A tracker whose estimate averages over hypotheses can grow less certain than a prediction.
    root = np.linalg.inv(np.linalg.cholesky(before))
    most = np.linalg.eigvalsh(root @ now @ root.swapaxes(1, 2))[:, -1]
    return np.asarray(np.maximum(most, 1.0)[:, None, None] * before)
