"""What reports tell of whom they say they are: how often that is wrong, and each one's thread."""

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.reports import ReportTable
from trackweave.estimation.place_spacing import spacing_of_places

__all__ = ["by_identity", "identity_error", "identity_threads", "note_on_identities"]

# A step is absurd that is so many times as long, and as fast, as the steps before and after it.
ABSURD, BESIDE = 6.0, 3
# It is another's where one of so many reports before or after is that much nearer than its leap.
AROUND, NEAR, MOST_ABSURD = 100, 0.1, 400
# A step leads elsewhere that is so many times as long as the way to the nearest report before it,
# and so many times as fast: who is seldom named has gone far. Where so many do, or come alone,
# identities are no names.
ELSEWHERE, QUICKER, NO_NAMES, MOST_ERROR, MOST_STEPS = 10.0, 4.0, 0.3, 0.99, 2000
# Among places that all come back to, such as rooms, a step leads elsewhere that is so many times
# as long as from one to the next.
PLACES = 3.0
# Such a share of reports under another identity is said.
CHANGING = 0.003
# Before the data speak identities are wrong as seldom as this, trusted as so many reports.
USUAL_ERROR, TRUSTED = 1e-4, 500.0
# Threads are those of identities where hardly any is wrong, a fifth of the reports has one,
# and few are wild.
MOST_WRONG, LEAST_NAMED, MOST_WILD = 0.01, 0.2, 0.1
# Fewer identities, or reports of each as a median, are no names of objects.
LEAST_IDENTITIES, LEAST_REPORTS = 2, 4
# Several objects share an identity of so many reports that lie so many times as far off the way
# from the one before to the one after as those of most.
FEWEST_BY_TURNS, BY_TURNS = 10, 30.0


def identity_error(reports: ReportTable, sensor: int) -> float | None:
    """Return how often a sensor's reports are under another identity than their object's.

    Parameters
    ----------
    reports
        Reports of positions.
    sensor
        The sensor's index.

    Returns
    -------
    A share; None where its reports hold no identities.
    """
    rows = np.flatnonzero((reports.sensor == sensor) & _named(reports))
    if rows.size == 0:
        return None
    assert reports.identity is not None
    order = by_identity(reports, rows)
    again = reports.identity[order[1:]] == reports.identity[order[:-1]]
    # Where most come once they are numbers of reports, and where most of one identity are at many
    # places at once it says "unknown": neither names an object.
    alone = 1.0 - 2.0 * float(np.mean(again)) if order.size > 1 else 0.0
    elsewhere = _elsewhere(reports, order[:-1][again], order[1:][again])
    if max(alone, elsewhere) > NO_NAMES:
        return min(max(alone, elsewhere), MOST_ERROR)
    wrong = _of_others(reports, order, np.flatnonzero(_is_absurd(reports, order)))
    return float((wrong + USUAL_ERROR * TRUSTED) / (rows.size + TRUSTED))


def note_on_identities(error: float | None) -> str | None:
    """Return a sentence where identities name no objects or change, None elsewhere."""
    if error is None or error < CHANGING:
        return None
    if error <= NO_NAMES:
        return (
            f"identities change, or are another's, in {100.0 * error:.2g} % of reports: where one "
            "ends another begins, and a track may go on under another"
        )
    return (
        "identities come only once, or at many places at once, so that they name no objects and "
        "hardly count; leave the column out, or empty where nothing is known"
    )


def identity_threads(reports: ReportTable, rows: IntArray) -> list[IntArray] | None:
    """Return the places in ``rows`` of each identity's reports; None where they tell no objects.

    Parameters
    ----------
    reports
        Reports of positions.
    rows
        Those of a sensor, in order of time.

    Returns
    -------
    In order of time, without those that are absurd; the longest first. Identities under which
    several objects report, here and there by turns, are left out.
    """
    named = _named(reports)[rows]
    if rows.size == 0 or np.count_nonzero(named) < LEAST_NAMED * rows.size:
        return None
    assert reports.identity is not None
    order = by_identity(reports, rows[named])
    absurd = _is_absurd(reports, order)
    place = np.full(len(reports), -1, dtype=np.int64)
    place[rows] = np.arange(rows.size)
    kept = order[~absurd]
    cuts = np.flatnonzero(np.diff(reports.identity[kept])) + 1
    threads = np.split(place[kept], cuts)
    # Of how many reports the usual report's identity is: of a receiver's first minute most ships
    # were heard once or twice, and most reports are of the few that are heard often.
    sizes = np.array([each.size for each in threads], dtype=np.int64)
    usual = np.median(np.repeat(sizes, sizes)) if sizes.size else 0
    if len(threads) < LEAST_IDENTITIES or usual < LEAST_REPORTS or absurd.mean() > MOST_WILD:
        return None
    wrong = identity_error(reports, int(reports.sensor[rows[0]]))
    if wrong is None or wrong > MOST_WRONG:
        return None
    threads = _of_one(reports, rows, threads)
    if len(threads) < LEAST_IDENTITIES:
        return None
    return sorted(threads, key=lambda each: -each.size)


def _of_one(reports: ReportTable, rows: IntArray, threads: list[IntArray]) -> list[IntArray]:
    """Return the threads but those of which reports lie here and there by turns."""
    off = np.full(len(threads), np.nan)
    for number, thread in enumerate(threads):
        place, time = reports.measurement[rows[thread]], reports.time[rows[thread]]
        if thread.size >= FEWEST_BY_TURNS:
            share = (time[1:-1] - time[:-2]) / np.maximum(time[2:] - time[:-2], 1e-9)
            between = place[:-2] + share[:, None] * (place[2:] - place[:-2])
            off[number] = np.median(np.linalg.norm(place[1:-1] - between, axis=1))
    usual = float(np.nanmedian(off)) if np.isfinite(off).any() else np.inf
    return [each for each, own in zip(threads, off, strict=True) if not own > BY_TURNS * usual]


def _named(reports: ReportTable) -> NDArray[np.bool_]:
    if reports.identity is None:
        return np.zeros(len(reports), dtype=np.bool_)
    return np.asarray(reports.identity >= 0)


def by_identity(reports: ReportTable, rows: IntArray) -> IntArray:
    """Return rows that are named by identity, each one's in order of time."""
    assert reports.identity is not None
    return rows[np.lexsort((reports.time[rows], reports.identity[rows]))]


def _is_absurd(reports: ReportTable, rows: IntArray) -> NDArray[np.bool_]:
    """Tell which reports, by identity and time, lie where their object cannot be."""
    assert reports.identity is not None
    own = reports.identity[rows]
    same = np.r_[own[1:] == own[:-1], False]
    step = np.linalg.norm(np.diff(reports.measurement[rows], axis=0, append=np.nan), axis=1)
    wait = np.maximum(np.diff(reports.time[rows], append=np.nan), 1e-3)
    step[~same] = np.nan
    # Whoever sets out is slower before, and whoever arrives slower after: only what is neither
    # as before nor as after is a leap, and one that leads there and one that leads back make a
    # report absurd.
    leaps = _leaps(step, own) & _leaps(step / wait, own)
    place = reports.measurement[rows]
    leaps &= step > PLACES * spacing_of_places(place[:-1][same[:-1]], place[1:][same[:-1]])
    led = np.r_[False, leaps[:-1]]
    return np.asarray(led & leaps)


def _of_others(reports: ReportTable, rows: IntArray, absurd: IntArray) -> float:
    """Return how many absurd reports are where another identity's object is."""
    # The others are wild reports of their own objects.
    assert reports.identity is not None
    own, when = reports.identity[rows], np.argsort(reports.time[rows], kind="stable")
    rank = np.empty(rows.size, dtype=np.int64)
    rank[when] = np.arange(rows.size)
    some = absurd[:: max(1, absurd.size // MOST_ABSURD)]
    found, place = 0, reports.measurement[rows]
    for each in some.tolist():
        near = when[max(0, rank[each] - AROUND) : rank[each] + AROUND + 1]
        near = near[own[near] != own[each]]
        off = np.linalg.norm(place[near] - place[each], axis=1).min(initial=np.inf)
        found += bool(off < NEAR * np.linalg.norm(place[each] - place[each - 1]))
    return found * absurd.size / max(some.size, 1)


def _elsewhere(reports: ReportTable, before: IntArray, after: IntArray) -> float:
    """Return which share of an identity's steps is far longer than to whoever reported lately."""
    if after.size == 0:
        return 0.0
    spacing = spacing_of_places(reports.measurement[before], reports.measurement[after])
    factor = ELSEWHERE if spacing == 0.0 else PLACES
    when = np.argsort(reports.time, kind="stable")
    when = when[reports.sensor[when] == reports.sensor[after[0]]]
    rank = np.empty(len(reports), dtype=np.int64)
    rank[when] = np.arange(when.size)
    place, time, found = reports.measurement, reports.time, 0
    some = slice(None, None, after.size // MOST_STEPS + 1)
    for early, late in zip(before[some].tolist(), after[some].tolist(), strict=True):
        lately = when[max(0, rank[late] - AROUND) : rank[late]]
        lately = lately[time[lately] < time[late]]
        if lately.size == 0:
            continue
        off = np.linalg.norm(place[lately] - place[late], axis=1)
        nearest = int(np.argmin(off))
        step, wait = float(np.linalg.norm(place[late] - place[early])), time[late] - time[early]
        # Where all come back to the same places, somebody else was there lately.
        least = max(float(off[nearest]), spacing)
        is_quick = step * (time[late] - time[lately[nearest]]) > QUICKER * least * wait
        found += bool(is_quick and step > factor * least)
    return found / len(after[some])


def _leaps(value: FloatArray, own: IntArray) -> NDArray[np.bool_]:
    """Tell which values are far above the medians of those before and of those after."""
    around = np.full((2, value.size), np.nan)
    for side, direction in enumerate((1, -1)):
        beside = np.full((BESIDE, value.size), np.nan)
        for number in range(1, min(BESIDE, value.size - 1) + 1):
            shifted, whose = np.roll(value, direction * number), np.roll(own, direction * number)
            inside = whose == own
            inside[: number if direction > 0 else 0] = False
            inside[value.size - number if direction < 0 else value.size :] = False
            beside[number - 1] = np.where(inside, shifted, np.nan)
        beside.sort(axis=0)  # what is missing comes last
        middle = np.maximum(np.count_nonzero(~np.isnan(beside), axis=0) - 1, 0) // 2
        around[side] = np.take_along_axis(beside, middle[None], axis=0)[0]
    return np.asarray(value > ABSURD * np.fmax(*around))
