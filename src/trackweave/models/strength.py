"""What the strength of a report says of its origin."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.fields import settle
from trackweave.keys import POSITIVE, Key

__all__ = ["StrengthModel"]

STRENGTH = Key("a number", -1e12, 1e12)
MOST_EVIDENCE = 8.0
"""Tails of fitted curves are not to be trusted further than this [nats]."""


@dataclass(frozen=True, slots=True)
class StrengthModel:
    """How strong reports of objects are, and how strong false alarms are; both about normal.

    Parameters
    ----------
    target_mean
        Mean strength of reports of objects, in the unit of the column (best in decibels).
    target_sigma
        Its standard deviation.
    clutter_mean
        Mean strength of false alarms.
    clutter_sigma
        Its standard deviation.
    target_spread
        By how much at most the mean strength of one object differs from that of all, where there
        are small and large ones: then the ``target_sigma`` is that of the reports of each.

    Raises
    ------
    InvalidInputError
        If a value is not finite or a sigma is not positive.

    Examples
    --------
    >>> import numpy as np
    >>> import trackweave as tw
    >>> model = tw.StrengthModel(20.0, 3.0, 10.0, 3.0)  # dB
    >>> model.evidence(np.array([10.0, 15.0, 20.0])).round(2)  # nats
    array([-5.56,  0.  ,  5.56])
    """

    NEEDED: ClassVar = ("target_mean", "target_sigma", "clutter_mean", "clutter_sigma")
    target_mean: Annotated[float, STRENGTH]
    target_sigma: Annotated[float, POSITIVE]
    clutter_mean: Annotated[float, STRENGTH]
    clutter_sigma: Annotated[float, POSITIVE]
    target_spread: Annotated[float, Key("a number from 0 to 1e12", 0, 1e12)] = 0.0

    def __post_init__(self) -> None:
        settle(self)

    def evidence(self, strength: FloatArray) -> FloatArray:
        """Return how much more likely each strength is of an object than of a false alarm.

        Parameters
        ----------
        strength
            Strengths, shape (reports,); NaN where a report has none.

        Returns
        -------
        Log likelihood ratios [nats], within ± 8; 0 where there is no strength.
        """
        apart = np.abs(strength - self.target_mean) - self.target_spread
        target = np.maximum(apart, 0.0) / self.target_sigma
        clutter = (strength - self.clutter_mean) / self.clutter_sigma
        ratio = (clutter**2 - target**2) / 2 + np.log(self.clutter_sigma / self.target_sigma)
        within = np.clip(ratio, -MOST_EVIDENCE, MOST_EVIDENCE)
        evidence: FloatArray = np.where(np.isnan(strength), 0.0, within)
        return evidence
