"""What can go wrong, as one tree.

TrackweaveError
├── InvalidInputError(ValueError)        an argument or a configuration value is not usable
│   └── DataFormatError                  a file is not what it should be; names file, row, column
├── InfeasibleError                      a problem has no answer that keeps its rules
├── NumericalError(ArithmeticError)      a computation lost its meaning (a covariance, a cost)
├── OutputError(OSError)                 the environment refuses what we must write
└── MissingDependencyError(ImportError)  an optional package is not installed; names the extra
"""

__all__ = [
    "DataFormatError",
    "InfeasibleError",
    "InvalidInputError",
    "MissingDependencyError",
    "NumericalError",
    "OutputError",
    "TrackweaveError",
]


class TrackweaveError(Exception):
    """Anything that trackweave raises on purpose."""


class InvalidInputError(TrackweaveError, ValueError):
    """An argument or configuration value is not usable; the message says what was expected."""


class DataFormatError(InvalidInputError):
    """A file or table is not what it should be; the message names file, row and column."""


class InfeasibleError(TrackweaveError):
    """An assignment problem has no answer that covers every item that must be covered."""


class NumericalError(TrackweaveError, ArithmeticError):
    """A computation lost its meaning, such as a covariance that is not positive definite."""


class OutputError(TrackweaveError, OSError):
    """The environment refuses what must be written: a full disk, no permission."""


class MissingDependencyError(TrackweaveError, ImportError):
    """An optional package is not installed; the message names the extra that brings it."""
