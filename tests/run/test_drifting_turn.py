"""A radar whose motor wanders is tracked, whatever period is told."""

import numpy as np
import polars as pl
import pytest

import trackweave as tw

pytestmark = pytest.mark.slow


def drifting(direction: int = 1, wander: float = 0.003) -> pl.DataFrame:
    """Six objects, two false alarms a turn; a radar of 1.01 s a turn, give or take."""
    rng = np.random.default_rng(2)
    place, heading = rng.uniform(-2500, 2500, (6, 2)), rng.uniform(0, 7, 6)
    speed = np.stack([np.sin(heading), np.cos(heading)], axis=1) * 8.0
    rows, begin, slower = [], 0.0, 0.0
    for _ in range(90):
        slower = 0.95 * slower + rng.normal(0, wander)
        length = 1.01 * (1 + slower)
        false = rng.uniform(-3000, 3000, (rng.poisson(2), 2))
        seen = rng.random(6) < 0.92
        true = np.concatenate([(place + speed * begin)[seen], false])
        noisy = true + np.concatenate([rng.normal(0, 4, (seen.sum(), 2)), 0 * false])
        turned = (direction * np.arctan2(true[:, 0], true[:, 1]) / (2 * np.pi)) % 1.0
        names = [*map(str, np.flatnonzero(seen)), *[""] * len(false)]
        rows += zip((begin + turned * length).round(4), *noisy.T.tolist(), names, strict=True)
        begin += length
    return pl.DataFrame(sorted(rows), schema=["time", "x", "y", "target"], orient="row")


def share_named_rightly(table: pl.DataFrame, config: dict | None) -> tuple[float, list[str]]:
    """Return the share of objects' reports on their object's own track, and the run's notes."""
    result = tw.track(table.drop("target"), config, rng=1)
    named = table.with_columns(result.reports["track"]).filter(pl.col("target") != "")
    largest = named.drop_nulls("track").group_by("target", "track").len().group_by("target")
    return largest.agg(pl.col("len").max())["len"].sum() / len(named), result.run["notes"]


def test_a_turn_that_wanders_is_followed() -> None:
    share, notes = share_named_rightly(drifting(), None)
    assert share > 0.98
    assert any("its reports show turns of 1.0" in note and "varying by" in note for note in notes)


def test_a_period_told_wrongly_is_put_right() -> None:
    config = {"sensors": {"default": {"scan_period": 1.05}}}
    share, notes = share_named_rightly(drifting(direction=-1), config)
    assert share > 0.98
    said = "sensor default: scan_period told 1.05 s, its reports show 1.0"
    assert any(note.startswith(said) for note in notes)


def test_of_a_period_told_rightly_nothing_is_said() -> None:
    config = {"sensors": {"default": {"scan_period": 1.01}}}
    share, notes = share_named_rightly(drifting(wander=0.0), config)
    assert share > 0.98
    others = [note for note in notes if "ranges and azimuths" not in note]
    assert not any("scan_period" in note or "turn" in note for note in others)
