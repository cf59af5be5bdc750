"""Tables of tracks that callers make."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from trackweave.domain.tracks import TrackTable
from trackweave.errors import InvalidInputError


def columns(**other: Any) -> dict[str, Any]:
    return {
        "time": [0, 1], "track": [4, 4], "status": [1, 2], "mean": [[0, 0, 1, 1]] * 2,
        "covariance": [np.eye(4).tolist()] * 2, "score": [0.0, 0.0], "hits": [1, 2],
        "last_update": [0, 1],
    } | other  # fmt: skip


def test_takes_lists_for_arrays() -> None:
    table = TrackTable(**columns())
    assert (len(table), table.dim, table.covariance.shape) == (2, 2, (2, 4, 4))
    assert (table.time.dtype, table.track.dtype) == (np.float64, np.int64)
    assert table.acceleration.shape == (2, 0)
    assert len(TrackTable.concatenate([table, table], 2)) == 4


def test_takes_arrays_that_fit_as_they_are() -> None:
    table = TrackTable(**columns())
    again = replace(table, hits=table.hits + 1)
    assert again.mean is table.mean
    assert again.track is table.track


@pytest.mark.parametrize(
    "other",
    [
        {"time": [0.0]}, {"time": 1.0}, {"time": None}, {"time": ["a", "b"]},
        {"track": [1.5, 2.0]}, {"status": [1, 3]}, {"status": ["confirmed"] * 2},
        {"mean": [[0.0] * 5] * 2}, {"mean": [0.0, 0.0]}, {"covariance": [np.eye(2)] * 2},
        {"hits": None}, {"acceleration": [[1.0, 1.0]]}, {"acceleration": "none"},
        {"existence": [0.5]}, {"visible": 1.0},
    ],
    ids=str,
)  # fmt: skip
def test_refuses_columns_that_do_not_fit(other: dict[str, Any]) -> None:
    with pytest.raises(InvalidInputError, match="expected"):
        TrackTable(**columns(**other))
