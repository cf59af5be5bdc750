"""What objects do by themselves, as ranges tell it that are more exact than directions."""

from collections.abc import Sequence

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.reports import ReportTable
from trackweave.estimation.neighbours import is_as_most
from trackweave.estimation.noise import LONGEST_CHAIN, arrays_of, noise_of_chains

__all__ = ["platform_of", "process_along_sight"]

# A piece lasts while its line of sight turns by so little that directions add this part of the
# noise of ranges to what lies along it, between these angles [rad]; so many reports tell.
ADDED, LEAST_ANGLE, MOST_ANGLE = 0.5, 0.02, 0.2
FEWEST_IN_PIECE, FEWEST = 6, 60
# Reports from elsewhere, over all the length that reports are spread.
ELSEWHERE = 1e-3


def platform_of(reports: ReportTable, rows: np.ndarray, place: Sequence[float]) -> FloatArray:
    """Return where the sensor was, shape (rows, dim)."""
    dim = reports.measurement.shape[1]
    stands = np.zeros(dim)
    stands[: min(dim, len(place))] = list(place)[:dim]
    if reports.platform is None:
        return np.broadcast_to(stands, (rows.size, dim))
    said = reports.platform[rows, :dim]
    return np.where(np.isnan(said), stands, said)


def process_along_sight(
    reports: ReportTable,
    tracks: list[IntArray],
    seen_from: list[FloatArray],
    sigma: tuple[float, ...],
) -> float | None:
    """Return the process noise of tracks along the line of sight [m²/s³]."""
    # Across it the noise of directions, many times that of ranges far out, hides what objects do,
    # or is taken for it. Of each track the rows of one sensor's reports and where that was, shape
    # (rows, dim); ``sigma`` is the noise of ranges and directions [m, rad]. None where too few
    # reports tell.
    pieces = []
    for rows, place in zip(tracks, seen_from, strict=True):
        relative = reports.measurement[rows] - place
        for piece in _pieces(relative, sigma):
            middle = relative[piece][(piece.stop - piece.start) // 2]
            along = reports.measurement[rows[piece]] @ (middle / max(np.linalg.norm(middle), 1e-9))
            pieces.append((reports.time[rows[piece]], along[:, None]))
    if sum(time.size for time, _ in pieces) < FEWEST:
        return None
    time, along = arrays_of(pieces)
    # Noise that is a bad transponder's would seem to be turns.
    kept = is_as_most(time, along)
    density = ELSEWHERE / max(float(np.ptp(reports.measurement)), 1e-9)
    return noise_of_chains(time[kept], along[kept], sigma[0], density)[1]


def _pieces(relative: FloatArray, sigma: tuple[float, ...]) -> list[slice]:
    """Return pieces of a track in which its line of sight hardly turns."""
    distance = np.maximum(np.linalg.norm(relative, axis=1), 1e-9)
    sight = relative / distance[:, None]
    across = np.maximum(distance * max(sigma[1:]), 1e-9)
    # From the first report of a piece to its last, twice what it is from the middle.
    most = np.cos(2.0 * np.clip(ADDED * sigma[0] / across, LEAST_ANGLE, MOST_ANGLE))
    pieces, start = [], 0
    while start < len(sight):
        turned = sight[start : start + LONGEST_CHAIN] @ sight[start] < most[start]
        size = int(np.argmax(turned)) if turned.any() else turned.size
        if size >= FEWEST_IN_PIECE:
            pieces.append(slice(start, start + size))
        start += max(size, 1)
    return pieces
