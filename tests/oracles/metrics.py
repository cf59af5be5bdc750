"""Slow, obvious twins of the metrics."""

import itertools
from collections.abc import Iterator

import numpy as np

Place = tuple[float, ...]
Rows = dict[int, dict[str, Place]]  # time -> identity -> place


def distance(first: Place, second: Place) -> float:
    return float(np.linalg.norm(np.subtract(first, second)))


def pairings(n_rows: int, n_columns: int) -> Iterator[list[tuple[int, int]]]:
    """Yield every way to pair some rows with different columns."""
    for size in range(min(n_rows, n_columns) + 1):
        for rows in itertools.combinations(range(n_rows), size):
            for columns in itertools.permutations(range(n_columns), size):
                yield list(zip(rows, columns, strict=True))


def gospa(truth: list[Place], tracks: list[Place], cutoff: float, order: float) -> float:
    """Proposition 1 of Rahmathullah et al.: the least over all partial assignments."""
    least = np.inf
    for pairs in pairings(len(truth), len(tracks)):
        near = sum(distance(truth[row], tracks[column]) ** order for row, column in pairs)
        alone = len(truth) + len(tracks) - 2 * len(pairs)
        least = min(least, near + cutoff**order / 2 * alone)
    return float(least ** (1 / order))


def ospa(truth: list[Place], tracks: list[Place], cutoff: float, order: float) -> float:
    """Equation (3) of Schuhmacher et al.: over all permutations of the larger set."""
    if not truth and not tracks:
        return 0.0
    fewer, more = sorted((truth, tracks), key=len)
    least = min(
        sum(
            min(distance(place, more[other]), cutoff) ** order
            for place, other in zip(fewer, chosen, strict=True)
        )
        for chosen in itertools.permutations(range(len(more)), len(fewer))
    )
    return float(((least + cutoff**order * (len(more) - len(fewer))) / len(more)) ** (1 / order))


def ospa2(truth: Rows, tracks: Rows, window: range, cutoff: float, order: float) -> float:
    """Section III of Beard, Vo and Vo: OSPA of whole paths, their distance a mean over time."""

    def paths(rows: Rows) -> list[dict[int, Place]]:
        names = sorted({name for time in window for name in rows.get(time, {})})
        return [{k: rows[k][name] for k in window if name in rows.get(k, {})} for name in names]

    def apart(first: dict[int, Place], second: dict[int, Place]) -> float:
        both, either = first.keys() & second.keys(), first.keys() | second.keys()
        near = sum(min(distance(first[time], second[time]), cutoff) for time in both)
        return (near + cutoff * (len(either) - len(both))) / len(either)

    fewer, more = sorted((paths(truth), paths(tracks)), key=len)
    if not more:
        return 0.0
    least = min(
        sum(apart(path, more[other]) ** order for path, other in zip(fewer, chosen, strict=True))
        for chosen in itertools.permutations(range(len(more)), len(fewer))
    )
    return float(((least + cutoff**order * (len(more) - len(fewer))) / len(more)) ** (1 / order))


def _best_new_pairs(
    truth: dict[str, Place], tracks: dict[str, Place], cutoff: float, order: float
) -> dict[str, str]:
    targets, names = list(truth), list(tracks)
    best, least = {}, np.inf
    for pairs in pairings(len(targets), len(names)):
        gaps = [distance(truth[targets[row]], tracks[names[column]]) for row, column in pairs]
        if any(gap >= cutoff for gap in gaps):
            continue
        price = sum(gap**order - cutoff**order for gap in gaps)
        if price < least:
            least = price
            best = {targets[row]: names[column] for row, column in pairs}
    return best


def clear_mot(truth: Rows, tracks: Rows, cutoff: float, order: float) -> dict[str, float]:
    """The procedure of section 2.2 of Bernardin and Stiefelhagen, step by step."""
    before: dict[str, str] = {}
    last: dict[str, str] = {}
    lives: dict[str, list[bool]] = {}
    gaps, switches, missed, false, total = [], 0, 0, 0, 0
    for time in sorted(truth):
        here, there = truth[time], tracks.get(time, {})
        pairs = {
            target: track
            for target, track in before.items()
            if target in here and track in there and distance(here[target], there[track]) < cutoff
        }
        free = {target: place for target, place in here.items() if target not in pairs}
        spare = {track: place for track, place in there.items() if track not in pairs.values()}
        pairs |= _best_new_pairs(free, spare, cutoff, order)
        for target, track in pairs.items():
            switches += target in last and last[target] != track
            last[target] = track
            gaps.append(distance(here[target], there[track]))
        for target in here:
            lives.setdefault(target, []).append(target in pairs)
        missed += len(here) - len(pairs)
        false += len(there) - len(pairs)
        total += len(here)
        before = pairs
    fragmentations = 0
    for life in lives.values():
        stretches = [paired for paired, _ in itertools.groupby(life)]
        fragmentations += max(stretches.count(True) - 1, 0)
    return {
        "mota": 1 - (missed + false + switches) / total,
        "motp": float(np.mean(gaps)) if gaps else np.nan,
        "switches": switches,
        "fragmentations": fragmentations,
        "n_missed": missed,
        "n_false": false,
    }


def idf1(truth: Rows, tracks: Rows, cutoff: float) -> float:
    """Section 3.2 of Ristani et al.: the best one-to-one naming of whole lives."""
    targets = sorted({name for here in truth.values() for name in here})
    names = sorted({name for time in truth for name in tracks.get(time, {})})
    best = 0
    for pairs in pairings(len(targets), len(names)):
        agreed = sum(
            distance(truth[time][targets[row]], tracks[time][names[column]]) < cutoff
            for row, column in pairs
            for time in truth
            if targets[row] in truth[time] and names[column] in tracks.get(time, {})
        )
        best = max(best, agreed)
    sizes = sum(len(here) for here in truth.values())
    sizes += sum(len(tracks.get(time, {})) for time in truth)
    return 2 * best / sizes


def _alike(first: Place, second: Place, cutoff: float) -> float:
    return max(0.0, 1 - distance(first, second) / cutoff)


def _alignments(truth: Rows, tracks: Rows, cutoff: float) -> dict[tuple[str, str], float]:
    """Equation (C1) of Luiten et al.: how well each target and track agree over all times."""
    shared: dict[tuple[str, str], float] = {}
    for time, here in truth.items():
        there = tracks.get(time, {})
        for target, track in itertools.product(here, there):
            own = _alike(here[target], there[track], cutoff)
            row = sum(_alike(here[target], place, cutoff) for place in there.values())
            column = sum(_alike(place, there[track], cutoff) for place in here.values())
            if own > 0:
                key = target, track
                shared[key] = shared.get(key, 0.0) + own / (row + column - own)
    n_truth, n_tracked = _presences(truth), _presences(tracks)
    return {
        (target, track): both / (n_truth[target] + n_tracked[track] - both)
        for (target, track), both in shared.items()
    }


def _presences(rows: Rows) -> dict[str, int]:
    names = [name for here in rows.values() for name in here]
    return {name: names.count(name) for name in names}


def _best_by_alignment(
    here: dict[str, Place],
    there: dict[str, Place],
    alignment: dict[tuple[str, str], float],
    cutoff: float,
) -> list[tuple[str, str, float]]:
    targets, names = list(here), list(there)
    best, most = [], -1.0
    for pairs in pairings(len(targets), len(names)):
        found = [
            (targets[row], names[column], _alike(here[targets[row]], there[names[column]], cutoff))
            for row, column in pairs
        ]
        value = sum(alignment.get((target, track), 0.0) * own for target, track, own in found)
        if value > most:
            best, most = found, value
    return best


def hota(truth: Rows, tracks: Rows, cutoff: float) -> float:
    """Luiten et al. with the similarity 1 - distance / cutoff, pair by pair."""
    alignment = _alignments(truth, tracks, cutoff)
    n_truth, n_tracked = _presences(truth), _presences(tracks)
    total = sum(n_truth.values()) + sum(n_tracked.values())
    chosen = [
        pair
        for time, here in truth.items()
        for pair in _best_by_alignment(here, tracks.get(time, {}), alignment, cutoff)
    ]
    values = []
    for level in np.arange(1, 20) * 0.05:
        pairs = [(target, track) for target, track, own in chosen if own >= level - 1e-15]
        agreement = [
            pairs.count((target, track))
            / (n_truth[target] + n_tracked[track] - pairs.count((target, track)))
            for target, track in pairs
        ]
        detection = len(pairs) / (total - len(pairs))
        values.append(np.sqrt(detection * np.mean(agreement)) if pairs else 0.0)
    return float(np.mean(values))
