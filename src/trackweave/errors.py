"""What can go wrong, as one tree.

TrackweaveError
├── InvalidInputError(ValueError)        an argument or a configuration value is not usable
│   └── DataFormatError                  a file is not what it should be; names file, row, column
├── NumericalError(ArithmeticError)      a computation lost its meaning (a covariance, a cost)
└── OutputError(OSError)                 the environment refuses what we must write
"""

__all__ = [
    "DataFormatError",
    "InvalidInputError",
    "NumericalError",
    "OutputError",
    "TrackweaveError",
]


class TrackweaveError(Exception):
    """Anything that trackweave raises on purpose.

    Examples
    --------
    >>> import trackweave as tw
    >>> try:
    ...     tw.Window(depth=0)
    ... except tw.TrackweaveError as error:
    ...     print(type(error).__name__)
    ...
    InvalidInputError
    """


class InvalidInputError(TrackweaveError, ValueError):
    """An argument or configuration value is not usable; the message says what was expected.

    Examples
    --------
    >>> import trackweave as tw
    >>> tw.Window(depth=2.5)  # scans
    Traceback (most recent call last):
        ...
    trackweave.errors.InvalidInputError: depth: 2.5; expected a whole number from 1 to 200
    """


class DataFormatError(InvalidInputError):
    """A file or table is not what it should be; the message names file, row and column.

    Examples
    --------
    >>> import polars as pl
    >>> import trackweave as tw
    >>> frame = pl.DataFrame({"time": [0.0, 1.0], "x": [1.0, None], "y": [2.0, 3.0]})
    >>> tw.read_reports(frame)  # doctest: +ELLIPSIS
    Traceback (most recent call last):
        ...
    trackweave.errors.DataFormatError: table, row 2, column x: (empty); expected a finite ...
    """


class NumericalError(TrackweaveError, ArithmeticError):
    """A computation lost its meaning, such as a covariance that is not positive definite.

    Examples
    --------
    >>> import trackweave as tw
    >>> issubclass(tw.NumericalError, ArithmeticError)
    True
    """


class OutputError(TrackweaveError, OSError):
    """The environment refuses what must be written: a full disk, no permission.

    Examples
    --------
    >>> import trackweave as tw
    >>> issubclass(tw.OutputError, OSError)
    True
    """
