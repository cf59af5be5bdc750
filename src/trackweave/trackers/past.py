"""What lies before the window, as far as a scan that comes late has to know."""

from collections import deque

import numpy as np

from trackweave.association._nodes import Families, ScanInput
from trackweave.association.beginning import Beginning
from trackweave.association.tree import AssociationTree
from trackweave.association.window_rule import without_reports
from trackweave.trackers.opening import rooted
from trackweave.trackers.undetected import Undetected
from trackweave.trackers.window import OpenScan

__all__ = ["Past"]

REMEMBERED_SCANS = 512
"""So many scans before the window tell a late one what tracks have missed."""


class Past:
    """Where undetected objects were before the window, and which scans were closed last.

    Parameters
    ----------
    undetected
        Where they may be before the first scan.
    patience
        For how long a track may wait for a report [s]: what is older concerns nobody.
    """

    def __init__(self, undetected: Undetected, patience: float) -> None:
        self.undetected = undetected
        self._patience = patience
        self._closed: deque[ScanInput] = deque(maxlen=REMEMBERED_SCANS)

    def close(self, closing: list[OpenScan], last: float) -> None:
        """Take in scans that leave the window; ``last`` is when the one before ended [s]."""
        for known in closing:
            waited = known.data.time - last if np.isfinite(last) else 0.0
            self.undetected.pass_over(known.data, waited)
            self._closed.append(without_reports(known.data)._replace(slot=known.data.slot))
            last = known.data.time
        while self._closed and self._closed[0].time < last - self._patience:
            self._closed.popleft()

    def beginning(self, tree: AssociationTree) -> tuple[Beginning, Families]:
        """Return the tracks of a tree, which is fixed up to the window, as they enter it."""
        return rooted(tree, self._closed)
