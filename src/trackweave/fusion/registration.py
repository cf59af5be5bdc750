"""How a sensor's picture is shifted, turned and late, told from the tracks that it shares."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from trackweave.arrays import (
    FloatArray,
    IntArray,
    float_array,
    int_array,
    require_instance,
)
from trackweave.errors import InvalidInputError
from trackweave.fields import checked_members, checked_number
from trackweave.fusion.bias import BIASES, BiasModel
from trackweave.fusion.bias_fit import (
    BiasFit,
    Differences,
    NotObservableError,
    differences,
    fit_bias,
)
from trackweave.fusion.constellation import guess_bias
from trackweave.fusion.learning import Learned, learned
from trackweave.fusion.matching import match_tracks, unbiased
from trackweave.fusion.pictures import LocalPicture

__all__ = ["Registration", "register"]

_ROUNDS = 8
"""Times that matching and estimating take turns at most."""
_SAME, _APART, _FEWEST = 0.01, 5, 6
"""Pictures of the same time differ by less than this part of a gap; others are compared every so
many, while so many remain."""

Pictures = Sequence[LocalPicture]


@dataclass(frozen=True, slots=True, eq=False)
class Registration:
    """What is wrong with a sensor beside a reference, how certain that is, and how to undo it.

    Parameters
    ----------
    reference, sensor
        Names of the sensors.
    model
        What was taken to be wrong.
    bias
        The numbers in the order of `names` [m, rad, s], 0 where not estimated.
    covariance
        Their covariance, 0 where not estimated.
    pairs
        Numbers of the tracks of the reference and of the sensor that it rests on, shape
        (pairs, 2).
    used
        Share of each pair's times that count: 0 for a pair that contradicts the others.
    scale
        Factor on the covariance that the tracks turned out to need, beside what their own
        covariances say: about 1 where these are right.

    Examples
    --------
    >>> import numpy as np
    >>> import trackweave as tw
    >>> state = [[100.0, 50.0, 10.0, 0.0]]  # x, y [m], vx, vy [m/s]
    >>> spread = np.diag([25.0, 25.0, 1.0, 1.0])[None]
    >>> model = tw.BiasModel(estimate=("translation",))
    >>> known = tw.Registration(
    ...     "A", "B", model, np.array([5.0, 0.0, 0.0, 0.0, 0.0, 0.0]), np.zeros((6, 6)),
    ...     np.array([[1, 1]]), np.ones(1), 1.0,
    ... )
    >>> known.apply(tw.LocalPicture("B", 0.0, [1], state, spread)).mean  # 5 m less
    array([[95., 50., 10.,  0.]])
    """

    reference: str
    sensor: str
    model: BiasModel
    bias: FloatArray
    covariance: FloatArray
    pairs: IntArray
    used: FloatArray
    scale: float

    @property
    def dim(self) -> int:
        """Number of spatial dimensions, 2 or 3."""
        return int(self.bias.shape[0]) - len(BIASES) + 1

    @property
    def names(self) -> tuple[str, ...]:
        """What each number of the bias is."""
        return self.model.names(self.dim)

    @property
    def sigma(self) -> FloatArray:
        """Standard deviation of each number of the bias."""
        return np.sqrt(np.diagonal(self.covariance))

    @property
    def translation(self) -> FloatArray:
        """How far the sensor's picture is moved [m], shape (dim,)."""
        return self.bias[: self.dim]

    @property
    def rotation(self) -> float:
        """How far the sensor's picture is turned about the sensor [rad, clockwise from above]."""
        return float(self.bias[self.dim])

    @property
    def range_bias(self) -> float:
        """How much too long the sensor's ranges are [m]."""
        return float(self.bias[self.dim + 1])

    @property
    def azimuth_bias(self) -> float:
        """How much too great the sensor's azimuths are [rad]."""
        return float(self.bias[self.dim + 2])

    @property
    def clock_offset(self) -> float:
        """How far the sensor's clock is ahead [s]."""
        return float(self.bias[self.dim + 3])

    def apply(self, picture: LocalPicture) -> LocalPicture:
        """Return a picture of the sensor as it would be without its bias.

        States are those at the picture's time by the reference's clock. Covariances grow by what
        is not known of the bias; that part of the error is common to all tracks of the sensor.

        Parameters
        ----------
        picture
            A picture of the sensor, as it came.

        Returns
        -------
        The same tracks at the same time.

        Raises
        ------
        InvalidInputError
            If the picture is another sensor's or has other dimensions.
        """
        require_instance(picture, LocalPicture, "picture")
        if picture.sensor != self.sensor or picture.dim != self.dim:
            raise InvalidInputError(
                f"picture: of sensor {picture.sensor} in {picture.dim} dimensions; expected "
                f"sensor {self.sensor} in {self.dim}"
            )
        return unbiased(picture, self.model, self.bias, self.covariance)


def register(
    reference: Pictures,
    other: Pictures,
    *,
    process_noise: float,
    model: BiasModel | None = None,
    pairs: ArrayLike | None = None,
) -> Registration:
    """Return what is wrong with a sensor beside a reference, from the tracks of the same objects.

    Every track is taken apart into what it learned between one picture and the next, since errors
    of successive estimates are correlated; the differences of what both tracks of a pair learned
    are explained by a bias, by iterated weighted least squares that wrong pairs do not disturb.
    Its covariance is widened by how far the differences vary more than they should.

    Parameters
    ----------
    reference
        Pictures of the reference, in the order of time.
    other
        Pictures of the sensor, in the order of time, as they came. Where times differ, the
        sensor with more pictures is predicted to the times of the other, and of these every fifth
        is compared: what both learned in between has directions in common then.
    process_noise
        Power spectral density of the acceleration that the sensors' trackers assume [m²/s³].
        Where it is not known, rather too small than too great: 0 costs little and stays
        consistent, while after ten times too much errors are a third greater than stated.
    model
        What may be wrong; left out, a translation, a rotation and a clock offset.
    pairs
        Numbers of tracks of the reference and of the sensor that are one object, shape (pairs, 2),
        or (pairs, 3) with the probability of each. Some may be wrong. Left out, they are found:
        a first guess of the bias from the pattern of tracks at one time, then pairs and bias by
        turns.

    Returns
    -------
    The bias of the sensor, with its covariance.

    Raises
    ------
    InvalidInputError
        If pictures are not of two sensors in the order of time, their times do not overlap, or a
        pair names a track that is in no picture.
    NotObservableError
        If the tracks do not tell a bias, or one from another; the message says which.

    Examples
    --------
    >>> import numpy as np
    >>> import trackweave as tw
    >>> def pictures(name, shift):
    ...     state = np.array([[0.0, 0.0, 10.0, 0.0], [900.0, 400.0, 0.0, -8.0]])  # m, m/s
    ...     spread = np.tile(np.diag([25.0, 25.0, 1.0, 1.0]), (2, 1, 1))
    ...     for time in range(5):
    ...         mean = state + [shift, 0.0, 0.0, 0.0]
    ...         mean[:, :2] += time * state[:, 2:]
    ...         yield tw.LocalPicture(name, time, [1, 2], mean, spread)
    ...
    >>> found = tw.register(
    ...     list(pictures("A", 0.0)), list(pictures("B", 60.0)), process_noise=0.1,
    ...     model=tw.BiasModel(estimate=("translation",)), pairs=[[1, 1], [2, 2]],
    ... )
    >>> round(float(found.bias[0]))  # x [m]
    60
    """
    model = BiasModel() if model is None else model
    require_instance(model, BiasModel, "model")
    process_noise = checked_number(process_noise, "process_noise", "a number ≥ 0 [m²/s³]")
    if process_noise < 0.0:
        raise InvalidInputError(
            f"process_noise: {process_noise!r:.80}; expected a number ≥ 0 [m²/s³]"
        )
    reference = checked_members(reference, LocalPicture, "reference")
    other = checked_members(other, LocalPicture, "other")
    _require_pictures(reference, other)
    reference, other = _at_common_times(reference, other, process_noise)
    facts = learned(reference, process_noise), learned(other, process_noise)
    if pairs is None:
        chosen, start = _found(reference, other, facts, model)
        trust = np.ones(chosen.shape[0])
    else:
        chosen, trust = _given(pairs, facts)
        start = np.zeros(reference[0].dim + len(BIASES) - 1)
    fit = fit_bias(_rows(facts, chosen, trust), model, start, check=True)
    return Registration(
        reference[0].sensor, other[0].sensor, model, fit.bias, fit.covariance, chosen, fit.used,
        fit.scale,
    )  # fmt: skip


def _rows(facts: tuple[Learned, Learned], pairs: IntArray, trust: FloatArray) -> Differences:
    """Return the differences of pairs, refusing to tell anything from none."""
    rows = differences(*facts, pairs, trust)
    if not rows.pair.size:
        raise NotObservableError(
            f"registration: {pairs.shape[0]} pairs of tracks, none of them there at one time; "
            "expected tracks of one object, seen by both sensors at the same times"
        )
    return rows


def _found(
    reference: Pictures, other: Pictures, facts: tuple[Learned, Learned], model: BiasModel
) -> tuple[IntArray, FloatArray]:
    """Return the pairs that agree best with each other, and the bias that they tell."""
    common = [min(len(first), len(second)) for first, second in zip(reference, other, strict=True)]
    # The last of the times with most tracks: estimates are best there.
    time = len(common) - 1 - int(np.argmax(common[::-1]))
    guess = guess_bias(reference[time], other[time], model)
    if guess is None:
        raise NotObservableError(
            f"registration: the tracks of {other[0].sensor} show no pattern of those of "
            f"{reference[0].sensor} ({len(other[time])} and {len(reference[time])} tracks at "
            f"{reference[time].time:g} s); expected at least three objects that both see, or pairs"
        )
    fit = BiasFit(guess.bias, guess.covariance, np.empty(0), 1.0)
    pairs = np.empty((0, 2), dtype=np.int64)
    for _ in range(_ROUNDS):
        moved = [unbiased(picture, model, fit.bias, fit.covariance) for picture in other]
        again = match_tracks(reference, moved)
        if np.array_equal(again, pairs):
            break
        pairs = again
        fit = fit_bias(_rows(facts, pairs, np.ones(pairs.shape[0])), model, fit.bias, check=False)
    return pairs, fit.bias


def _given(pairs: ArrayLike, facts: tuple[Learned, Learned]) -> tuple[IntArray, FloatArray]:
    """Return checked pairs and their probabilities."""
    values = float_array(pairs, "pairs", (None, None))
    if values.shape[1] not in {2, 3}:
        raise InvalidInputError(
            f"pairs: {values.shape[1]} columns; expected two track numbers[, a probability]"
        )
    numbers = int_array(values[:, :2], "pairs", (None, 2))
    trust = values[:, 2] if values.shape[1] == 3 else np.ones(values.shape[0])
    if not np.all((trust >= 0.0) & (trust <= 1.0)):
        raise InvalidInputError("pairs: a third column beyond 0 to 1; expected probabilities")
    for column, (table, name) in enumerate(zip(facts, ("reference", "sensor"), strict=True)):
        unknown = ~np.isin(numbers[:, column], table.track)
        if np.any(unknown):
            raise InvalidInputError(
                f"pairs, row {int(np.argmax(unknown))}: track {numbers[unknown, column][0]}; "
                f"expected a track of the {name} at a time of both"
            )
    return numbers, np.ascontiguousarray(trust)


def _require_pictures(reference: Pictures, other: Pictures) -> None:
    """Refuse what are not pictures of two sensors in the order of time."""
    for pictures, name in ((reference, "reference"), (other, "other")):
        if not len(pictures):
            raise InvalidInputError(f"{name}: no pictures; expected at least one")
        for picture in pictures:
            require_instance(picture, LocalPicture, name)
        if len({picture.sensor for picture in pictures}) > 1:
            raise InvalidInputError(f"{name}: pictures of several sensors; expected one's")
        if np.any(np.diff([picture.time for picture in pictures]) <= 0.0):
            raise InvalidInputError(f"{name}: times that do not rise; expected rising times")
    if reference[0].sensor == other[0].sensor:
        raise InvalidInputError(
            f"other: pictures of {other[0].sensor}, the reference itself; expected another sensor"
        )
    if len({picture.dim for picture in [*reference, *other]}) > 1:
        raise InvalidInputError("pictures: in 2 and in 3 dimensions; expected one of both")


def _at_common_times(
    reference: Pictures, other: Pictures, process_noise: float
) -> tuple[Pictures, Pictures]:
    """Return pictures of the same times: those of the sensor that has fewer."""
    few, many = (reference, other) if len(reference) <= len(other) else (other, reference)
    times = np.array([picture.time for picture in many])
    latest = np.searchsorted(times, [picture.time for picture in few], side="right") - 1
    # Far beyond the last picture nothing is learned, and prediction would make up the rest.
    gap = float(np.max(np.diff(times), initial=0.0))
    kept = [
        (picture, many[k].predicted(picture.time, process_noise))
        for picture, k in zip(few, latest, strict=True)
        if k >= 0 and picture.time - times[k] <= gap
    ]
    if not kept:
        raise InvalidInputError(
            f"times: {reference[0].sensor} from {reference[0].time:g} to {reference[-1].time:g} s,"
            f" {other[0].sensor} from {other[0].time:g} to {other[-1].time:g} s; expected times "
            "that overlap"
        )
    waits = [picture.time - times[k] for picture, k in zip(few, latest, strict=True) if k >= 0]
    if np.median(waits) > _SAME * gap and len(many) < 2 * len(few):
        # One report of each, at times that differ, tell of no common direction; several do.
        apart = min(_APART, max(len(kept) // _FEWEST, 1))
        kept = kept[::-1][::apart][::-1]
    first, second = [pair[0] for pair in kept], [pair[1] for pair in kept]
    return (first, second) if few is reference else (second, first)
