"""What a worker keeps is what its caller believes that it keeps."""

import numpy as np

from trackweave.engine import shelf
from trackweave.engine.shelf import Shelf


def test_both_sides_hold_the_same_whatever_is_sent() -> None:
    rng = np.random.default_rng(1)
    values = [object() for _ in range(2 * shelf.KEPT)]
    mine, theirs, n_new = Shelf(), Shelf(), 0
    for _ in range(500):
        chosen = [values[each] for each in rng.integers(0, len(values), 5)]
        entries = mine.sent(chosen)
        n_new += sum(is_new for _, is_new, _ in entries)
        assert theirs.received(entries) == chosen
    assert mine._held == theirs._held
    assert len(mine._held) == shelf.KEPT
    assert len(values) < n_new < 2500


def test_what_is_asked_for_stays() -> None:
    mine, first = Shelf(), object()
    for _ in range(3 * shelf.KEPT):
        mine.sent([first, object()])
    assert [is_new for _, is_new, _ in mine.sent([first])] == [False]
