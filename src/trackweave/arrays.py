"""The one place that casts and checks arrays and plain values that come from outside."""

from collections.abc import Sequence
from math import isfinite
from numbers import Integral, Real

import numpy as np
from numpy.typing import ArrayLike, NDArray

from trackweave.errors import InvalidInputError

__all__ = [
    "ROUNDING",
    "FloatArray",
    "IntArray",
    "covariance_array",
    "float_array",
    "int_array",
    "is_number",
    "is_whole",
    "n_axes",
    "name_text",
    "require_finite",
    "require_instance",
]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
_OTHERS = "cmM"
"""NumPy would drop imaginary parts, and count the nanoseconds of dates."""

ROUNDING = 1e-12
"""By how much of itself a variance grows where matrices of 16 digits may have lost some of it."""


def float_array(values: ArrayLike, name: str, shape: Sequence[int | None]) -> FloatArray:
    """Return numbers as a contiguous float64 array of the expected shape, or refuse them."""
    # The input itself when it already is one. Any length will do along an axis of None; ``name``
    # is what the message calls the values.
    try:
        raw = np.asarray(values)
        array = np.ascontiguousarray([] if raw.dtype.kind in _OTHERS else raw, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as err:
        raise InvalidInputError(f"{name}: {values!r:.80}; expected numbers") from err
    if raw.dtype.kind in _OTHERS:
        raise InvalidInputError(f"{name}: {values!r:.80}; expected numbers, not {raw.dtype}")
    # ascontiguousarray turns a scalar into one dimension, which a shape of () must not hide.
    _require_shape(array if np.ndim(values) else array.reshape(()), name, shape)
    return array


def n_axes(values: ArrayLike, name: str) -> int:
    """Return the number of axes of values as an array; refuse rows that differ in length."""
    try:
        return np.ndim(values)
    except ValueError as err:
        raise InvalidInputError(
            f"{name}: {values!r:.80}; rows of several lengths; expected an array"
        ) from err


def int_array(values: ArrayLike, name: str, shape: Sequence[int | None]) -> IntArray:
    """Return whole numbers as a contiguous int64 array of the expected shape, or refuse them."""
    # Floats are taken when they are whole.
    try:
        raw = np.asarray(values)
    except ValueError as err:
        raise InvalidInputError(
            f"{name}: {values!r:.80}; expected whole numbers, and rows of one length"
        ) from err
    if raw.size == 0:
        raw = raw.astype(np.int64)
    fits = raw.dtype.kind == "i"
    if raw.dtype.kind in "fu":
        fits = bool(np.all((raw >= -(2.0**63)) & (raw < 2.0**63) & (raw == np.floor(raw))))
    if not fits:
        raise InvalidInputError(f"{name}: {values!r:.80}; expected whole numbers")
    _require_shape(raw, name, shape)
    return np.ascontiguousarray(raw, dtype=np.int64)


def require_finite(array: FloatArray, name: str) -> None:
    """Refuse NaN and infinity, naming the first place."""
    bad = np.argwhere(~np.isfinite(array))
    if bad.size:
        place = tuple(int(index) for index in bad[0])
        raise InvalidInputError(f"{name}{list(place)}: {array[place]}; expected a finite number")


def covariance_array(values: ArrayLike, name: str, shape: Sequence[int | None]) -> FloatArray:
    """Return symmetric, positive definite matrices, exactly symmetric, or refuse them."""
    matrices = float_array(values, name, shape)
    require_finite(matrices, name)
    turned = matrices.swapaxes(1, 2)
    scale = np.sqrt(np.abs(np.einsum("kii->ki", matrices)))
    limit = 1e-9 * scale[:, :, None] * scale[:, None, :]
    if np.any(np.abs(matrices - turned) > limit) or not _is_definite(matrices):
        raise InvalidInputError(f"{name}: expected symmetric positive definite matrices")
    symmetric: FloatArray = (matrices + turned) / 2
    return symmetric


def _is_definite(matrices: FloatArray) -> bool:
    """Tell whether all matrices are positive definite."""
    try:
        np.linalg.cholesky(matrices)
    except np.linalg.LinAlgError:
        return False
    return True


def is_number(value: object) -> bool:
    """Tell whether a value is one finite number; True and False are none."""
    # An integer beyond all floats counts as infinite.
    try:
        return not isinstance(value, bool) and isinstance(value, Real) and isfinite(value)
    except OverflowError:
        return False


def is_whole(value: object) -> bool:
    """Tell whether a value is one whole number of an integer type; True and False are none."""
    return isinstance(value, Integral) and not isinstance(value, bool)


def name_text(value: object, name: str) -> str:
    """Return a name, which may be text or a whole number, as text: 0 and "0" are one name."""
    if not isinstance(value, str) and not is_whole(value):
        raise InvalidInputError(f"{name}: {value!r:.80}; expected a text or a whole number")
    return str(value)


def require_instance(value: object, kind: type, name: str) -> None:
    """Refuse a value that is no instance of a class."""
    if not isinstance(value, kind):
        raise InvalidInputError(f"{name}: {value!r:.80}; expected an instance of {kind.__name__}")


def _require_shape(array: NDArray[np.generic], name: str, shape: Sequence[int | None]) -> None:
    fits = array.ndim == len(shape) and all(
        wanted is None or wanted == came for wanted, came in zip(shape, array.shape, strict=True)
    )
    if not fits:
        wanted_text = ", ".join("any" if n is None else str(n) for n in shape)
        raise InvalidInputError(
            f"{name}: an array of shape {array.shape}; expected shape ({wanted_text})"
        )
