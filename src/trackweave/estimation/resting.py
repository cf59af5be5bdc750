"""Who lies where: objects at rest that report themselves, once all their reports are there.

Moored side by side, nearer than their noise is wide, ships are told apart by the times at which
they report as much as by where: each keeps an interval of its own for hours. A window of seconds
cannot know that. The reports of a place are chains: each chain's place and noise are integrated
out (normal, inverse gamma), its rhythm is the likeliest. Chains are parted and joined two by two,
each time by the likeliest way of all ways to give their reports to two objects, while that makes
the whole likelier.
"""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.estimation._resting import SIZE, Objects, absence, fit_rhythm, part_two, weigh
from trackweave.estimation.resting_places import densest

__all__ = ["Berth", "Chain", "chain_of", "parted", "sureness"]

KNOWN, OF_USUAL = 4.0, 0.6
"""An object's variance is of an inverse gamma distribution: its shape, and its scale over that as
a part of the usual variance."""
NEW = 2.0  # What one more object costs beside where, when and how often it is [nats]
BESIDE, CLOSE = 6.0, 3.0
"""Objects are tried with each other that lie within so many deviations, from several beginnings
within so many."""
FEWEST, OF_TWO = 3, 6  # Reports of an object that is taken out of a crowd; of two
CROWD = 20  # So many are looked through for several at once
ROUNDS, STEPS = 8, 4
SPLIT = 0.5  # A step that adds an object gains so much [nats]
MOST_INTERVALS, STEP, APART, SHORTEST = 2, 0.03, 0.08, 8.0
"""So many intervals are tried, of lags counted in such steps of the logarithm, so far apart, and
of so many times the grain of times at least."""
MOST_REPORTS = 300  # Chains of more are made in stretches


class Berth(NamedTuple):
    """What is known of a place beforehand."""

    variance: float  # Of the usual noise along an axis [m²]
    extent: float  # How much room there is: an area, or a volume [m² or m³]
    begin: float  # When hearing began and ended [s]
    end: float
    grain: float  # How exact times are [s]

    @property
    def span(self) -> tuple[float, float, float]:
        """What kernels take."""
        return self.begin, self.end, self.grain

    @property
    def length(self) -> float:
        """How long it was heard [s]; stretches of one stamp have a length too."""
        return max(self.end - self.begin, self.grain)


class Chain(NamedTuple):
    """The reports of one object."""

    likelihood: float  # Of all its reports [log]
    mean: FloatArray  # Where it lies
    variance: float  # Of its noise [m²]
    rhythm: FloatArray


def chain_of(time: FloatArray, place: FloatArray, berth: Berth) -> Chain:
    """Return what some reports tell if they are of one object.

    Parameters
    ----------
    time, place
        Of these reports, as for `parted`.
    berth
        What is known of the place.

    Returns
    -------
    How probable they are, where the object lies, its noise and its rhythm.
    """
    (n, dim), rhythm = place.shape, np.empty(SIZE)
    mean = place.mean(axis=0)
    scale, free = KNOWN * OF_USUAL * berth.variance, dim * (n - 1) / 2
    scatter = scale + float(((place - mean) ** 2).sum()) / 2
    # Where it lies is as likely anywhere; the variance is integrated out. Murphy, Conjugate
    # Bayesian analysis of the Gaussian distribution (2007), section 3.
    where = (
        KNOWN * math.log(scale) - (KNOWN + free) * math.log(scatter)
        + math.lgamma(KNOWN + free) - math.lgamma(KNOWN)
        - free * math.log(2.0 * math.pi) - dim / 2 * math.log(n) - math.log(berth.extent)
    )  # fmt: skip
    when = fit_rhythm(np.diff(time), berth.grain, rhythm) - math.log(berth.length)
    ends = absence(time[0] - berth.begin, rhythm) + absence(berth.end - time[-1], rhythm)
    return Chain(where + when + ends - NEW, mean, scatter / (KNOWN + free), rhythm)


def parted(
    time: FloatArray, place: FloatArray, owner: IntArray, berth: Berth
) -> tuple[IntArray, float]:
    """Return which object each report of a place is of, and how much likelier that is.

    Parameters
    ----------
    time
        When, ascending [s], shape (reports,).
    place
        Where [m], shape (reports, dimensions).
    owner
        Whose they were thought to be, from which the search sets out.
    berth
        What is known of the place.

    Returns
    -------
    The number of an object for each report, from 0, and by how much that is likelier than the
    owners before, over all stretches [nats].
    """
    n_stretches = -(-time.size // MOST_REPORTS)
    parts = np.array_split(np.arange(time.size), n_stretches)
    edges = [berth.begin, *(float(time[part[0]]) for part in parts[1:]), berth.end]
    number, count, gain = np.empty(time.size, dtype=np.int64), 0, 0.0
    last: list[tuple[int, IntArray]] = []
    for index, part in enumerate(parts):
        own = berth._replace(begin=edges[index], end=edges[index + 1])
        chains = _Chains(time[part], place[part], own, owner[part])
        before = chains.likelihood(chains.chains)
        chains.search()
        gain += chains.likelihood(chains.chains) - before
        found = [part[rows] for rows in chains.chains]
        until = berth._replace(end=edges[index + 1])
        names = _followed((time, place), last, found, until)
        # Who was silent for a whole stretch may be heard again.
        last = [(name, rows) for name, rows in last if name not in names]
        for name, rows in zip(names, found, strict=True):
            if name < 0:
                name, count = count, count + 1
            number[rows] = name
            last.append((name, rows))
    return number, gain


def sureness(time: FloatArray, place: FloatArray, owner: IntArray, berth: Berth) -> FloatArray:
    """Return how probable each report is of its owner, were all others as they are.

    Parameters
    ----------
    time, place
        Of all reports of a place, as for `parted`.
    owner
        The number of the object of each, from 0.
    berth
        What is known of the place.

    Returns
    -------
    Probabilities, shape (reports,).
    """
    chains = _Chains(time, place, berth, owner)
    probability = np.empty(time.size)
    weigh((time, place), owner, _objects(map(chains.of, chains.chains)), berth.span, probability)
    return probability


def _followed(
    reports: tuple[FloatArray, FloatArray],
    last: list[tuple[int, IntArray]],
    found: list[IntArray],
    berth: Berth,
) -> list[int]:
    """Return which object of the stretches before each chain goes on, -1 for none."""
    names = [-1] * len(found)
    if not last:
        return names
    from scipy.optimize import linear_sum_assignment

    chains = _Chains(*reports, berth, np.empty(0, dtype=np.int64))
    alone = [
        [chains.of(rows).likelihood for rows in each] for each in ([r for _, r in last], found)
    ]
    gain = np.array([
        [chains.of(np.r_[one, other]).likelihood - before - after
         for other, after in zip(found, alone[1], strict=True)]
        for (_, one), before in zip(last, alone[0], strict=True)
    ])  # fmt: skip
    for one, other in zip(*linear_sum_assignment(-np.maximum(gain, 0.0)), strict=True):
        if gain[one, other] > 0.0:
            names[other] = last[one][0]
    return names


def _objects(chains: Iterator[Chain]) -> Objects:
    """Return chains as kernels take them."""
    _, mean, variance, rhythm = zip(*chains, strict=True)
    return np.stack(mean), np.array(variance), np.stack(rhythm)


class _Chains:
    """The reports of a place, each in one chain."""

    def __init__(self, time: FloatArray, place: FloatArray, berth: Berth, owner: IntArray) -> None:
        self.time, self.place, self.berth = time, place, berth
        self.chains = [np.flatnonzero(owner == each) for each in np.unique(owner)]
        self._known: dict[bytes, Chain] = {}
        self._tried: set[tuple[bytes, ...]] = set()

    def of(self, rows: IntArray) -> Chain:
        """Return what some reports tell if they are of one object."""
        key = rows.tobytes()
        if key not in self._known:
            self._known[key] = chain_of(self.time[rows], self.place[rows], self.berth)
        return self._known[key]

    def likelihood(self, chains: list[IntArray]) -> float:
        """Return how probable the reports of some chains are."""
        return sum(self.of(rows).likelihood for rows in chains)

    def search(self, *, of_crowds: bool = True) -> None:
        """Part and join chains while that is likelier."""
        for _ in range(ROUNDS):
            changed = self._parted_each() | self._parted_pairs()
            if not (changed or (of_crowds and self._parted_crowds())):
                return

    def _is_new(self, *sets: IntArray) -> bool:
        """Tell whether some chains have not been tried yet, once."""
        key = tuple(each.tobytes() for each in sets)
        is_new = key not in self._tried
        self._tried.add(key)
        return is_new

    def _replace(self, old: list[IntArray], new: list[IntArray]) -> None:
        gone = set(map(id, old))
        self.chains = [each for each in self.chains if id(each) not in gone] + new

    def _parted_each(self) -> bool:
        """Part each chain in two where that is likelier; tell whether it is anywhere."""
        changed = False
        for rows in list(self.chains):
            if rows.size >= OF_TWO and self._is_new(rows):
                value, parts = self._best_two(rows, [rows])
                if value > self.of(rows).likelihood + SPLIT:
                    self._replace([rows], parts)
                    changed = True
        return changed

    def _parted_pairs(self) -> bool:
        """Give the reports of chains beside each other to one or two anew."""
        changed = False
        queue = [(a, b) for index, a in enumerate(self.chains) for b in self.chains[:index]]
        while queue:
            one, other = queue.pop(0)
            if not (self._are_within(BESIDE, one, other) and self._is_new(one, other)):
                continue
            rows = np.union1d(one, other)
            value, parts = self._best_two(rows, [one, other])
            if self.of(rows).likelihood > value:
                value, parts = self.of(rows).likelihood, [rows]
            if value > self.likelihood([one, other]) + 1e-6:
                self._replace([one, other], parts)
                gone = {id(one), id(other)}
                queue = [pair for pair in queue if gone.isdisjoint(map(id, pair))]
                queue += [(a, b) for a in parts for b in self.chains if b is not a]
                changed = True
        return changed

    def _are_within(self, far: float, one: IntArray, other: IntArray) -> bool:
        off = self.of(one).mean - self.of(other).mean
        return float(off @ off) < far**2 * self.berth.variance

    def _parted_crowds(self) -> bool:
        """Part a chain in several at once where no parting in two is likelier."""
        for rows in list(self.chains):
            if rows.size >= CROWD and self._is_new(rows, rows):
                inner = _Chains(self.time[rows], self.place[rows], self.berth, self._pursued(rows))
                inner.search(of_crowds=False)
                found = [rows[each] for each in inner.chains]
                if self.likelihood(found) > self.of(rows).likelihood + SPLIT:
                    self._replace([rows], found)
                    return True
        return False

    def _best_two(self, rows: IntArray, groups: list[IntArray]) -> tuple[float, list[IntArray]]:
        """Return the likeliest two chains of some reports that any beginning leads to."""
        best, parts = -math.inf, groups
        for start in self._starts(rows, groups):
            value, found = self._settled(rows, start)
            if value > best:
                best, parts = value, found
        return best, parts

    def _settled(self, rows: IntArray, objects: Objects) -> tuple[float, list[IntArray]]:
        """Return the two chains that two objects' guesses lead to, by turns, and how likely."""
        best, parts, last = -math.inf, [rows], b""
        owner = np.empty(rows.size, dtype=np.int64)
        for _ in range(STEPS):
            part_two((self.time[rows], self.place[rows]), objects, self.berth.span, owner)
            if owner.tobytes() == last:
                break
            last = owner.tobytes()
            found = [each for each in (rows[owner == 0], rows[owner == 1]) if each.size]
            value = self.likelihood(found)
            if value > best:
                best, parts = value, found
            if len(found) < 2:
                break
            objects = _objects(map(self.of, found))
        return best, parts

    def _starts(self, rows: IntArray, groups: list[IntArray]) -> Iterator[Objects]:
        """Yield guesses of two objects: as they are, by where reports lie, and by when."""
        if len(groups) == 2:
            yield _objects(map(self.of, groups))
            if not self._are_within(CLOSE, *groups):
                return
        place = self.place[rows]
        middle = place.mean(axis=0)
        off = place - middle
        means = [np.stack([middle, middle])]
        for along in np.linalg.svd(off, full_matrices=False)[2] @ off.T:
            is_beyond = along > np.median(along)
            if is_beyond.any():
                means.append(np.stack([place[~is_beyond].mean(0), place[is_beyond].mean(0)]))
        variance = np.full(2, OF_USUAL * self.berth.variance)
        *paced, free = self._rhythms(rows)
        pairs = [(a, b) for index, a in enumerate(paced) for b in paced[index:]] + [(free, free)]
        for mean in means:
            for pair in pairs:
                yield mean, variance, np.stack(pair)

    def _rhythms(self, rows: IntArray) -> list[FloatArray]:
        """Return the rhythms that lags between reports near each other tell of, none the last."""
        berth = self.berth
        free = np.array([0.0, 0.02, 0.5, rows.size / (2.0 * berth.length)])
        few = rows[:: -(-rows.size // MOST_REPORTS)]
        one, other = np.triu_indices(few.size, 1)
        lag = self.time[few][other] - self.time[few][one]
        off = self.place[few][other] - self.place[few][one]
        is_near = (off**2).sum(axis=1) < 9.0 * berth.variance
        lags = np.log(lag[is_near & (lag > SHORTEST * berth.grain)])
        if lags.size < FEWEST:
            return [free]
        n_steps = max(int(np.ptp(lags) / STEP), 1)
        number, edges = np.histogram(lags, n_steps, (lags.min(), lags.max() + 1e-9))
        interval = np.exp((edges[1:] + edges[:-1]) / 2)
        # Of reports at any times lags are as many in each second.
        usual = np.maximum(np.median(number / interval) * interval, 0.5)
        found: list[float] = []
        for each in interval[np.argsort(-(number - usual) / np.sqrt(usual), kind="stable")]:
            if all(abs(math.log(each / known)) > APART for known in found):
                found.append(float(each))
            if len(found) == MOST_INTERVALS:
                break
        return [*(np.array([each, 0.02, 0.2, 0.0]) for each in found), free]

    def _pursued(self, rows: IntArray) -> IntArray:
        """Return an owner for each report of a crowd, one object after another taken out."""
        owner = np.full(rows.size, -1, dtype=np.int64)
        for number in range(rows.size):
            left = np.flatnonzero(owner < 0)
            own = self._likeliest_of(rows[left]) if left.size > FEWEST else np.arange(left.size)
            owner[left[own]] = number
            if own.size == left.size:
                break
        return owner

    def _likeliest_of(self, rows: IntArray) -> IntArray:
        """Return which reports of a crowd are of the one object that is the clearest."""
        place, berth = self.place[rows], self.berth
        middle, dim = place.mean(axis=0), place.shape[1]
        wide = float(((place - middle) ** 2).mean()) + berth.variance
        rate = rows.size / berth.length
        as_any = -0.5 * dim * (math.log(2.0 * math.pi * wide) + 1.0) + math.log(rate)
        any_rhythm = np.array([0.0, 0.02, 0.5, rate])
        most, best = 0.0, np.arange(rows.size)
        owner = np.empty(rows.size, dtype=np.int64)
        for rhythm in self._rhythms(rows)[:-1]:
            for seed in densest(place, berth.variance):
                mean = np.stack([seed, middle])
                variance = np.array([OF_USUAL * berth.variance, wide])
                rhythms = np.stack([rhythm, any_rhythm])
                for _ in range(STEPS - 1):
                    objects = mean, variance, rhythms
                    part_two((self.time[rows], place), objects, berth.span, owner)
                    own = np.flatnonzero(owner == 0)
                    if own.size < FEWEST:
                        break
                    chain = self.of(rows[own])
                    mean[0], variance[0], rhythms[0] = chain[1:]
                if own.size >= FEWEST and chain.likelihood - own.size * as_any > most:
                    most, best = chain.likelihood - own.size * as_any, own
        return best
