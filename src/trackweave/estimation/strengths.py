"""What the strengths of reports tell of their origin, from tracks and from reports in none."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.reports import ReportTable
from trackweave.estimation.estimates import Estimates, digits
from trackweave.estimation.refine import Followed, sure_tracks
from trackweave.models.strength import StrengthModel

__all__ = ["strength_model", "with_strengths"]

# Reports that make no track but by chance.
LONE_HITS = 2

FEWEST = 30
# A report of an object is stronger than a false alarm so often, or strength tells too little.
CLEARLY = 0.8
N_ROUNDS = 10
# So many objects tell how strong the weak and the strong ones are.
FEWEST_KINDS = 8
# What was reported so often and went so many standard deviations of its noise is no false alarm
# that stays, nor one that a car passes by.
OFTEN, GONE = 60, 8.0
FEWEST_GONE = 6  # Reports that tell how far they went
# Of objects that go their way no fewer, and no smaller share, are weak where weak ones are usual.
FEWEST_DIM, DIM = 3, 0.15
# What went so many standard deviations wanders. False alarms are mostly alone: where weak tracks
# that wander hold more reports than make no track, weak ones are objects.
WANDERS = 4.0
# Quantile of a tail, and how many standard deviations off it lies where tails are normal.
TAIL, TAIL_SIGMAS = 0.05, 1.645


def with_strengths(estimates: Estimates, reports: ReportTable, followed: Followed) -> Estimates:
    """Return estimates in which sensors whose reports carry strengths say what these tell."""
    # Where strengths tell nothing, they are as they were.
    if reports.strength is None:
        return estimates
    blind = {name: replace(sensor, strength=None) for name, sensor in estimates.sensors.items()}
    tracks = sure_tracks(replace(estimates, sensors=blind), reports, followed)
    sizes = np.bincount(followed.track + 1, minlength=1)
    sizes[0] = 0
    is_lone = sizes[followed.track + 1] <= LONE_HITS
    sensors = dict(blind)
    for index, name in enumerate(reports.sensors):
        if name in sensors:
            own = reports.sensor == index
            rows = [track.rows[own[track.rows]] for track in tracks]
            groups = [reports.strength[each] for each in rows]
            sure = sensors[name].clutter_persistence > 0.0
            gone = [_gone(reports, each) for each in rows]
            is_long = [each.size >= OFTEN for each in rows]
            found = strength_model(
                groups,
                reports.strength[own & is_lone],
                are_sure=sure,
                move=[far > GONE and often for far, often in zip(gone, is_long, strict=True)],
                wander=[far > WANDERS for far in gone],
            )
            sensors[name] = replace(sensors[name], strength=found)
    return replace(estimates, sensors=sensors)


def _gone(reports: ReportTable, rows: IntArray) -> float:
    """Return how far reports of a track went, in standard deviations of their noise."""
    if rows.size < FEWEST_GONE:
        return 0.0
    third = rows.size // 3
    place = reports.measurement[rows]
    # Second differences of reports at equal steps have six times the variance of one.
    noise = np.mean(np.diff(place, 2, axis=0) ** 2, axis=0) / 6.0
    gone = (place[-third:].mean(axis=0) - place[:third].mean(axis=0)) ** 2
    return float(np.sqrt(np.max(gone / np.maximum(noise, 1e-300))))


def strength_model(
    tracks: Sequence[FloatArray],
    lone: FloatArray,
    *,
    are_sure: bool = False,
    move: Sequence[bool] = (),
    wander: Sequence[bool] = (),
) -> StrengthModel | None:
    """Return how strong reports of objects and false alarms are."""
    # Tracks whose reports are more like false alarms than like those of other tracks are taken to
    # be false alarms that stay in one place, unless they ``move``, or most of them ``wander``.
    # ``lone`` are those of the reports in no track. It is None where reports are too few or the
    # two distributions do not differ clearly. Where tracks ``are_sure``, because false alarms that
    # stay are told apart by that they stay, none is taken for one, and objects may be weak or
    # strong.
    tracks = [own[np.isfinite(own)] for own in tracks]
    some = [own.size > 0 for own in tracks]
    goes, wanders = (
        np.array(each or [False] * len(tracks), dtype=bool)[some] for each in (move, wander)
    )
    tracks = [own for own in tracks if own.size]
    lone = lone[np.isfinite(lone)]
    is_object = np.ones(len(tracks), dtype=bool)
    found = None
    for _ in range(N_ROUNDS):
        own = [track for track, kept in zip(tracks, is_object, strict=True) if kept]
        others = [track for track, kept in zip(tracks, is_object, strict=True) if not kept]
        found = _fitted(own, np.concatenate([*others, lone]), spread=are_sure)
        if found is None:
            return None
        if are_sure:
            break
        fits = np.array([found.evidence(track).mean() >= 0 for track in tracks], dtype=bool)
        dim = np.count_nonzero(goes & ~fits)
        if dim >= max(FEWEST_DIM, DIM * np.count_nonzero(goes)):
            return _fitted(own, np.concatenate([*others, lone]), spread=True)
        sizes = np.array([track.size for track in tracks])
        if sizes[wanders & ~is_object].sum() > lone.size:
            return _fitted(tracks, lone, spread=True)
        told = fits | goes
        if np.array_equal(told, is_object):
            break
        is_object = told
    return found


def _fitted(
    tracks: Sequence[FloatArray], clutter: FloatArray, *, spread: bool
) -> StrengthModel | None:
    """Return both distributions, None where they are not clearly apart."""
    target = np.concatenate([*tracks, np.empty(0)])
    if min(target.size, clutter.size) < FEWEST:
        return None
    ordered = np.sort(clutter)
    if np.searchsorted(ordered, target).mean() < CLEARLY * clutter.size:
        return None
    of_clutter = digits(float(np.median(clutter))), _spread(clutter)
    if spread and len(tracks) >= FEWEST_KINDS:
        middle = [float(np.median(track)) for track in tracks]
        low, high = np.quantile(middle, [TAIL, 1 - TAIL])
        within = np.concatenate([track - np.median(track) for track in tracks])
        usual = digits(float(low + high) / 2), _spread(within)
        return StrengthModel(*usual, *of_clutter, digits(float(high - low) / 2))
    return StrengthModel(digits(float(np.median(target))), _spread(target), *of_clutter)


def _spread(strength: FloatArray) -> float:
    """Return the standard deviation that covers the longer tail; scores are often skew."""
    middle = float(np.median(strength))
    low, high = np.quantile(strength, [TAIL, 1 - TAIL])
    inner = 1.4826 * float(np.median(np.abs(strength - middle)))
    tail = max(middle - float(low), float(high) - middle) / TAIL_SIGMAS
    return max(digits(max(inner, tail)), 1e-3 * abs(middle), 1e-6)
