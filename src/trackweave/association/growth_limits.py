"""What bounds the growth of an association tree."""

from dataclasses import dataclass, replace
from typing import Annotated, Self

from trackweave.fields import Limit, settle
from trackweave.keys import COUNT, POSITIVE, PROBABILITY, Key

__all__ = ["GrowthLimits"]

NATS = replace(POSITIVE, expected="a number > 0 in nats", is_open=True)
MANY = replace(COUNT, is_open=True)


@dataclass(frozen=True, slots=True)
class GrowthLimits:
    """What bounds the growth of an association tree.

    Sequences are ranked by their cost plus what their reports are worth to others. Beginnings stay
    whatever the limits, and of each track the best sequence that lives on without a report.

    Parameters
    ----------
    margin
        How far behind the best a track's sequence may lie and grow on [nats].
    keep
        Greatest number of sequences on which a track grows.
    new_margin
        The same as ``margin`` for an object that begins in the window [nats].
    new_keep
        The same as ``keep`` for an object that begins in the window.
    new_ceiling
        How far above the price of its first report such a sequence may lie [nats].
    max_nodes
        Greatest number of sequences looked at together.

        The worst ranked give way, never a track's best. What no scan concerns is not among them.
    negligible
        How probable a track's sequences are together that are forgotten after a search.

        The least probable ones, of a track from before the window; 0 for none.

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

    margin: Annotated[Limit, NATS] = 10.0
    keep: Annotated[int, MANY] = 150
    new_margin: Annotated[Limit, NATS] = 6.0
    new_keep: Annotated[int, MANY] = 16
    new_ceiling: Annotated[Limit, NATS] = 4.5
    max_nodes: Annotated[
        int, Key("a whole number from 1 to 100000000", 1, 10**8, is_open=True)
    ] = 500_000
    negligible: Annotated[float, Key("a number from 0 to below 1", 0, PROBABILITY.most)] = 0.0

    def __post_init__(self) -> None:
        settle(self)

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
