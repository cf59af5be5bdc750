"""Tests of the curves over time beside the plan."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from plotting.test_run import report_table, track_table
from trackweave.domain.tracks import TrackTable
from trackweave.errors import InvalidInputError
from trackweave.plotting import _panels, run
from trackweave.plotting._canvas import Canvas, open_canvas
from trackweave.plotting._panels import counts_by_status, time_axis
from trackweave.plotting.run import picture_of_run
from trackweave.plotting.scene import ScanSeries, Scene


def series(n: int = 12, tracks: TrackTable | None = None, **changes: Any) -> ScanSeries:
    time = np.arange(n, dtype=float)
    gap = np.where(time % 3 == 0, 0.1, 0.0)
    whole = ScanSeries(
        time=time,
        reports=np.full(n, 5.0),
        assigned=np.full(n, 3.0),
        gap=gap,
        proven=gap == 0,
        cpu_ms=1.0 + time,
        known=track_table(3) if tracks is None else tracks,
    )
    return replace(whole, **changes)


def drawn(monkeypatch: pytest.MonkeyPatch, scene: Scene, scans: ScanSeries) -> Canvas:
    opened: list[Canvas] = []

    def watched(places: np.ndarray, **options: Any) -> Canvas:
        opened.append(open_canvas(places, **options))
        return opened[-1]

    monkeypatch.setattr(run, "open_canvas", watched)
    picture_of_run(scene, scans)
    return opened[0]


def titles(sheet: Canvas) -> list[str]:
    return [axes.get_title(loc="left") for axes in sheet.figure.axes[1:]]


@pytest.mark.parametrize("dim", [2, 3])
def test_a_panel_for_each_kind_of_curve(monkeypatch: pytest.MonkeyPatch, dim: int) -> None:
    scene = Scene(report_table(50, dim), track_table(3, dim=dim))
    sheet = drawn(monkeypatch, scene, series())
    heads = ["tracks", "reports per scan", "gap to the bound", "CPU per scan [ms]"]
    heads.append("speed of tracks [m/s]")
    assert titles(sheet) == heads + ["height of tracks, z [m]"] * (dim - 2)


def boxes(sheet: Canvas) -> list[Any]:
    return [axes.get_position() for axes in sheet.figure.axes]


@pytest.mark.parametrize("wide", [False, True])
def test_panels_lie_apart_on_the_sheet(monkeypatch: pytest.MonkeyPatch, wide: bool) -> None:
    reports = report_table(50)
    if wide:
        reports.measurement[:, 1] /= 10
    sheet = drawn(monkeypatch, Scene(reports, TrackTable.empty(2)), series())
    found = boxes(sheet)
    below = found[1].y1 < found[0].y0
    assert below == wide
    for number, box in enumerate(found):
        assert box.x0 > 0
        assert box.y0 > 0
        assert box.x1 < 1
        assert box.y1 < 1
        assert not any(box.overlaps(other) for other in found[number + 1 :])


def test_scans_proven_optimal_are_told_apart(monkeypatch: pytest.MonkeyPatch) -> None:
    gap = np.array([0.0, 0.2, np.nan, np.nan])
    scans = series(4, gap=gap, proven=gap == 0, reports=np.array([3.0, 3.0, 3.0, 0.0]))
    sheet = drawn(monkeypatch, Scene(report_table(9), track_table(1)), scans)
    axes = sheet.figure.axes[3]
    words = [text.get_text() for text in axes.get_legend().get_texts()]
    assert words == ["proven optimal (1)", "still open (1)", "not known (1)"]
    assert axes.get_yticklabels()[0].get_text() == "0"


def test_what_is_best_of_what_was_kept_is_not_drawn_as_proven(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    gap, proven = np.array([0.0, 0.0, 0.2]), np.array([True, False, False])
    scans = series(3, gap=gap, proven=proven, reports=np.full(3, 3.0))
    sheet = drawn(monkeypatch, Scene(report_table(9), track_table(1)), scans)
    words = [text.get_text() for text in sheet.figure.axes[3].get_legend().get_texts()]
    assert words == ["proven optimal (1)", "optimal among kept (1)", "still open (1)"]


def test_very_many_tracks_become_a_band(monkeypatch: pytest.MonkeyPatch) -> None:
    few = drawn(monkeypatch, Scene(report_table(9), track_table(5)), series())
    many = drawn(monkeypatch, Scene(report_table(9), track_table(100)), series())
    speeds = few.figure.axes[-1], many.figure.axes[-1]
    assert speeds[0].get_legend() is None
    assert [text.get_text() for text in speeds[1].get_legend().get_texts()] == [
        "10–90 % of tracks",
        "median",
    ]


@pytest.mark.parametrize("n_scans", [1, 2])
def test_draws_a_run_without_tracks_and_time(n_scans: int) -> None:
    nothing = TrackTable.empty(2)
    scans = series(n_scans, tracks=nothing, gap=np.full(n_scans, np.nan), cpu_ms=None)
    assert picture_of_run(Scene(None, nothing), scans).startswith(b"\x89PNG")


def test_counts_each_status_at_each_time() -> None:
    times, counts = counts_by_status(track_table(4))
    assert times.tolist() == list(range(12))
    assert counts[0].tolist() == [4, 0, 0]
    assert counts[5].tolist() == [0, 4, 0]
    assert counts[11].tolist() == [0, 0, 4]


def test_very_many_scans_are_drawn_as_means_of_neighbours() -> None:
    n = 1000
    counts = np.stack([np.zeros(n), np.arange(n) % 2, np.ones(n)], axis=1).astype(int)
    when, mean = _panels._thinned(np.arange(n, dtype=float), counts)
    assert len(when) == _panels.MOST_STEPS
    assert when[:3].tolist() == [0.0, 5.0, 10.0]
    np.testing.assert_allclose(mean.sum(), counts.sum() / 5)
    assert mean[:, 2].tolist() == [1.0] * len(when)


def test_few_scans_are_drawn_each() -> None:
    counts = np.array([[0, 1, 2], [3, 4, 5]])
    when, mean = _panels._thinned(np.array([7.0, 9.0]), counts)
    assert when.tolist() == [7.0, 9.0]
    assert mean.tolist() == counts.tolist()
    assert _panels._thinned(np.empty(0), np.empty((0, 3), dtype=int))[0].size == 0


@pytest.mark.parametrize(
    ("begin", "step", "label", "unit_s"),
    [
        (0.0, 1.0, "time [s]", 1.0),
        (0.0, 100.0, "time [min]", 60.0),
        (50.0, 4000.0, "time [h]", 3600.0),
        (5000.0, 1.0, "time from 5000 s [s]", 1.0),
        (1.6e9, 1.0, "time from 2020-09-13 12:26:40 UTC [s]", 1.0),
    ],
)
def test_writes_times_so_that_they_can_be_read(
    begin: float, step: float, label: str, unit_s: float
) -> None:
    axis = time_axis(series(time=begin + step * np.arange(12)))
    assert (axis.label, axis.unit_s) == (label, unit_s)


def test_one_stray_stamp_squeezes_no_curve(monkeypatch: pytest.MonkeyPatch) -> None:
    time = np.append(np.arange(99.0), 1e6)
    scans = series(100, time=time)
    axis = time_axis(scans)
    assert (axis.label, axis.unit_s) == ("time [s], 1 scans beyond", 1.0)
    canvas = drawn(monkeypatch, Scene(None, track_table(1)), scans)
    low, high = canvas.figure.axes[1].get_xlim()
    assert low < 0.0
    assert 98.0 < high < 110.0


def test_no_stamp_of_a_few_is_stray() -> None:
    axis = time_axis(series(3, time=np.array([0.0, 1.0, 5000.0])))
    assert "beyond" not in axis.label


def test_dates_are_written_as_dates() -> None:
    axis = time_axis(series(iso_time=True))
    assert axis.label == "time from 1970-01-01 00:00:00 UTC [s]"


def test_refuses_another_format() -> None:
    with pytest.raises(InvalidInputError, match="file_format: 'jpg'"):
        picture_of_run(Scene(None, TrackTable.empty(2)), None, "jpg")


def test_gaps_of_any_size_fit_on_the_axis() -> None:
    assert _panels.LEAST_GAP > 0
    gap = np.array([0.0, 1e-14, 1e9, 0.1])
    scene = Scene(None, track_table(1))
    assert picture_of_run(scene, series(4, gap=gap, proven=gap == 0))
