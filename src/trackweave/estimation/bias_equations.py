"""What reports of common objects say of sensors' biases: normal equations, object by object."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.estimation.sightings import CLOCK, N_BIASES, Sightings

__all__ = ["Equations", "Pieces", "equations_of", "feigned_of", "pieces_of", "weights_of"]

# An object's way in a piece of so many slowest periods is a cubic.
PIECE, N_POWERS = 4.0, 4
# A sensor tells something of a piece with so many reports, and so many are more than a cubic has.
FEWEST_OF_SENSOR, FEWEST_OF_PIECE = 2, N_POWERS + 2
# Reports count less beyond so many deviations, not at all beyond so many; pieces, as in turns
# that no cubic follows, where their reports lie so many times as far off as they should.
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


def pieces_of(sightings: Sightings, objects: IntArray, longer: float = 1.0) -> Pieces:
    """Return what at least two sensors saw of an object in a piece of time."""
    # Pieces are so many times as ``longer`` as usual.
    length = longer * PIECE * float(sightings.period.max())
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


class _Cubics:
    """The ways of objects in pieces, and how they follow from their reports."""

    def __init__(
        self, sightings: Sightings, pieces: Pieces, bias: FloatArray, weight: FloatArray
    ) -> None:
        row, self.piece = pieces.row, pieces.piece
        self.starts = np.flatnonzero(np.diff(self.piece, prepend=-1))
        time, place = (each[row] for each in sightings.corrected(bias))
        middle = np.add.reduceat(time, self.starts) / np.bincount(self.piece)
        half = pieces.length / 2.0
        when = (time - middle[self.piece])[:, None] / half
        order = np.arange(N_POWERS)
        self.power = when**order
        self.rising = order * when ** np.maximum(order - 1, 0) / half
        self.axes, self.known = sightings.axes(bias)[row], 1.0 / _variance(sightings, row)
        known = weight[:, None] * self.known
        self.information = np.einsum("rki,rk,rkj->rij", self.axes, known, self.axes)
        matrix = np.einsum("rk,rl,rij->rkilj", self.power, self.power, self.information)
        self.matrix = self._sums(matrix).reshape(-1, 2 * N_POWERS, 2 * N_POWERS)
        # Where all reports come at a few times, the highest powers are none of theirs.
        slight = 1e-10 * np.einsum("pkk->p", self.matrix)
        self.matrix += slight[:, None, None] * np.eye(2 * N_POWERS)
        self.apart = place - place[self.starts][self.piece]
        self.way = self.ways(self.apart[:, :, None])[..., 0]
        self.velocity = np.einsum("rk,rki->ri", self.rising, self.way[self.piece])

    def ways(self, columns: FloatArray) -> FloatArray:
        """Return the cubics through columns, (reports, 2, n), as (pieces, powers, 2, n)."""
        total = self.against(columns)
        return np.asarray(np.linalg.solve(self.matrix, total)).reshape(len(total), N_POWERS, 2, -1)

    def against(self, columns: FloatArray) -> FloatArray:
        """Return the right sides of the cubics through columns, (pieces, 2 powers, n)."""
        sums = np.einsum("rk,rij,rjn->rkin", self.power, self.information, columns)
        return self._sums(sums).reshape(len(self.starts), 2 * N_POWERS, -1)

    def without(self, columns: FloatArray) -> FloatArray:
        """Return columns without the cubics through them."""
        ways = self.ways(columns)[self.piece]
        return np.asarray(columns - np.einsum("rk,rkin->rin", self.power, ways))

    def _sums(self, values: FloatArray) -> FloatArray:
        return np.asarray(np.add.reduceat(values, self.starts))


def equations_of(
    sightings: Sightings, pieces: Pieces, bias: FloatArray, weight: FloatArray
) -> Equations:
    """Return the equations about a bias, with reports weighed."""
    # Each piece's cubic is fitted with the biases and taken out of the equations (Schur's
    # complement): what is left tells of biases alone.
    cubics = _Cubics(sightings, pieces, bias, weight)
    row, every = pieces.row, np.arange(pieces.row.size)
    of = sightings.sensor[row]
    slope = np.zeros((row.size, 2, sightings.n_sensors, N_BIASES))
    slope[every, :, of, :CLOCK] = sightings.slopes(bias)[row]
    slope[every, :, of, CLOCK] = -cubics.velocity
    moved = slope.reshape(row.size, 2, -1)
    left, error = cubics.without(moved), cubics.without(cubics.apart[:, :, None])[..., 0]
    weighed = np.einsum("rij,rj->ri", cubics.information, error)
    matrix = np.einsum("rin,rij,rjm->nm", left, cubics.information, left, optimize=True)
    off = np.einsum("rki,ri->rk", cubics.axes, error) * np.sqrt(cubics.known)
    own = np.maximum(np.bincount(of, minlength=sightings.n_sensors), 1)
    size = np.sqrt((moved**2).sum(axis=(0, 1)) / np.repeat(own, N_BIASES))
    score = np.einsum("rin,ri->rn", left, weighed)
    return Equations(matrix, score, np.linalg.norm(off, axis=1), size)


def feigned_of(
    sightings: Sightings, pieces: Pieces, bias: FloatArray, equations: Equations
) -> FloatArray:
    """Return the share of what seems to tell of each clock that is noise of velocities."""
    # A cubic's velocity is wrong by its noise; a sensor's reports times that, without what cubics
    # explain, would be taken for what a clock does to them.
    weight = weights_of(pieces, equations.off)[0]
    cubics = _Cubics(sightings, pieces, bias, weight)
    of, size = sightings.sensor[pieces.row], 2 * N_POWERS
    lever = np.einsum("rk,ij->rikj", cubics.rising, np.eye(2)).reshape(-1, 2, size)
    spread = np.linalg.inv(cubics.matrix)
    noise = np.zeros(sightings.n_sensors)
    for sensor in range(sightings.n_sensors):
        own = np.where((of == sensor)[:, None, None], lever, 0.0)
        gain = np.einsum("rin,rij,rjm->rnm", own, cubics.information, own, optimize=True)
        total = cubics.against(own)
        gain = np.add.reduceat(gain, cubics.starts) - total.swapaxes(1, 2) @ spread @ total
        noise[sensor] = np.einsum("pnm,pmn->", gain, spread)
    told = np.diagonal(equations.matrix)[CLOCK::N_BIASES]
    return np.asarray(noise / np.maximum(told, 1e-300))


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
