"""Several sensors' estimates of one object become one estimate."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from trackweave.arrays import (
    FloatArray,
    IntArray,
    float_array,
    int_array,
    require_finite,
    require_instance,
)
from trackweave.errors import InvalidInputError, NumericalError
from trackweave.fields import checked_count, settle
from trackweave.fusion._intersection import Locals, intersection_weights

__all__ = ["COMBINATIONS", "Combination", "SharedPrior", "combine"]

COMBINATIONS = (
    "convex",
    "covariance-intersection",
    "fast-covariance-intersection",
    "information-matrix",
)
"""Ways of combining estimates, by name."""
_CRITERIA = ("determinant", "trace")


@dataclass(frozen=True, slots=True, eq=False)
class SharedPrior:
    """What the local estimates have in common, so that it is not counted several times.

    The fused estimate and each local one, as they were predicted before they took the reports
    that are to be combined. With reports combined at every update this is the fused and the local
    estimate of the update before, predicted to now with the same process noise.

    Parameters
    ----------
    mean
        The fused estimate of each object beforehand, shape (objects, n).
    covariance
        Its covariance, shape (objects, n, n). Must be positive definite.
    local_mean
        Each local estimate beforehand, shape (rows, n).
    local_covariance
        Its covariance, shape (rows, n, n). Must be positive definite.

    Raises
    ------
    InvalidInputError
        If shapes do not fit or a covariance is not symmetric and positive definite.

    Examples
    --------
    >>> import numpy as np
    >>> import trackweave as tw
    >>> prior = tw.SharedPrior.common(mean=[0.0], covariance=[[4.0]], n_local=2)
    >>> mean, covariance = np.array([[1.0], [1.0]]), np.full((2, 1, 1), 2.0)
    >>> tw.combine(mean, covariance, "information-matrix", prior=prior)
    (array([1.33333333]), array([[1.33333333]]))
    """

    mean: FloatArray
    covariance: FloatArray
    local_mean: FloatArray
    local_covariance: FloatArray

    def __post_init__(self) -> None:
        fused = _estimates(self.mean, self.covariance, "prior")
        local = _estimates(self.local_mean, self.local_covariance, "prior, local")
        names = ("mean", "covariance", "local_mean", "local_covariance")
        for name, value in zip(names, (*fused, *local), strict=True):
            object.__setattr__(self, name, value)

    @classmethod
    def common(cls, mean: ArrayLike, covariance: ArrayLike, n_local: int) -> Self:
        """Return the prior of one object from which all of its local estimates began.

        Parameters
        ----------
        mean
            The common estimate, shape (n,).
        covariance
            Its covariance, shape (n, n).
        n_local
            Number k of local estimates.

        Returns
        -------
        The prior of one object.
        """
        n_local = checked_count(n_local, "n_local", 1)
        centre = float_array(mean, "prior, mean", (None,))
        spread = float_array(covariance, "prior, covariance", (centre.shape[0],) * 2)
        return cls(
            centre[None], spread[None],
            np.tile(centre, (n_local, 1)), np.tile(spread, (n_local, 1, 1)),
        )  # fmt: skip


@dataclass(frozen=True, slots=True)
class Combination:
    """How local estimates become one.

    - ``convex``: the sum of the information, exact where the errors of different sensors are
      independent, and over-confident where they are not.
    - ``covariance-intersection``: consistent whatever the correlation between sensors, with
      weights that make the result's ``criterion`` least. No sensor's estimate is counted twice.
    - ``fast-covariance-intersection``: consistent too, with weights in closed form [2]_, a little
      wider than the best.
    - ``information-matrix``: the prior plus what each sensor has *learned* since; needs
      `SharedPrior`, and is what a single filter with all reports would say where estimates are
      combined at every update.

    Parameters
    ----------
    method
        One of ``COMBINATIONS``.
    criterion
        What covariance intersection makes least: "determinant", which does not depend on units,
        or "trace", in which metres and metres per second are added as they are.

    Raises
    ------
    InvalidInputError
        If a name is unknown.

    References
    ----------
    .. [1] Julier, Uhlmann, *A non-divergent estimation algorithm in the presence of unknown
       correlations*, American Control Conference, 1997.
    .. [2] Franken, Hüpper, *Improved fast covariance intersection for distributed data fusion*,
       Fusion 2005.
    .. [3] Chong, Mori, Chang, *Distributed multitarget multisensor tracking*, 1990.

    Examples
    --------
    >>> import numpy as np
    >>> import trackweave as tw
    >>> mean = np.array([[0.0], [2.0]])  # two estimates of one number
    >>> covariance = np.array([[[1.0]], [[1.0]]])
    >>> tw.combine(mean, covariance, tw.Combination("covariance-intersection"))
    (array([1.]), array([[1.]]))
    """

    method: str = "convex"
    criterion: str = "determinant"

    def __post_init__(self) -> None:
        settle(self)
        if self.method not in COMBINATIONS:
            raise InvalidInputError(
                f"method: {self.method!r:.80}; expected one of {', '.join(COMBINATIONS)}"
            )
        if self.criterion not in _CRITERIA:
            raise InvalidInputError(
                f"criterion: {self.criterion!r:.80}; expected one of {', '.join(_CRITERIA)}"
            )

    def __call__(
        self,
        mean: ArrayLike,
        covariance: ArrayLike,
        start: ArrayLike,
        prior: SharedPrior | None = None,
    ) -> tuple[FloatArray, FloatArray]:
        """Return one estimate of each of many objects.

        Parameters
        ----------
        mean
            Local estimates, all of an object one after the other, shape (rows, n).
        covariance
            Their covariances, shape (rows, n, n). Must be symmetric and positive definite.
        start
            Where each object's estimates begin, and the number of rows last, shape
            (objects + 1,). Each object has at least one.
        prior
            What the local estimates share, for "information-matrix" only.

        Returns
        -------
        Mean and covariance of each object, shapes (objects, n) and (objects, n, n).

        Raises
        ------
        InvalidInputError
            If shapes do not fit, a covariance is not symmetric and positive definite, or a prior
            is missing.
        NumericalError
            If the prior claims to know more than the local estimates.
        """
        mean, covariance = _estimates(mean, covariance, "estimate")
        start = _segments(start, mean.shape[0])
        information = _inverse(covariance)
        vector = np.einsum("rij,rj->ri", information, mean)
        if self.method == "information-matrix":
            return _learned(information, vector, start, prior)
        if prior is not None:
            raise InvalidInputError(
                f"prior: given to {self.method}; expected none but for information-matrix"
            )
        if self.method != "convex":
            weight = self.weights(information, start)
            information, vector = weight[:, None, None] * information, weight[:, None] * vector
        return _solved(_sums(information, start), _sums(vector, start))

    def weights(self, information: FloatArray, start: IntArray) -> FloatArray:
        """Return the share of each local estimate in covariance intersection.

        Parameters
        ----------
        information
            Inverse covariances, shape (rows, n, n).
        start
            Where each object's begin, and the number of rows last, shape (objects + 1,).

        Returns
        -------
        Weights from 0 to 1 whose sum is 1 for each object, shape (rows,); ones where every
        estimate counts in full.
        """
        if self.method in {"convex", "information-matrix"}:
            return np.ones(information.shape[0])
        count = np.diff(start)
        total = _sums(information, start)
        root = 1.0 / np.sqrt(np.diagonal(total, axis1=1, axis2=2))
        scaled = information * np.repeat(root[:, :, None] * root[:, None, :], count, axis=0)
        if self.method == "covariance-intersection":
            weight = np.empty(information.shape[0])
            given = Locals(np.ascontiguousarray(scaled), start, root**2)
            intersection_weights(given, self.criterion == "trace", weight)
            return weight
        every = np.repeat(np.linalg.det(_sums(scaled, start)), count)
        others = np.linalg.det(np.repeat(_sums(scaled, start), count, axis=0) - scaled)
        part = every + np.linalg.det(scaled) - others
        return np.asarray(part / np.repeat(np.add.reduceat(part, start[:-1]), count))


def combine(
    mean: ArrayLike,
    covariance: ArrayLike,
    method: str | Combination = "convex",
    *,
    prior: SharedPrior | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Return what several sensors together know of one object.

    Parameters
    ----------
    mean
        Local estimates, shape (k, n), k at least 1.
    covariance
        Their covariances, shape (k, n, n). Must be symmetric and positive definite.
    method
        One of ``COMBINATIONS``, or a `Combination`, which says what each is good for.
    prior
        What the local estimates share, for "information-matrix" only; see `SharedPrior.common`.

    Returns
    -------
    Mean and covariance, shapes (n,) and (n, n).

    Examples
    --------
    >>> import numpy as np
    >>> import trackweave as tw
    >>> mean = np.array([[0.0], [2.0]])  # two estimates of one number
    >>> covariance = np.array([[[1.0]], [[3.0]]])
    >>> tw.combine(mean, covariance)  # errors taken to be independent
    (array([0.5]), array([[0.75]]))
    >>> tw.combine(mean, covariance, "fast-covariance-intersection")
    (array([0.2]), array([[1.2]]))
    """
    how = Combination(method) if isinstance(method, str) else method
    require_instance(how, Combination, "method")
    local = float_array(mean, "mean", (None, None))
    fused, spread = how(local, covariance, [0, local.shape[0]], prior)
    return fused[0], spread[0]


def _estimates(mean: ArrayLike, covariance: ArrayLike, name: str) -> tuple[FloatArray, FloatArray]:
    """Return checked means and covariances."""
    mean = float_array(mean, f"{name}, mean", (None, None))
    covariance = float_array(covariance, f"{name}, covariance", (*mean.shape, mean.shape[1]))
    require_finite(mean, f"{name}, mean")
    require_finite(covariance, f"{name}, covariance")
    size = np.abs(covariance).max(axis=(1, 2), initial=0.0)
    lopsided = np.abs(covariance - covariance.swapaxes(1, 2)).max(axis=(1, 2), initial=0.0)
    is_wrong = lopsided > 1e-9 * size
    if np.any(is_wrong):
        raise InvalidInputError(
            f"{name} {int(np.argmax(is_wrong))}, covariance: not symmetric; "
            "expected a symmetric matrix"
        )
    _inverse(covariance, name)
    return mean, covariance


def _segments(start: ArrayLike, n_rows: int) -> IntArray:
    start = int_array(start, "start", (None,))
    if start.shape[0] < 2 or start[0] != 0 or start[-1] != n_rows or np.any(np.diff(start) < 1):
        raise InvalidInputError(
            f"start: {start.tolist()!r:.80}; expected rising numbers from 0 to the number of "
            f"estimates, {n_rows}, at least one estimate for each object"
        )
    return start


def _sums(values: FloatArray, start: IntArray) -> FloatArray:
    return np.add.reduceat(values, start[:-1], axis=0)


def _inverse(matrix: FloatArray, name: str = "estimate") -> FloatArray:
    """Return the inverses of positive definite matrices, refusing others."""
    # Scaled to a diagonal of ones, as metres and metres per second may be worlds apart.
    diagonal = np.diagonal(matrix, axis1=1, axis2=2)
    is_odd = ~(diagonal > 0.0).all(axis=1)
    root = 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
    scale = root[:, :, None] * root[:, None, :]
    try:
        np.linalg.cholesky(matrix * scale)
    except np.linalg.LinAlgError:
        is_odd |= np.linalg.eigvalsh(matrix * scale)[:, 0] <= 1e-14
    if np.any(is_odd):
        raise InvalidInputError(
            f"{name} {int(np.argmax(is_odd))}, covariance: not positive definite; "
            "expected a positive definite matrix"
        )
    inverse = np.linalg.inv(matrix * scale) * scale
    return np.asarray((inverse + inverse.swapaxes(1, 2)) / 2.0)


def _solved(information: FloatArray, vector: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the estimates that have this information."""
    covariance = _inverse(information)
    return np.einsum("rij,rj->ri", covariance, vector), covariance


def _learned(
    information: FloatArray, vector: FloatArray, start: IntArray, prior: SharedPrior | None
) -> tuple[FloatArray, FloatArray]:
    """Return the prior and what every local estimate learned beyond its own."""
    if prior is None:
        raise InvalidInputError(
            "prior: none; expected a SharedPrior: information-matrix takes off what the local "
            "estimates share"
        )
    if prior.local_mean.shape != vector.shape or prior.mean.shape != (
        start.shape[0] - 1, vector.shape[1],
    ):  # fmt: skip
        raise InvalidInputError(
            f"prior: {prior.mean.shape[0]} objects and {prior.local_mean.shape[0]} local "
            f"estimates of {prior.mean.shape[1]} numbers; expected {start.shape[0] - 1} and "
            f"{vector.shape[0]} of {vector.shape[1]}"
        )
    before = _inverse(prior.local_covariance)
    known = _inverse(prior.covariance)
    total = known + _sums(information - before, start)
    vectors = np.einsum("rij,rj->ri", known, prior.mean)
    vectors += _sums(vector - np.einsum("rij,rj->ri", before, prior.local_mean), start)
    try:
        return _solved(total, vectors)
    except InvalidInputError as err:
        raise NumericalError(
            "prior: it leaves no information; expected local estimates that know more than the "
            "prior that they share"
        ) from err
