"""How far objects come from scan to scan, and segments of tracks that stand out."""

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.estimation.frames import Frames
from trackweave.estimation.trees import pairs_within, tree_of

__all__ = ["reach", "segments"]

N_SHELLS = 48
# Where those that stand out are fewer than so many of all reports, a wider disc of pairs counts
# that holds more of them, so many deviations and by so much of a share above chance.
FEW, CLEARLY, DENSER = 0.25, 6.0, 0.5
NEAREST = 5


def reach(blocks: list[Frames]) -> tuple[float, float] | None:
    """Return the speed [m/s] within which successors stand out from unrelated reports."""
    # Pairs of successive scans' reports are counted by distance; the radius is where a dense disc
    # of pairs against a thin rest explains the counts best (Poisson likelihood of one step). With
    # it comes how many successors a scan's reports have on average above what chance brings. It is
    # None where no two scans follow one another or nothing stands out.
    times = [t for frames in blocks for t in np.diff(frames.time)]
    if not times:
        return None
    everything = np.concatenate([p for frames in blocks for p in frames.position])
    extent = float(np.linalg.norm(np.ptp(everything, axis=0)))
    interval = float(np.median(times))
    if extent <= 0:
        return None
    radii = extent * 2.0 ** (-np.arange(N_SHELLS)[::-1] / 3)
    counts = np.zeros(N_SHELLS)
    for frames in blocks:
        trees = [tree_of(position) for position in frames.position]
        for before, after, gap in zip(trees, trees[1:], np.diff(frames.time), strict=False):
            counts += pairs_within(before, after, radii * (gap / interval))
    chance = _chance_counts(everything, radii)
    n_reports = sum(p.shape[0] for frames in blocks for p in frames.position[1:])
    found = _outermost(counts, chance, FEW * n_reports)
    if found is not None and found[1] > n_reports:
        # No report has more than one successor: false alarms gather, and do so in each scan.
        found = _outermost(counts, _gathered_counts(blocks, radii), FEW * n_reports)
    return None if found is None else (float(radii[found[0]] / interval), found[1] / len(times))


def _outermost(counts: FloatArray, chance: FloatArray, few: float) -> tuple[int, float] | None:
    """Return how far out pairs are denser than chance, and how many more they are."""
    # A few reports that stay in one place make a disc of their own within that of the others:
    # where a wider one holds more, that one counts. It is the radius' index and the pairs above
    # what chance brings; None where nothing stands out.
    first, total = -1, 0.0
    while True:
        inner = (counts[first], chance[first]) if first >= 0 else (0.0, 0.0)
        rest = counts[first + 1 :] - inner[0], chance[first + 1 :] - inner[1]
        step = _likeliest_step(*rest) if rest[0].size > 1 else None
        if step is None:
            break
        # The step cuts into the slope of the disc; a little further out it is all there.
        wide = min(step + 2, rest[0].size - 1)
        beyond = max(rest[1][-1] - rest[1][wide], 1e-300)
        expected = (rest[0][-1] - rest[0][wide]) * rest[1][wide] / beyond
        excess = float(rest[0][wide] - expected)
        is_sure = excess > max(total, CLEARLY * np.sqrt(expected + 1.0), DENSER * expected)
        if first >= 0 and not is_sure:
            break
        first, total = first + 1 + wide, total + excess
        if total > few:
            break
    return None if first < 0 else (first, total)


def _chance_counts(position: FloatArray, radii: FloatArray) -> FloatArray:
    """Return how many unrelated pairs would lie within each radius, up to a factor, positive."""
    # Reports whose coordinates are exchanged among them fill the same space, edges included, but
    # know nothing of one another.
    some = position[:: max(position.shape[0] // 3000, 1)]
    mixed = np.stack(
        [np.sort(axis)[_scatter(axis.size, k)] for k, axis in enumerate(some.T)], axis=1
    )
    counts = pairs_within(tree_of(some), tree_of(mixed), radii).astype(float)
    return _smooth_where_few(counts, radii, position.shape[1])


def _smooth_where_few(counts: FloatArray, radii: FloatArray, dim: int) -> FloatArray:
    """Return counts of pairs as the volume tells where there are few."""
    # Few pairs are near: below a thousand, the volume tells better.
    enough = min(int(np.searchsorted(counts, min(1000.0, counts[-1] / 4))), radii.size - 1)
    near = radii[:enough] / radii[enough]
    counts[:enough] = counts[enough] * near**dim
    return np.asarray(np.maximum(counts, 1e-300))


def _gathered_counts(blocks: list[Frames], radii: FloatArray) -> FloatArray:
    """Return how many pairs of a scan's own reports, all unrelated, lie within each radius."""
    counts = np.zeros(radii.size)
    for frames in blocks:
        for position in frames.position:
            tree = tree_of(position)
            counts += pairs_within(tree, tree, radii) - position.shape[0]
    return _smooth_where_few(counts, radii, blocks[0].position[0].shape[1])


def _scatter(size: int, axis: int) -> IntArray:
    """Return a fixed shuffle of 0 … size − 1, another one for each axis."""
    golden = np.array([0.6180339887498949, 0.7548776662466927, 0.8191725133961645])[axis]
    return np.argsort((np.arange(size) * golden) % 1.0, kind="stable")


def _likeliest_step(counts: FloatArray, chance: FloatArray) -> int | None:
    """Return the radius inside which pairs are denser than chance, None where none stands out."""
    inside, outside = counts[:-1], counts[-1] - counts[:-1]
    chance_inside = np.maximum(chance[:-1], 1e-300)
    chance_outside = np.maximum(chance[-1] - chance[:-1], 1e-300)
    dense, thin = inside / chance_inside, outside / chance_outside
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        gain = np.where(inside > 0, inside * np.log(dense), 0.0)
        gain += np.where(outside > 0, outside * np.log(thin), 0.0)
    gain[(inside == 0) | (dense <= thin)] = -np.inf
    return int(np.argmax(gain)) if np.any(np.isfinite(gain)) else None


def segments(frames: Frames, start: int, length: int, speed: float) -> tuple[IntArray, FloatArray]:
    """Return straight pieces of tracks through successive scans, best first."""
    # Each pair of reports that an object could have made is followed by nearest neighbours of its
    # straight continuation; of pieces that share a report, the straightest stays. They are at
    # least 3 scans long. Residuals are the sums of squares from a straight line [m²]; indices are
    # of each piece's report in each scan, shape (pieces, length).
    trees = [tree_of(position) for position in frames.position[start : start + length]]
    time = frames.time[start : start + length] - frames.time[start]
    first, second = frames.position[start], frames.position[start + 1]
    near = min(NEAREST, second.shape[0])
    distance, other = trees[1].query(first, k=near, distance_upper_bound=speed * time[1])
    distance, other = distance.reshape(-1, near), other.reshape(-1, near)
    origin, choice = np.nonzero(np.isfinite(distance))
    chosen = [origin, other[origin, choice]]
    points = [first[chosen[0]], second[chosen[1]]]
    for step in range(2, length):
        predicted = _extrapolate(np.stack(points), time[: step + 1])
        _, index = trees[step].query(predicted)
        chosen.append(np.asarray(index))
        points.append(frames.position[start + step][index])
    index = np.stack(chosen, axis=1).astype(np.int64)
    rss = _residual(np.stack(points), time)
    return _disjoint(index, rss)


def _extrapolate(points: FloatArray, time: FloatArray) -> FloatArray:
    """Continue straight lines, fitted to points at all times but the last, to the last."""
    known, ahead = time[:-1], time[-1]
    centred = known - known.mean()
    slope = np.tensordot(centred, points, axes=1) / np.dot(centred, centred)
    return np.asarray(points.mean(axis=0) + slope * (ahead - known.mean()))


def _residual(points: FloatArray, time: FloatArray) -> FloatArray:
    """Return the sum of squared residuals from straight lines."""
    centred = time - time.mean()
    slope = np.tensordot(centred, points, axes=1) / np.dot(centred, centred)
    fitted = points.mean(axis=0) + slope * centred[:, None, None]
    return np.asarray(np.sum((points - fitted) ** 2, axis=(0, 2)))


def _disjoint(index: IntArray, rss: FloatArray) -> tuple[IntArray, FloatArray]:
    """Keep of pieces that share a report the one of least residual."""
    order = np.argsort(rss, kind="stable")
    used: list[set[int]] = [set() for _ in range(index.shape[1])]
    kept = []
    for piece in order:
        row = index[piece].tolist()
        if any(report in taken for report, taken in zip(row, used, strict=True)):
            continue
        for report, taken in zip(row, used, strict=True):
            taken.add(report)
        kept.append(piece)
    return index[kept], rss[kept]
