"""Whether a sensor looks, or only hears what objects tell of themselves."""

import itertools
import math
from dataclasses import dataclass

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.estimation.frames import scan_period
from trackweave.estimation.trees import tree_of

__all__ = [
    "Looking",
    "are_even_steps",
    "is_filled_evenly",
    "line_up",
    "looking",
    "shun_successive",
]

# A thread of so many reports has a rhythm.
LASTING = 6
# Objects that are reported at one instant in so many at most: of others that report at nearly
# each, it makes no difference. They are said to come back soon within this share of their pause.
SELDOM, SOON = 3.0, 1 / 3
# By chance a thread would come back soon so often at least, or it tells nothing; it is one of an
# object that reports by itself where it comes back soon less often than this share of that.
LEAST_EXPECTED, REFRAINS = 3.0, 0.3
# What threads must tell together. Those of one object that were torn in two return by chance, but
# by chance hardly any thread keeps a pause: a small share that does decides.
ENOUGH, DECIDES = 8.0, 0.1
# Two objects and more are never seen together by one that looks where each is there at so many of
# the instants at most, nearly all of which hold one report, and most reports are of such objects.
ALONE, BY_TURNS, OF_ALL = 0.95, 0.6, 0.5
# What is in all of two looks in three and more is in some of those in succession.
MOST_IN_LOOKS = 1.5
# So many instants hold one report where objects report by themselves, however they come back, if
# each is there at fewer of the instants than that.
SINGLE, SELDOM_SEEN = 0.9, 0.45
# The numbers of reports of instants vary by such a share of what chance makes them at most where
# the same objects are in all; and so many times as many instants as hold some are none.
EVEN, MOST_EMPTY = 0.3, 2.0
# Steps are alike of which the middle half differs by less than such a share of the usual one, and
# that is so much of the extent of all at most.
ALIKE, WITHIN = 0.5, 0.6
# So many instants are looked at for reports that line up, of so many reports each at most; chance
# gives so few of them one before and one after as exactly about them.
MOST_INSTANTS, MOST_AT_ONCE, BY_CHANCE = 80, 60, 0.25


@dataclass(frozen=True, slots=True)
class Looking:
    """How a sensor's reports of one object follow one another."""

    # How many early returns chance would give the objects that hardly make any.
    by_themselves: float
    by_chance: float  # How many it would give to the others that are seldom reported
    share: float  # At which share of the instants of its life an object is reported, as a median
    n_objects: int  # How many objects' rhythm was seen
    # Whether hardly any instant holds two reports, and no period puts one after the other: where
    # many objects are seen seldom, some looks would find several.
    is_single: bool = False
    take_turns: bool = False  # Whether two objects and more are never reported together

    @property
    def doubt(self) -> float:
        """The share of what speaks otherwise than ``scans`` says, 0 to 1; 1 for not known."""
        both = self.by_themselves + self.by_chance
        if both < ENOUGH:
            return 0.0 if self.scans or self.take_turns else 1.0
        return (self.by_chance if self.scans is False else self.by_themselves) / both

    @property
    def scans(self) -> bool | None:
        """Whether the sensor looks; None where nothing tells."""
        if self.by_themselves >= max(ENOUGH, DECIDES * self.by_chance):
            return False
        if self.take_turns:
            return False
        if self.by_chance >= ENOUGH or (self.share > 0.5 and self.n_objects > 1):
            return not (self.is_single and self.share < SELDOM_SEEN)
        return None


def looking(time: FloatArray, threads: list[IntArray]) -> Looking:
    """Return what threads tell of whether their sensor looks."""
    # A sensor that looks reports an object at each instant with some probability, however small,
    # whenever it last did: returns are memoryless, and where objects hide for a while they come in
    # bursts. An object that reports by itself keeps a pause of its own between two reports: the
    # instants that others fill meanwhile never hold one of it. So early returns are counted,
    # within a third of an object's mean pause, and compared to those of a memoryless object, of
    # which q = 1 − (1 − 1/m)^k return within k instants if m is the mean. Whether others share an
    # instant does not matter: clocks that count whole seconds make them share it.
    instants = np.unique(time)
    by_themselves = by_chance = 0.0
    shares = []
    for rows in threads:
        if rows.size < LASTING:
            continue
        pauses = np.diff(np.searchsorted(instants, time[rows]))
        mean = float(pauses.mean())
        shares.append(1.0 / max(mean, 1.0))
        if mean < SELDOM:
            continue
        soon = int(mean * SOON)
        expected = pauses.size * (1.0 - (1.0 - 1.0 / mean) ** soon)
        if expected < LEAST_EXPECTED:
            continue
        if np.count_nonzero(pauses <= soon) < REFRAINS * expected:
            by_themselves += expected
        else:
            by_chance += expected
    share = float(np.median(shares)) if shares else 0.0
    singles = np.mean(np.unique(time, return_counts=True)[1] == 1)
    is_single = bool(singles >= SINGLE) and scan_period(instants) is None
    # Chance alone threads a few reports of many.
    lasting = sum(rows.size for rows in threads if rows.size >= LASTING)
    take_turns = len(shares) > 1 and share <= BY_TURNS and lasting > OF_ALL * time.size
    take_turns &= bool(singles >= ALONE)
    return Looking(by_themselves, by_chance, share, len(shares), is_single, take_turns)


def is_filled_evenly(time: FloatArray) -> bool:
    """Tell whether instants of one period hold as many reports each as looks at the same objects.

    Objects that report by themselves come as they like, so that instants hold none, one or many,
    if they have no slots of their own.

    Parameters
    ----------
    time
        Of each report [s], ascending.

    Returns
    -------
    Whether their numbers differ by much less than chance would make them.
    """
    instants = np.unique(time)
    period = scan_period(instants)
    if period is None or instants.size < LASTING:
        return False
    slot = np.round((time - time[0]) / period).astype(np.int64)
    if slot[-1] >= MOST_EMPTY * instants.size:
        return False
    count = np.bincount(slot)
    # From one to the next, so that traffic that swells and ebbs is no chance.
    return bool(np.mean(np.diff(count) ** 2) / 2.0 < EVEN * count.mean())


def are_even_steps(time: FloatArray, position: FloatArray) -> bool:
    """Tell whether each report is about as far from the nearest of the instant before it.

    So are objects that circle, look for look; those that have slots of their own in which they
    report by themselves are anywhere.

    Parameters
    ----------
    time
        Of each report [s], ascending.
    position
        Of each [m], shape (reports, dimensions).

    Returns
    -------
    Whether most steps are alike, and short beside the place that all fill.
    """
    parts = np.split(position, np.flatnonzero(np.diff(time)) + 1)
    if len(parts) < LASTING:
        return False
    pairs = itertools.pairwise(parts)
    steps = np.concatenate([tree_of(before).query(after)[0] for before, after in pairs])
    low, usual, high = np.quantile(steps, [0.25, 0.5, 0.75])
    extent = float(np.linalg.norm(np.ptp(position, axis=0)))
    return bool(high - low < ALIKE * usual and usual < WITHIN * extent)


def line_up(time: FloatArray, position: FloatArray) -> tuple[float, float] | None:
    """Return how reports of three successive instants lie on straight ways more than by chance.

    Of objects that are looked at each is in all three, however far it goes meanwhile; who has
    slots of its own is in one of them.

    Parameters
    ----------
    time
        Of each report [s], ascending.
    position
        Of each [m], shape (reports, dimensions).

    Returns
    -------
    How far they usually go from one instant to the next [m], and the noise [m], where half of the
    reports have another before and one after them so exactly about themselves as chance, reports
    of another time after them, gives hardly any; else None.
    """
    parts = np.split(position, np.flatnonzero(np.diff(time)) + 1)
    if len(parts) < LASTING or max(map(len, parts)) > MOST_AT_ONCE:
        return None
    first = max(0, (len(parts) - MOST_INSTANTS) // 2)
    found: list[FloatArray] = []
    chance: list[FloatArray] = []
    steps: list[FloatArray] = []
    for place in range(first + 1, min(first + MOST_INSTANTS, len(parts)) - 1):
        before, other = parts[place - 1], parts[(place + 1 + len(parts) // 2) % len(parts)]
        for off, after in ((found, parts[place + 1]), (chance, other)):
            middle = (before[:, None] + after[None]).reshape(-1, position.shape[1]) / 2.0
            away, nearest = tree_of(middle).query(parts[place])
            off.append(away)
            if after is not other:
                ends = before[nearest // len(after)], after[nearest % len(after)]
                steps.append(np.linalg.norm(ends[1] - ends[0], axis=1) / 2.0)
    near = np.concatenate(found)
    exact = float(np.median(near))
    if np.mean(np.concatenate(chance) <= exact) >= BY_CHANCE:
        return None
    # Beside the middle of two others a report lies by √1.5 deviations along each axis.
    noise = exact / math.sqrt(1.5 * 2.0 * math.log(2.0))
    return float(np.median(np.concatenate(steps)[near <= exact])), noise


def shun_successive(number: IntArray, threads: list[IntArray]) -> bool:
    """Tell whether objects are hardly ever in successive ones of what seem to be looks.

    Where all report by themselves in the same pause, those that are next to each other in time
    seem to be seen together: each is in every second or third look, and never in two in a row.

    Parameters
    ----------
    number
        Of the look of each report.
    threads
        Reports of each object, ascending.

    Returns
    -------
    Whether chance would make so few.
    """
    expected, seen = 0.0, 0
    for rows in threads:
        steps = np.diff(number[rows])
        if rows.size < LASTING or not steps.mean() > MOST_IN_LOOKS:
            continue
        expected += steps.size / steps.mean()
        seen += int(np.count_nonzero(steps <= 1))
    return expected >= ENOUGH and seen < REFRAINS * expected
