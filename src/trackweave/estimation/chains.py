"""Tracks that are beyond doubt, and what can be measured on them."""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.chi_squared import share_within
from trackweave.estimation.covering import along_line
from trackweave.estimation.frames import Frames
from trackweave.estimation.motion import segments
from trackweave.estimation.trees import ball_volume, tree_of

__all__ = [
    "Chains",
    "chains_of",
    "detection_share",
    "doubt_about",
    "local_density",
    "speed_of_few",
]

# With so many unrelated reports about a successor, false segments line up.
CROWDED = 1.0
SEGMENT = 6
STRIDE = 3
MAX_CHAINS = 300
MIN_SEGMENTS = 10
# Of the segments that count chance makes no more than this part, but in a crowd, where all count
# of which it makes so many as straight for each report.
FALSE_PART, MOST_BY_CHANCE = 0.2, 1.0
# What is left makes fewer false segments than this in all; the few are hardly noisier than the
# many, and seen twice. So few others lie within the noise, or no line of them tells anything; the
# fastest of all count where so few lie within reach that hardly any segment is none.
FALSE_OF_FEW, AS_NOISY, ALIKE, THIN, EMPTY = 0.01, 5.0, 1.25, 0.003, 0.02
# Beside others those of the many count of which chance makes fewer than this in all.
BEYOND_CHANCE = 1e-6
# Where more than this part of the scans have a report, something stands.
RECURRING = 0.1
# A predicted place is followed up to this many standard deviations, for so many misses.
GATE = 3.5
MAX_MISSES = 2
# However far off, a report counts where chance would put another with this probability only.
CHANCE_OF_ANOTHER = 0.02
# A segment is clean where so few strangers are as near as it is bent: where so many are, this part
# of all, and half of them by far.
STRANGERS, FEWEST_CLEAN, CLEAN_PART, INSIDE = 0.05, 4, 0.2, 0.35
# So many neighbours tell how dense points are.
NEIGHBOURS = 3
# The digamma function of that number.
LOG_OF_FEW = 1.0 + 1 / 2 - np.euler_gamma


@dataclass(frozen=True, slots=True, eq=False)
class Chains:
    """Positions of objects over successive scans, one row per chain."""

    time: FloatArray  # Times of the scans [s], shape (chains, scans); NaN after the chain's last
    position: FloatArray  # [m], shape (chains, scans, dim); NaN where there was none
    speed: FloatArray  # Of each chain's first segment [m/s], shape (chains,)
    # Mean squared residual of that segment from a straight line, per axis [m²].
    residual: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class _Segment:
    """A piece of a track through successive scans of a block."""

    frames: Frames
    start: int
    points: FloatArray
    residual: float
    index: IntArray
    chance: float

    def strangers(self, density: float) -> float:
        """Return how many unrelated reports lie where one would bend it no more than it is."""
        count, dim = self.points.shape
        bent = math.sqrt(self.residual * (count - 2) * dim)
        return density * float(ball_volume(bent, dim))


def local_density(position: FloatArray) -> float:
    """Return how dense points [m], shape (points, dim), are where they are, per m² (m³)."""
    # It is a geometric mean over them; 0 where they are too few to tell, or on a line.
    if position.shape[0] <= NEIGHBOURS or along_line(position) is not None:
        return 0.0
    distance = tree_of(position).query(position, k=NEIGHBOURS + 1)[0][:, -1]
    volume = ball_volume(np.maximum(distance, 1e-9), position.shape[1])
    # The logarithm of so few neighbours is less on average than that of their number.
    return float(np.exp(np.mean(LOG_OF_FEW - np.log(volume))))


def chains_of(blocks: list[Frames], speed: float, density: float) -> Chains | None:
    """Return tracks that chance would hardly make, None where none stands out."""
    # Speed is the greatest of an object [m/s]; density is of reports per unit of volume and scan.
    windows = [(frames, window) for frames in blocks for window in _windows(frames)]
    found = _sure_segments(windows, speed, density)
    if not found:
        return None
    found = found[:: -(-len(found) // MAX_CHAINS)]
    return _extend(found, density)


def detection_share(
    blocks: list[Frames], speed: float, density: float
) -> tuple[float, float] | None:
    """Return how often an object is reported, by leaving one scan out."""
    # Tracks that are sure from three scans before and three after say where their object was
    # between; what lies there above what chance puts there is the detections. The share, which
    # noise may take beyond 1, comes with its standard error, wider in a crowd, where pieces take
    # wrong reports; None where there are too few tracks to tell.
    around = np.array([-3, -2, -1, 1, 2, 3])
    windows = [
        (frames, middle + around) for frames in blocks for middle in range(3, len(frames) - 3)
    ]
    found = _sure_segments(windows, speed, density)
    if len(found) < MIN_SEGMENTS:
        return None
    # A piece that took a wrong report is bent: half of the pieces are enough.
    limit = float(np.median([segment.residual for segment in found]))
    sigma = np.sqrt(limit)
    excess = []
    for segment in found:
        if segment.residual > limit:
            continue
        middle = segment.start + 3
        time = segment.frames.time[middle + around]
        place, spread = _continue(time, segment.points, segment.frames.time[middle], sigma)
        excess.append(_excess(segment.frames.position[middle], place, 3.0 * spread))
    inside = share_within(found[0].points.shape[1], 9.0)
    share = np.array(excess) / inside
    crowd = density * float(ball_volume(3.0 * sigma, found[0].points.shape[1]))
    return float(share.mean()), float(np.hypot(share.std() / np.sqrt(share.size), crowd / 2))


def speed_of_few(blocks: list[Frames], speed: float, density: float) -> float | None:
    """Return how fast the few are that are faster than the many [m/s]; None for none."""
    # Reports that line up at the speed of the many are laid aside. What is left is looked through
    # as far about each report as there is one other on average. The fastest among the many count
    # too, where hardly any other lies within their reach or chance makes none so straight. It is
    # the greatest speed that is seen twice.
    speeds = []
    for frames in blocks:
        many, left = _left_over(frames, speed, density)
        if len(left) < SEGMENT or not many:
            continue
        noise = float(np.median([segment.residual for segment in many]))
        interval = float(np.median(np.diff(frames.time)))
        count = sum(position.shape[0] for position in left.position)
        thin = density * count / sum(position.shape[0] for position in frames.position)
        dim = left.position[0].shape[1]
        if thin * float(ball_volume(math.sqrt(noise), dim)) > THIN:
            continue
        wide = float((thin * ball_volume(1.0, dim)) ** (-1 / dim)) / interval
        for window in _windows(left):
            times = left.time[window]
            # Over steps much shorter than the usual, noise looks like speed.
            steps = np.diff(times)
            if steps.min() > interval / 2 and steps.sum() < 2 * SEGMENT * interval:
                speeds += [
                    _speed(times, piece.points)
                    for piece in _likely_segments(left, window, wide, thin)
                    if piece.residual < AS_NOISY * noise
                    and piece.chance < FALSE_OF_FEW / count
                    and not _stands(frames, piece.points, 2.0 * math.sqrt(noise))
                ]
        n_reports = sum(position.shape[0] for position in frames.position)
        is_empty = density * float(ball_volume(speed * interval, dim)) < EMPTY
        speeds += [
            _speed(frames.time[one.start : one.start + SEGMENT], one.points)
            for one in many
            if one.residual < AS_NOISY * noise
            and (is_empty or one.chance < BEYOND_CHANCE / n_reports)
        ]
    # One by itself may be chance: what goes on so fast makes another.
    speeds = sorted(speeds)
    again = [v for before, v in pairwise(speeds) if v < ALIKE * before]
    return max(again, default=None)


def _stands(frames: Frames, points: FloatArray, near: float) -> bool:
    """Tell whether most points are of what stands, such as posts in a row [m]."""
    # One seen after the other they would be an object of any speed.
    seen = [tree_of(place).query(points)[0] <= near for place in frames.position]
    return bool(np.median(np.mean(seen, axis=0)) > RECURRING)


def _left_over(frames: Frames, speed: float, density: float) -> tuple[list[_Segment], Frames]:
    """Return what lines up at a speed, and scans without it, empty ones left out."""
    left = [np.ones(position.shape[0], dtype=bool) for position in frames.position]
    found = _sure_segments([(frames, window) for window in _windows(frames)], speed, density)
    for segment in found:
        for scan, index in enumerate(segment.index, segment.start):
            left[scan][index] = False
    kept = [scan for scan, one in enumerate(left) if one.any()]
    others = [frames.position[scan][left[scan]] for scan in kept]
    return found, Frames(frames.time[kept], others, frames.share)


def _windows(frames: Frames) -> list[IntArray]:
    """Return the scans through which segments are looked for."""
    length = min(SEGMENT, len(frames))
    return [start + np.arange(length) for start in range(0, len(frames) - length + 1, STRIDE)]


def _sure_segments(
    windows: list[tuple[Frames, IntArray]], speed: float, density: float
) -> list[_Segment]:
    """Return the segments through some scans, of which hardly any is chance's."""
    found, n_starts = [], 0
    for frames, chosen in windows:
        found += _likely_segments(frames, chosen, speed, density)
        n_starts += frames.position[chosen[0]].shape[0]
    # The most of them of which chance makes so small a part (Benjamini and Hochberg 1995).
    chance = np.array([segment.chance for segment in found])
    order = np.argsort(chance, kind="stable")
    few = np.flatnonzero(chance[order] * n_starts <= FALSE_PART * np.arange(1, chance.size + 1))
    if not few.size:
        return []
    sure = [found[number] for number in np.sort(order[: few[-1] + 1]).tolist()]
    # Where an object was missed, a stranger's report bends its segment as far as there are any:
    # straighter ones count, unless it is a crowd, where these are the straightest by chance.
    strangers = np.array([segment.strangers(density) for segment in sure])
    clean = strangers <= STRANGERS
    is_many = np.count_nonzero(clean) >= max(FEWEST_CLEAN, CLEAN_PART * len(sure))
    if is_many and np.median(strangers[clean]) <= INSIDE * STRANGERS:
        return [segment for segment, is_clean in zip(sure, clean, strict=True) if is_clean]
    return sure if np.median(strangers) <= STRANGERS else found


def _likely_segments(
    frames: Frames, chosen: IntArray, speed: float, density: float
) -> list[_Segment]:
    """Return the segments through the chosen scans that chance would seldom make."""
    if chosen.size < 3:
        return []
    part = Frames(frames.time[chosen], [frames.position[k] for k in chosen])
    dim = part.position[0].shape[1]
    pieces, rss = segments(part, 0, chosen.size, speed)
    chance = _by_chance(part.time, rss, (speed, density, dim))
    sure = np.flatnonzero(chance < MOST_BY_CHANCE)
    if sure.size:
        # Where false alarms gather, they line up far more often than where they are thin.
        points = [part.position[k][index] for k, index in enumerate(pieces[sure].T)]
        local = np.mean([frames.density_about(place) for place in points], axis=0)
        chance[sure] *= np.maximum(local / density, 1.0) ** (chosen.size - 1)
        sure = sure[chance[sure] < MOST_BY_CHANCE]
    return [
        _Segment(
            frames,
            int(chosen[0]),
            np.array([part.position[k][index] for k, index in enumerate(pieces[piece])]),
            float(rss[piece]) / ((chosen.size - 2) * dim),
            pieces[piece],
            float(chance[piece]),
        )
        for piece in sure
    ]


def _by_chance(time: FloatArray, rss: FloatArray, thrown: tuple[float, float, int]) -> FloatArray:
    """Return how many segments as straight unrelated reports make for each report, on average."""
    # ``thrown`` are the greatest speed, how dense reports are, and the dimensions. Of the first
    # report the second lies within reach, and the others anywhere as long as the residuals, a
    # vector of as many dimensions as are free, are no longer: its volume in places is so many
    # times that in residuals.
    speed, density, dim = thrown
    centred, count = time - time.mean(), time.size
    stretch = math.sqrt(count * np.dot(centred, centred)) / (time[1] - time[0])
    free = (count - 2) * dim
    ball = math.pi ** (free / 2) / math.gamma(free / 2 + 1)
    starts = density * float(ball_volume(speed * (time[1] - time[0]), dim))
    straight = (stretch**dim) * ball * rss ** (free / 2) * density ** (count - 2)
    return np.asarray(starts * straight)


def _extend(found: list[_Segment], density: float) -> Chains:
    """Follow each segment while what it continues with is beyond doubt."""
    length = max(len(segment.frames) - segment.start for segment in found)
    dim = found[0].points.shape[1]
    sigma = float(np.sqrt(np.median([segment.residual for segment in found])))
    # Where reports are few, the nearest is the object's own even after a sharp turn.
    alone = float((CHANCE_OF_ANOTHER / (density * ball_volume(1.0, dim))) ** (1 / dim))
    times = np.full((len(found), length), np.nan)
    positions = np.full((len(found), length, dim), np.nan)
    for time, position, segment in zip(times, positions, found, strict=True):
        after = segment.frames.time[segment.start :]
        n = segment.points.shape[0]
        time[:n], position[:n] = after[:n], segment.points
        misses = 0
        for step in range(n, after.size):
            known = np.flatnonzero(np.isfinite(position[:, 0]))[-SEGMENT:]
            place, spread = _continue(time[known], position[known], after[step], sigma)
            reports = segment.frames.position[segment.start + step]
            distance = np.linalg.norm(reports - place, axis=1)
            near = np.flatnonzero(distance <= max(GATE * spread, alone))
            misses = 0 if near.size else misses + 1
            if near.size > 1 or misses > MAX_MISSES:
                break
            time[step] = after[step]
            if near.size:
                position[step] = reports[near[0]]
    speed = [_speed(s.frames.time[s.start : s.start + len(s.points)], s.points) for s in found]
    return Chains(times, positions, np.array(speed), np.array([s.residual for s in found]))


def _speed(time: FloatArray, points: FloatArray) -> float:
    centred = time - time.mean()
    return float(np.linalg.norm(centred @ points / np.dot(centred, centred)))


def _continue(
    time: FloatArray, points: FloatArray, ahead: float, sigma: float
) -> tuple[FloatArray, float]:
    """Return where a straight line leads, and the standard deviation of a report there."""
    centred = time - time.mean()
    spread = float(np.dot(centred, centred))
    lever = ahead - time.mean()
    place = points.mean(axis=0) + lever * (centred @ points) / spread
    return place, float(sigma * np.sqrt(1 + 1 / time.size + lever**2 / spread))


def _excess(reports: FloatArray, place: FloatArray, radius: float) -> float:
    """Return how many reports lie in a ball above what the shell around it leads to expect."""
    distance = np.linalg.norm(reports - place, axis=1)
    inner = int(np.count_nonzero(distance <= radius))
    outer = int(np.count_nonzero(distance <= 2 * radius)) - inner
    return inner - outer / (2.0**place.size - 1)


def doubt_about(
    blocks: list[Frames],
    stands_out: tuple[float, float] | None,
    chains: Chains | None,
    strangers: float,
) -> str | None:
    """Return why the estimates are doubtful, None where they are not."""
    # ``strangers`` is how dense reports of others are.
    if stands_out is None:
        return "no report stands out as another's successor; usual values stand in"
    if chains is None:
        return "no reports line up over several scans beyond chance; usual values stand in"
    interval = float(np.median([step for frames in blocks for step in np.diff(frames.time)]))
    dim = blocks[0].position[0].shape[1]
    crowd = strangers * float(ball_volume(stands_out[0] * interval, dim))
    if crowd > CROWDED:
        return (
            f"a crowd, in which {crowd:.2g} unrelated reports lie where an object's next may be, "
            "so that noise and detection probability come out too low"
        )
    return None
