"""What bounds the growth of an association tree."""

from dataclasses import dataclass
from typing import Self

from trackweave.errors import InvalidInputError
from trackweave.fields import Limit, settle

__all__ = ["GrowthLimits"]


@dataclass(frozen=True, slots=True)
class GrowthLimits:
    """What bounds the growth of an association tree.

    Sequences are ranked by their cost plus what their reports are worth to others. Beginnings stay
    whatever the limits, and of each track the best sequence that lives on without a report.

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
        track's best. What no scan concerns is not among them.
    negligible
        Once a search is over, the least probable sequences of each track from before the window
        are forgotten, as many as have this probability together; 0 for none.

    Raises
    ------
    InvalidInputError
        If a value is no positive number, a count is not whole, or what is negligible no
        probability.

    Examples
    --------
    >>> import trackweave as tw
    >>> tw.GrowthLimits(keep=50).keep  # sequences of a track that grow on
    50
    >>> tw.GrowthLimits.of_bearings().new_margin  # nats
    10.0
    """

    margin: Limit = 10.0
    keep: int = 150
    new_margin: Limit = 6.0
    new_keep: int = 16
    new_ceiling: Limit = 4.5
    max_nodes: int = 500_000
    negligible: float = 0.0

    def __post_init__(self) -> None:
        settle(self)
        if not 0.0 <= self.negligible < 1.0:
            raise InvalidInputError(f"negligible: {self.negligible}; expected 0 to less than 1")
        for name in self.__dataclass_fields__:
            if name != "negligible" and not getattr(self, name) > 0:
                raise InvalidInputError(f"{name}: {getattr(self, name)}; expected a number > 0")

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

    @classmethod
    def of_lone_reports(cls) -> Self:
        """Return what serves where no sensor looks.

        Beside an object that is known, its neighbour's reports are worth much to it, until their
        times tell them apart: a right sequence stays behind for minutes. In a harbour nearly all
        are tied to each other by sequences that hardly anything speaks for.

        Returns
        -------
        Wider limits for what begins in the window, and what is negligible is forgotten.
        """
        return cls(new_margin=15.0, new_keep=30, new_ceiling=20.0, negligible=0.005)
