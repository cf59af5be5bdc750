"""What reports of common objects say of sensors' biases: normal equations, object by object."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.estimation.sightings import CLOCK, N_BIASES, Sightings

__all__ = ["Equations", "Pieces", "equations_of", "pieces_of", "weights_of"]

# An object's way in a piece of so many slowest periods is a cubic.
PIECE, N_POWERS = 4.0, 4
# A sensor tells something of a piece with so many reports, and so many are more than a cubic has.
FEWEST_OF_SENSOR, FEWEST_OF_PIECE = 2, N_POWERS + 2
# Reports count less beyond so many deviations, not at all beyond so many; pieces, as in turns
# that no cubic follows, count less where their reports lie so many times as far off as they should.
HUBER, WORST, BENT = 2.5, 6.0, 1.5
LEAST_WEIGHT = 1e-6


class Pieces(NamedTuple):
    """Reports of objects by pieces of time, those of a piece beside each other."""

    row: IntArray  # In the sightings
    piece: IntArray  # Number of the piece of each, ascending from 0
    object: IntArray  # Number of the object of each, from 0
    length: float  # How long a piece is [s]


@dataclass(frozen=True, eq=False)
class Equations:
    """Normal equations of small changes of all biases, (sensor, bias) raveled."""

    matrix: FloatArray
    # What each report adds to the right side, shape (reports, biases).
    score: FloatArray
    off: FloatArray  # How far each report is off, in its standard deviations
    size: FloatArray  # How far a unit of each bias moves a report, root mean square [m]

    @property
    def vector(self) -> FloatArray:
        """The right side."""
        return np.asarray(self.score.sum(axis=0))


def pieces_of(sightings: Sightings, objects: IntArray) -> Pieces:
    """Return what at least two sensors saw of an object in a piece of time."""
    length = PIECE * float(sightings.period.max())
    moment = np.floor((sightings.time - sightings.time.min()) / length).astype(np.int64)
    whose = objects[sightings.track]
    piece = whose * (int(moment.max()) + 1) + moment
    row = np.arange(piece.size)
    # Of a sensor the track that it has most reports of, if these are enough.
    of_track = piece * len(sightings.rows) + sightings.track
    _, place, count = np.unique(of_track, return_inverse=True, return_counts=True)
    of_sensor = piece * sightings.n_sensors + sightings.sensor
    _, where = np.unique(of_sensor, return_inverse=True)
    rank = count[place.reshape(-1)] + 1.0 / (2.0 + sightings.track)
    most = np.zeros(int(where.max()) + 1)
    np.maximum.at(most, where.reshape(-1), rank)
    row = row[(rank == most[where.reshape(-1)]) & (rank >= FEWEST_OF_SENSOR)]
    pairs = np.unique(of_sensor[row]) // sightings.n_sensors
    several, n_of = np.unique(pairs, return_counts=True)
    row = row[np.isin(piece[row], several[n_of > 1])]
    kept, n_of = np.unique(piece[row], return_counts=True)
    row = row[np.isin(piece[row], kept[n_of >= FEWEST_OF_PIECE])]
    row = row[np.argsort(piece[row], kind="stable")]
    number = np.unique(piece[row], return_inverse=True)[1].reshape(-1)
    owner = np.unique(whose[row], return_inverse=True)[1].reshape(-1)
    return Pieces(row, number, owner, length)


def equations_of(
    sightings: Sightings, pieces: Pieces, bias: FloatArray, weight: FloatArray
) -> Equations:
    """Return the equations about a bias, with reports weighed."""
    # Each piece's cubic is fitted with the biases and taken out of the equations (Schur's
    # complement): what is left tells of biases alone.
    row, piece = pieces.row, pieces.piece
    starts = np.flatnonzero(np.diff(piece, prepend=-1))
    time, place = (each[row] for each in sightings.corrected(bias))
    middle = np.add.reduceat(time, starts) / np.bincount(piece)
    when = (time - middle[piece]) / (pieces.length / 2.0)
    power = when[:, None] ** np.arange(N_POWERS)
    axes = sightings.axes(bias)[row]
    known = 1.0 / _variance(sightings, row)
    information = np.einsum("rki,rk,rkj->rij", axes, weight[:, None] * known, axes)
    apart = place - place[starts][piece]

    def taken_out(columns: FloatArray) -> FloatArray:
        """Return columns, (reports, 2, n), without what cubics explain, and the cubics."""
        sums = np.einsum("rk,rij,rjn->rkin", power, information, columns)
        total = np.add.reduceat(sums, starts).reshape(len(starts), 2 * N_POWERS, -1)
        return np.linalg.solve(cubic, total).reshape(len(starts), N_POWERS, 2, -1)

    cubic = np.einsum("rk,rl,rij->rkilj", power, power, information)
    cubic = np.add.reduceat(cubic, starts).reshape(len(starts), 2 * N_POWERS, 2 * N_POWERS)
    # Where all reports come at a few times, the highest powers are none of theirs.
    cubic += 1e-10 * np.einsum("pkk->p", cubic)[:, None, None] * np.eye(2 * N_POWERS)
    way = taken_out(apart[:, :, None])[..., 0]
    rising = np.arange(N_POWERS) * when[:, None] ** np.maximum(np.arange(N_POWERS) - 1, 0)
    velocity = np.einsum("rk,rki->ri", rising / (pieces.length / 2.0), way[piece])
    slope = np.zeros((row.size, 2, sightings.n_sensors, N_BIASES))
    every = np.arange(row.size)
    slope[every, :, sightings.sensor[row], :CLOCK] = sightings.slopes(bias)[row]
    slope[every, :, sightings.sensor[row], CLOCK] = -velocity
    slope = slope.reshape(row.size, 2, -1)
    left = slope - np.einsum("rk,rkin->rin", power, taken_out(slope)[piece])
    error = apart - np.einsum("rk,rki->ri", power, way[piece])
    weighed = np.einsum("rij,rj->ri", information, error)
    matrix = np.einsum("rin,rij,rjm->nm", left, information, left)
    off = np.einsum("rki,ri->rk", axes, error) * np.sqrt(known)
    own = np.maximum(np.bincount(sightings.sensor[row], minlength=sightings.n_sensors), 1)
    size = np.sqrt((slope**2).sum(axis=(0, 1)) / np.repeat(own, N_BIASES))
    return Equations(
        matrix, np.einsum("rin,ri->rn", left, weighed), np.linalg.norm(off, axis=1), size
    )


def weights_of(pieces: Pieces, off: FloatArray) -> tuple[FloatArray, float]:
    """Return how much each report counts, and how much farther off than they should most are."""
    scale = max(1.0, float(np.median(off)))
    off = off / scale
    count = np.bincount(pieces.piece)
    bent = np.sqrt(np.bincount(pieces.piece, np.minimum(off, WORST) ** 2) / count / 2.0)
    straight = np.minimum(1.0, (BENT / np.maximum(bent, 1e-9)) ** 2)
    weight = np.minimum(1.0, HUBER / np.maximum(off, 1e-9)) * straight[pieces.piece]
    return np.where(off > WORST, LEAST_WEIGHT, np.maximum(weight, LEAST_WEIGHT)), scale


def _variance(sightings: Sightings, row: IntArray) -> FloatArray:
    """Return the variance of each place along and across the line of sight [m²]."""
    sigma = sightings.track_sigma[sightings.track[row]]
    along = sigma[:, 0] * np.maximum(sightings.steepness[row], 1.0)
    return np.stack([along, sigma[:, 1] * sightings.distance[row]], axis=1) ** 2
