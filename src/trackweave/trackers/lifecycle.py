"""When a track begins to count, and when it ends."""

import math
from dataclasses import dataclass

from trackweave.errors import InvalidInputError
from trackweave.fields import settle

__all__ = ["Lifecycle"]


@dataclass(frozen=True, slots=True)
class Lifecycle:
    """Birth, confirmation and death of tracks.

    Parameters
    ----------
    confirm_hits, confirm_opportunities
        A track is confirmed by so many reports out of so many chances to be seen; several
        sensors at one instant are one chance. 1 ≤ hits ≤ opportunities.
    confirm_probability
        It is also as probable as this that its object exists, in [0, 1).
    certain_probability
        A track whose object exists as probably as this is confirmed whatever its hits, in
        (0, 1]; 1 for never.
    delete_after_misses
        A track ends after so many chances missed in a row, at least 1; None to go by how probable
        it is that its object is gone.
    hidden_share
        The share of its time, from 0 to 0.9, for which an object is where no sensor can see it; 0
        where each chance is missed by itself.
    mean_silence
        How long it is hidden then, on average [s]. Must be positive.
    rejoin
        For so long after its last report a track may be taken up again [s]; None to go by how
        probable it is that its object is gone.
    new_target_density
        Objects newly present per m² (m³) and scan, usually one in ten kilometres squared. Must be
        positive.
    initial_target_density
        Objects present per m² (m³) before the first scan; None for ``new_target_density``.
    survival
        Probability that an object lives on from scan to scan, in (0, 1).

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
    confirm_probability: float = 0.5
    certain_probability: float = 0.99
    delete_after_misses: int | None = None
    hidden_share: float = 0.01
    mean_silence: float = 60.0
    rejoin: float | None = None
    new_target_density: float = 1e-8
    initial_target_density: float | None = None
    survival: float = 0.999

    def __post_init__(self) -> None:
        settle(self)
        if not 1 <= self.confirm_hits <= self.confirm_opportunities:
            raise InvalidInputError(
                f"confirm: {self.confirm_hits}/{self.confirm_opportunities}; expected M/N with "
                "1 ≤ M ≤ N"
            )
        if self.delete_after_misses is not None and not self.delete_after_misses >= 1:
            raise InvalidInputError(
                f"delete_after_misses: {self.delete_after_misses}; expected at least 1"
            )
        if not 0 <= self.confirm_probability < 1:
            raise InvalidInputError(
                f"confirm_probability: {self.confirm_probability}; expected 0 to below 1"
            )
        if not 0 <= self.hidden_share <= 0.9:
            raise InvalidInputError(f"hidden_share: {self.hidden_share}; expected 0 to 0.9")
        if not 0 < self.certain_probability <= 1:
            raise InvalidInputError(
                f"certain_probability: {self.certain_probability}; expected above 0, at most 1"
            )
        if not 0 < self.survival < 1:
            raise InvalidInputError(f"survival: {self.survival}; expected between 0 and 1")
        for name in ("new_target_density", "initial_target_density", "mean_silence", "rejoin"):
            value = getattr(self, name)
            if value is not None and not value > 0:
                raise InvalidInputError(f"{name}: {value}; expected a finite number > 0")

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
        if self.hidden_share <= 0.0:
            return 0.0, 0.0
        mixed = -math.expm1(-waited / (self.mean_silence * (1.0 - self.hidden_share)))
        return self.hidden_share * mixed, (1.0 - self.hidden_share) * mixed

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
