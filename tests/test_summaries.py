"""What results say of themselves."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import polars as pl

import trackweave as tw
from trackweave.domain.tracks import TrackTable
from trackweave.summaries import counted, summary

MOST = 1500


@dataclass
class Thing:
    many: Any = field(default_factory=lambda: np.zeros((1000, 3)))
    few: Any = field(default_factory=lambda: np.arange(3))
    listed: Any = field(default_factory=lambda: [0.5] * 1000)
    rows: Any = field(default_factory=lambda: TrackTable.empty(2))
    text: str = "x" * 1000
    number: float = 1.5

    __repr__ = summary


def test_tells_the_size_of_what_is_large_and_the_value_of_what_is_small() -> None:
    told = repr(Thing())
    assert "many=array of 1000×3, few=[0, 1, 2], listed=list of 1,000" in told
    assert "rows=TrackTable of 0 rows" in told
    assert told.endswith("…, number=1.5)")
    assert len(told) < 250


def test_counts_in_words() -> None:
    assert [counted(n, "scan") for n in (0, 1, 1200)] == ["0 scans", "1 scan", "1,200 scans"]


def test_no_public_value_prints_its_whole_content() -> None:
    count = 2000
    rng = np.random.default_rng(1)
    time = np.repeat(np.arange(count / 4), 4)
    reports = tw.read_reports(
        pl.DataFrame({"time": time, "x": rng.normal(size=count), "y": rng.normal(size=count)})
    )
    truth = tw.TruthTable.from_columns(time, np.tile(range(4), count // 4), np.zeros((count, 2)))
    problem = tw.AssignmentProblem.from_tuples(
        [(1 + k, 1 + k) for k in range(count)], -np.ones(count)
    )
    tracker = tw.MultiHypothesisTracker(
        motion=tw.ConstantVelocity(process_noise=0.1, max_speed=5.0),
        sensors=[
            tw.Sensor(
                "default", sigma=1.0, detection_probability=0.9, clutter_density=1e-6,
                scan_period=1.0,
            )
        ],
    )  # fmt: skip
    scan = tw.Scan(0.0, "default", rng.uniform(0, 1e5, (60, 2)))
    for value in (
        *(reports, truth, problem, tw.solve(problem), scan, tracker.step(scan)),
        *(TrackTable.empty(3), tw.evaluate(truth, truth)),
    ):
        assert len(repr(value)) < MOST, type(value)
