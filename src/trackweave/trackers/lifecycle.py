"""When a track begins to count, and when it ends."""

from dataclasses import dataclass
from typing import Annotated

from trackweave.errors import InvalidInputError
from trackweave.fields import settle
from trackweave.keys import COUNT, DENSITY, PROBABILITY, SECONDS, Key
from trackweave.models.coverage import hiding

__all__ = ["Lifecycle"]


@dataclass(frozen=True, slots=True)
class Lifecycle:
    """Birth, confirmation and death of tracks.

    Parameters
    ----------
    confirm_hits, confirm_opportunities
        A track is confirmed by so many reports out of so many chances to be seen; several
        sensors at one instant are one chance. 1 ≤ hits ≤ opportunities.
    delete_after_misses
        Misses in succession that end a track; left out = when its object is probably gone.

        None for left out, as everywhere here.
    hidden_share
        Share of their time for which objects are where no sensor can see them; 0 = never.
    mean_silence
        How long they are hidden then, on average [s].
    rejoin
        For so long a track may be taken up again [s]; left out = as is probable.
    new_target_density
        Objects newly present per m² (m³) of tracking space and scan.
    initial_target_density
        Objects present per m² (m³) before the first scan.

        None for ``new_target_density``.
    confirm_probability
        How probable a track's object must be, besides, for the track to be confirmed.
    certain_probability
        How probable an object must be for its track to be confirmed at once; 1 = never.
    survival
        Chance that an object is still there one scan period later.

    Raises
    ------
    InvalidInputError
        If a value is no number, or out of range.

    Examples
    --------
    >>> import trackweave as tw
    >>> lifecycle = tw.Lifecycle(confirm_hits=2, confirm_opportunities=3)
    >>> lifecycle.is_confirmed_by([1.0, 3.0]), lifecycle.is_confirmed_by([1.0, 4.0])
    (True, False)
    """

    confirm_hits: int = 3
    confirm_opportunities: int = 4
    delete_after_misses: Annotated[int | None, COUNT] = None
    hidden_share: Annotated[float, Key("a number from 0 to 0.9", 0, 0.9)] = 0.01
    mean_silence: Annotated[float, SECONDS] = 60.0
    rejoin: Annotated[float | None, SECONDS] = None
    new_target_density: Annotated[float, DENSITY.said("a number > 0 per m² (m³) and scan")] = 1e-8
    initial_target_density: Annotated[float | None, DENSITY.said("a number > 0 per m² (m³)")] = (
        None
    )
    confirm_probability: Annotated[
        float, Key("a number from 0 to below 1", 0, PROBABILITY.most)
    ] = 0.5
    certain_probability: Annotated[
        float, Key("a number above 0, at most 1", PROBABILITY.least, 1)
    ] = 0.99
    survival: Annotated[float, PROBABILITY.said("a number between 0 and 1, both excluded")] = 0.999

    def __post_init__(self) -> None:
        settle(self)
        if not 1 <= self.confirm_hits <= self.confirm_opportunities:
            raise InvalidInputError(
                f"confirm: {self.confirm_hits}/{self.confirm_opportunities}; expected M/N with "
                "1 ≤ M ≤ N"
            )

    def hiding(self, waited: float) -> tuple[float, float]:
        """Return how probably an object in sight is hidden some time later, and the other way.

        A chain of two states in continuous time, so that two steps are as one over both.

        Parameters
        ----------
        waited
            The time [s], at least 0.

        Returns
        -------
        Both probabilities.
        """
        return hiding(self.hidden_share, self.mean_silence, waited)

    def is_confirmed_by(self, chances: list[float]) -> bool:
        """Tell whether hits at these chances confirm a track.

        Parameters
        ----------
        chances
            The number of the chance that each hit took, counted from the track's first, ascending.

        Returns
        -------
        Whether some M of them lie within N chances.
        """
        distinct = _distinct(chances)
        needed = self.confirm_hits - 1
        return any(
            late - early <= self.confirm_opportunities - 0.5
            for early, late in zip(distinct, distinct[needed:], strict=False)
        )

    def recent(self, chances: list[float]) -> list[float]:
        """Return of hits at these chances the last ones, as many as may confirm with later ones.

        Parameters
        ----------
        chances
            As for ``is_confirmed_by``.

        Returns
        -------
        One number for each chance taken, ascending.
        """
        return _distinct(chances)[-self.confirm_hits :]


def _distinct(chances: list[float]) -> list[float]:
    """Return one number for each chance: sensors of one instant share theirs."""
    distinct: list[float] = []
    for chance in chances:
        if not distinct or chance - distinct[-1] > 0.5:
            distinct.append(chance)
    return distinct
