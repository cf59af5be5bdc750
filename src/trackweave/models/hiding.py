"""Objects that are where they cannot be seen for a while."""

import math

__all__ = ["hiding"]


def hiding(share: float, mean_silence: float, waited: float) -> tuple[float, float]:
    """Return how probably an object in sight is hidden some time later, and the other way."""
    # A chain of two states in continuous time, so that two steps are as one over both. ``share``
    # is that of the time for which objects are hidden, ``mean_silence`` for how long on average
    # [s], ``waited`` the time [s].
    if share <= 0.0:
        return 0.0, 0.0
    mixed = -math.expm1(-waited / (mean_silence * (1.0 - share)))
    return share * mixed, (1.0 - share) * mixed
