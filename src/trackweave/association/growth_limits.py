"""What bounds the growth of an association tree."""

from dataclasses import dataclass
from numbers import Real
from typing import Self

from trackweave.arrays import is_whole
from trackweave.errors import InvalidInputError

__all__ = ["GrowthLimits"]


@dataclass(frozen=True, slots=True)
class GrowthLimits:
    """What bounds the growth of an association tree.

    Sequences are ranked by their cost plus what their reports are worth to others.

    Parameters
    ----------
    margin
        A track's sequence grows on while its rank is within this of the track's best [nats].
    keep
        Greatest number of sequences on which a track grows.
    new_margin, new_keep
        The same for an object that begins in the window.
    new_ceiling
        How far above the price of its first report such a sequence's rank may lie [nats].
    max_nodes
        Greatest number of sequences looked at together; the worst ranked give way, never a
        beginning or the best sequence of a track. What no scan concerns is not among them.

    Raises
    ------
    InvalidInputError
        If a value is no positive number, or a count is not whole.
    """

    margin: float = 10.0
    keep: int = 150
    new_margin: float = 6.0
    new_keep: int = 16
    new_ceiling: float = 4.5
    max_nodes: int = 500_000

    def __post_init__(self) -> None:
        for name in self.__dataclass_fields__:
            value = getattr(self, name)
            is_count = name in ("keep", "new_keep", "max_nodes")
            if not (is_whole(value) if is_count else isinstance(value, Real)) or not value > 0:
                what = "a whole number" if is_count else "a number"
                raise InvalidInputError(f"{name}: {value!r:.80}; expected {what} > 0")

    @classmethod
    def of_bearings(cls) -> Self:
        """Return what serves where no sensor tells places.

        Two bearings cross wherever two objects are seen, and at first most crossings are no
        object's: a right sequence may stay behind several wrong ones for some scans.

        Returns
        -------
        Wider limits for what begins in the window.
        """
        return cls(new_margin=10.0, new_keep=30, new_ceiling=14.0)
