"""What lies before the window, as far as a scan that comes late has to know."""

import copy
from collections import deque
from collections.abc import Sequence
from typing import Any

import numpy as np

from trackweave.association._nodes import Families, ScanInput
from trackweave.association.initial_tracks import InitialTracks
from trackweave.association.tree import AssociationTree
from trackweave.association.window_rule import without_reports
from trackweave.trackers.scan_preparation import rooted
from trackweave.trackers.undetected import Undetected
from trackweave.trackers.window import OpenScan

__all__ = ["FixedHistory"]

REMEMBERED_SCANS = 512
"""So many scans before the window tell a late one what tracks have missed."""


class FixedHistory:
    """Where undetected objects were before the window, and which scans were closed last.

    ``patience`` is for how long a track that is looked at waits for a report [s]; what others
    missed before is known from the tree.
    """

    def __init__(self, undetected: Undetected, patience: float) -> None:
        self.undetected = undetected
        self._patience = patience
        self._closed: deque[ScanInput] = deque()
        self._forgotten = -np.inf

    def __getstate__(self) -> dict[str, Any]:
        own = {"undetected": copy.copy(self.undetected), "_closed": self._closed.copy()}
        return {**self.__dict__, **own}

    def close(self, closing: list[OpenScan], last: float) -> None:
        """Take in scans that leave the window; ``last`` is when the one before ended [s]."""
        for known in closing:
            waited = known.data.time - last if np.isfinite(last) else 0.0
            self.undetected.pass_over(known.data, waited)
            self._closed.append(without_reports(known.data)._replace(slot=known.data.slot))
            last = known.data.time
        while self._closed and (
            len(self._closed) > REMEMBERED_SCANS or self._closed[0].time < last - self._patience
        ):
            self._forgotten = self._closed.popleft().time

    def initial_tracks(
        self, tree: AssociationTree, window: Sequence[ScanInput]
    ) -> tuple[InitialTracks, Families]:
        """Return the tracks of a tree, and their families, as they enter the window."""
        # The tree is fixed up to the window, and has grown by the window's scans since.
        return rooted(tree, list(self._closed), window, self._forgotten)
