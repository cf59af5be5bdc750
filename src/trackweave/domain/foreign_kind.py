"""Kinds of measurement from outside the package: what they offer, and what stands for them."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np

from trackweave.arrays import FloatArray, float_array
from trackweave.domain.measurements import MeasurementKind
from trackweave.errors import InvalidInputError
from trackweave.plugin_faults import told_as_theirs

__all__ = [
    "FOREIGN",
    "ForeignKind",
    "Measurement",
    "Reported",
    "kind_of",
    "ours",
    "shaped",
    "slope_of",
]

FINE = 1e-5
"""How far apart, as a share of a number and one, differences stand for derivatives."""
FOREIGN = 99
"""What kernels read as the kind of reports whose kind they do not know."""


class Reported(NamedTuple):
    """Reports of a kind from outside, a row each.

    ``values`` are the numbers of the kind's ``columns`` and ``sigma`` their standard deviations,
    shape (reports, m); ``context`` the numbers of its ``context``, shape (reports, k), NaN where a
    cell is empty; ``covariance`` that of the values' errors, shape (reports, m, m).

    Examples
    --------
    >>> import numpy as np
    >>> import trackweave as tw
    >>> values, sigma = np.array([[120.0], [80.0]]), np.full((2, 1), 2.0)  # m
    >>> reported = tw.Reported(values, sigma, np.zeros((2, 0)), sigma[:, :, None] ** 2)
    >>> reported.part(np.array([1])).values
    array([[80.]])
    """

    values: FloatArray
    sigma: FloatArray
    context: FloatArray
    covariance: FloatArray

    def part(self, rows: Any) -> "Reported":
        """Return some rows."""
        return Reported(*(np.ascontiguousarray(column[rows]) for column in self))


class Measurement(Protocol):
    """A kind of measurement: one class, best a frozen dataclass, whose fields are its keys.

    ``columns`` name the numbers of a report as in the reports file; all of them are read in the
    units of the file. Everything is for many rows at once.

    It may also have: ``context``, names of further columns of each report that it needs, of which
    cells may be empty; ``dim``, the number of dimensions of the tracking space that it is for;
    ``covariance(reported)``, the covariance of the errors, shape (rows, m, m), where they depend
    on one another; ``difference(values, expected)``, the first minus the second where that is no
    plain difference, as for angles; and ``first_state(platform, reported)``, the positions [m],
    shape (rows, dim), and covariances, shape (rows, dim, dim), at which reports put their
    objects: without it reports update tracks and begin none.

    Examples
    --------
    >>> import numpy as np
    >>> import trackweave as tw
    >>> class Height:
    ...     columns = ("height",)
    ...
    ...     def expect(self, mean, platform, reported):
    ...         slope = np.zeros((len(mean), 1, mean.shape[1]))
    ...         slope[:, 0, 2] = 1.0
    ...         return mean[:, 2:3], slope
    ...
    >>> altimeter = tw.Sensor("altimeter", sigma=5.0, measurement=Height())  # m
    >>> altimeter.sigmas(3)
    array([5.])
    """

    columns: tuple[str, ...]

    def expect(
        self, mean: FloatArray, platform: FloatArray, reported: Reported
    ) -> tuple[FloatArray, FloatArray]:
        """Return what a sensor without noise measures of states, and how that changes with them.

        Parameters
        ----------
        mean
            States, shape (rows, size): position [m], velocity [m/s], then whatever else.
        platform
            Where each report's sensor was, x, y, z [m] and their rates [m/s], shape (rows, 6).
        reported
            The reports.

        Returns
        -------
        Values, shape (rows, m), and their derivatives by the state, shape (rows, m, size).
        """
        ...


@dataclass(frozen=True, slots=True)
class ForeignKind:
    """What stands for a kind of measurement from outside, beside our own `MeasurementKind`.

    Parameters
    ----------
    model
        The kind itself.
    word
        Its name in configuration files; left out = the name of its class.

    Raises
    ------
    InvalidInputError
        If something is missing of what a kind has to offer.
    """

    model: Any
    word: str = ""

    def __post_init__(self) -> None:
        name = type(self.model).__name__
        object.__setattr__(self, "word", self.word or name)
        columns = getattr(self.model, "columns", None)
        if not _are_names(columns) or not columns:
            raise InvalidInputError(
                f"measurement {name}: columns {columns!r:.60}; expected the names of its numbers, "
                "such as ('range_m', 'azimuth_deg')"
            )
        if not _are_names(self.context):
            raise InvalidInputError(
                f"measurement {name}: context {self.context!r:.60}; expected names of columns"
            )
        if not callable(getattr(self.model, "expect", None)):
            raise InvalidInputError(
                f"measurement {name}: no method expect; expected "
                "expect(mean, platform, reported), which returns values and their slope"
            )
        if self.dim not in (None, 2, 3):
            raise InvalidInputError(f"measurement {name}: dim {self.dim!r:.60}; expected 2 or 3")

    def __int__(self) -> int:
        return FOREIGN

    @property
    def context(self) -> tuple[str, ...]:
        """Names of further columns of its reports."""
        names: tuple[str, ...] = getattr(self.model, "context", ())
        return names

    @property
    def dim(self) -> int | None:
        """Number of dimensions of the tracking space that it is for; None for any."""
        dim: int | None = getattr(self.model, "dim", None)
        return dim

    @property
    def has_own_covariance(self) -> bool:
        """Whether it knows its reports' errors by itself."""
        return callable(getattr(self.model, "covariance", None))

    @property
    def is_position(self) -> bool:
        """Whether the numbers are a place, as far as is known."""
        return False

    @property
    def is_bearing_only(self) -> bool:
        """Whether the numbers tell a direction and no distance, as far as is known."""
        return False

    @property
    def needs_place(self) -> bool:
        """Whether the numbers count from where the sensor stands, as far as is known."""
        return False

    @property
    def azimuth(self) -> int | None:
        """Which of the numbers is the azimuth: none, as far as is known."""
        return None

    @property
    def has_range(self) -> bool:
        """Whether the first component is a range, as far as is known."""
        return False

    @property
    def has_elevation(self) -> bool:
        """Whether the tracking space needs three dimensions."""
        return self.dim == 3

    @property
    def has_rate(self) -> bool:
        """Whether the last component is a range rate, as far as is known."""
        return False

    def n_components(self, dim: int) -> int:
        """Return how many numbers a report holds."""
        return len(self.model.columns)

    def columns(self, dim: int) -> tuple[str, ...]:
        """Return the names of a report's numbers in files."""
        return tuple(self.model.columns)

    def gives_position(self, dim: int) -> bool:
        """Tell whether one report says where its object is."""
        return callable(getattr(self.model, "first_state", None))

    def reported(
        self, values: FloatArray, sigma: FloatArray, context: FloatArray | None,
        covariance: FloatArray | None = None,
    ) -> Reported:  # fmt: skip
        """Return reports as the kind gets them, with its own covariance where none is given."""
        count, size = values.shape
        if context is None:
            context = np.empty((count, 0 if count else len(self.context)))
        if context.shape != (count, len(self.context)):
            raise InvalidInputError(
                f"measurement {self.word}: context of shape {context.shape}; expected "
                f"{(count, len(self.context))}, the columns {', '.join(self.context) or 'none'}"
            )
        plain = Reported(values, sigma, context, sigma[:, :, None] ** 2 * np.eye(size))
        if covariance is None and self.has_own_covariance:
            covariance = self._called("covariance", [(count, size, size)], plain)[0]
        return plain if covariance is None else plain._replace(covariance=covariance)

    def expect(
        self, mean: FloatArray, platform: FloatArray, reported: Reported
    ) -> tuple[FloatArray, FloatArray]:
        """Return what is expected of reports, and its slope; see `Measurement`."""
        rows, size = mean.shape
        width = len(self.model.columns)
        shapes = [(rows, width), (rows, width, size)]
        value, slope = self._called("expect", shapes, mean, platform, reported)
        return value, slope

    def difference(self, values: FloatArray, expected: FloatArray) -> FloatArray:
        """Return measurements minus what was expected."""
        if not callable(getattr(self.model, "difference", None)):
            return values - expected
        return self._called("difference", [values.shape], values, expected)[0]

    def first_state(
        self, platform: FloatArray, reported: Reported, dim: int
    ) -> tuple[FloatArray, FloatArray]:
        """Return where reports put their objects, and how surely."""
        count = reported.values.shape[0]
        shapes = [(count, dim), (count, dim, dim)]
        place, spread = self._called("first_state", shapes, platform, reported)
        return place, spread

    def _called(self, name: str, shapes: list[tuple[int, ...]], *given: Any) -> list[FloatArray]:
        """Return what a method makes of what it is given, of the shapes that it has to have."""
        if not shapes[0][0]:
            return [np.zeros(shape) for shape in shapes]
        with told_as_theirs(self.model, "measurements", name):
            found = getattr(self.model, name)(*given)
        return shaped(found, shapes, f"measurement {self.word}", name)


def kind_of(measurement: Any) -> Any:
    """Return a kind of measurement, one from outside as what stands for it; else what came."""
    if isinstance(measurement, ForeignKind | MeasurementKind | type):
        return measurement
    return ForeignKind(measurement) if hasattr(measurement, "columns") else measurement


def ours(measurement: MeasurementKind | ForeignKind, name: str) -> MeasurementKind:
    """Return a kind of ours, which alone can be fused before it is tracked; refuse another."""
    if isinstance(measurement, ForeignKind):
        raise InvalidInputError(
            f"sensor {name}: measurement {measurement.word} is a plug-in, whose plots cannot be "
            "fused before tracking; expected a kind of ours, or plots.fuse = false"
        )
    return measurement


def slope_of(function: Callable[[FloatArray], FloatArray], states: FloatArray) -> FloatArray:
    """Return the derivatives of what a function makes of states, by central differences.

    Parameters
    ----------
    function
        Makes values, shape (rows, m), of states.
    states
        Where, shape (rows, size).

    Returns
    -------
    Shape (rows, m, size).

    Raises
    ------
    InvalidInputError
        If there is no function, or the states are no numbers by row.

    Examples
    --------
    >>> import numpy as np
    >>> import trackweave as tw
    >>> tw.slope_of(lambda state: state**2, np.array([[3.0, 1.0]])).round(6)[0]
    array([[6., 0.],
           [0., 2.]])
    """
    if not callable(function):
        raise InvalidInputError(f"function: {function!r:.80}; expected a function of states")
    states, columns = float_array(states, "states", (None, None)), []
    for column in range(states.shape[1]):
        step = FINE * (1.0 + np.abs(states[:, column]))
        sides = []
        for sign in (1.0, -1.0):
            beside = states.copy()
            beside[:, column] += sign * step
            made = float_array(function(beside), "values of function", (len(beside), None))
            sides.append(made)
        columns.append((sides[0] - sides[1]) / (2.0 * step[:, None]))
    return np.stack(columns, axis=2)


def shaped(found: Any, shapes: list[tuple[int, ...]], whose: str, name: str) -> list[FloatArray]:
    """Return, contiguous, what a method from outside returned, or refuse it."""
    # An array where one shape is expected, otherwise as many; ``whose`` and ``name`` are what
    # messages call plug-in and method.
    expected = " and ".join(str(shape) for shape in shapes)
    given = (found,) if len(shapes) == 1 else found
    try:
        arrays = [np.ascontiguousarray(array, dtype=np.float64) for array in given]
    except (TypeError, ValueError) as err:
        raise InvalidInputError(
            f"{whose}: {name} returned {found!r:.60}; expected arrays of shape {expected}"
        ) from err
    came = [np.shape(array) for array in given]
    if came != shapes:
        listed = " and ".join(map(str, came)) or "nothing"
        raise InvalidInputError(f"{whose}: {name} returned shape {listed}; expected {expected}")
    for array in arrays:
        if not np.isfinite(array).all():
            row = int(np.argwhere(~np.isfinite(array))[0][0])
            raise InvalidInputError(
                f"{whose}: {name} returned no finite number in row {row}; expected finite numbers"
            )
    return arrays


def _are_names(names: Any) -> bool:
    return isinstance(names, tuple) and all(isinstance(name, str) for name in names)
