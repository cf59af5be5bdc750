"""What a category is, and what comes of its records."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackweave.formats.asterix.layout import Compound
from trackweave.formats.asterix.records import Records
from trackweave.formats.asterix.values import Columns

__all__ = ["Category", "Part"]


class Category(NamedTuple):
    """A category in one of its editions."""

    layouts: tuple[Compound, ...]
    """Its items; several layouts where records are of several kinds."""
    columns: Callable[[Records], Columns] | None = None
    """Makes columns of a reports table, ``time`` as the seconds of the day or, as
    ``time_within_512_s``, what is left of them; None where records are no reports."""
    choose: Callable[[bytes, int], int] | None = None
    """Which layout the record has that begins at a place of a block."""


@dataclass(slots=True)
class Part:
    """Reports of one category, by columns."""

    category: int
    begin: NDArray[np.int64]
    """Where each record begins, which is the order in which they came."""
    clock: NDArray[np.float64]
    """When each came by the capture's clock [s], 0 where there is none."""
    columns: Columns = field(default_factory=dict)
