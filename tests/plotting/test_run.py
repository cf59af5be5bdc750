"""Tests of the picture of a run."""

import io
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import matplotlib as mpl
import matplotlib.image
import numpy as np
import pytest

from trackweave.domain.reports import ReportTable
from trackweave.domain.tracks import COASTING, CONFIRMED, TENTATIVE, TrackTable
from trackweave.domain.truth import TruthTable
from trackweave.plotting import _canvas
from trackweave.plotting import run as module
from trackweave.plotting._canvas import Canvas, open_canvas
from trackweave.plotting.run import Scene, picture_of_run


def report_table(n: int, dim: int = 2, extent: float = 1000.0) -> ReportTable:
    rng = np.random.default_rng(1)
    return ReportTable(
        np.sort(rng.uniform(0, 60, n)),
        np.zeros(n, dtype=np.int64),
        ("radar",),
        rng.uniform(0, extent, (n, dim)),
        np.full((n, dim), 10.0),
        np.arange(1, n + 1).astype(str),
    )


def track_table(n_tracks: int, n_rows: int = 12, dim: int = 2) -> TrackTable:
    rng = np.random.default_rng(2)
    n = n_tracks * n_rows
    time = np.tile(np.arange(n_rows, dtype=float), n_tracks)
    velocity = np.repeat(rng.normal(0, 30, (n_tracks, dim)), n_rows, axis=0)
    place = np.repeat(rng.uniform(0, 1000, (n_tracks, dim)), n_rows, axis=0)
    mean = np.concatenate([place + time[:, None] * velocity, velocity], axis=1)
    status = np.where(time < 2, TENTATIVE, np.where(time > 9, COASTING, CONFIRMED))
    covariance = np.tile(np.diag([400.0, 100.0, 25.0, 9.0, 4.0, 4.0][: 2 * dim]), (n, 1, 1))
    track = np.repeat(np.arange(1, n_tracks + 1), n_rows)
    return TrackTable(time, track, status, mean, covariance, -time, track, time)


def truth_table(dim: int = 2) -> TruthTable:
    times = np.arange(10.0)
    places = [np.stack([times * 40 + k] + [times * 20] * (dim - 1), axis=1) for k in (0, 300)]
    return TruthTable.from_columns(
        np.tile(times, 2), ["a"] * 10 + ["b"] * 10, np.concatenate(places)
    )


def pixels(picture: bytes) -> np.ndarray:
    return matplotlib.image.imread(io.BytesIO(picture), format="png")[:, :, :3]


@pytest.fixture
def canvas(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[Canvas]]:
    """Yield the sheets that are opened, to look at what is drawn on them."""
    opened: list[Canvas] = []

    def watched(places: np.ndarray, **options: Any) -> Canvas:
        opened.append(open_canvas(places, **options))
        return opened[-1]

    monkeypatch.setattr(module, "open_canvas", watched)
    return iter([opened])


def drawn(scene: Scene, canvas: Iterator[list[Canvas]]) -> Canvas:
    opened = next(canvas)
    picture_of_run(scene)
    return opened[0]


def legend(sheet: Canvas) -> list[str]:
    return [text.get_text() for text in sheet.figure.legends[0].get_texts()]


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("n_tracks", [0, 1, 9, 300])
@pytest.mark.parametrize("truth", [True, False])
def test_draws_whatever_there_is(dim: int, n_tracks: int, truth: bool) -> None:
    tracks = track_table(n_tracks, dim=dim) if n_tracks else TrackTable.empty(dim)
    picture = picture_of_run(
        Scene(report_table(80, dim), tracks, truth_table(dim) if truth else None)
    )
    assert picture.startswith(b"\x89PNG")
    assert pixels(picture).std() > 0.01


@pytest.mark.parametrize("n_reports", [0, 1])
def test_draws_a_scene_of_nothing_or_one_report(n_reports: int) -> None:
    assert pixels(picture_of_run(Scene(report_table(n_reports), TrackTable.empty(2)))).size


def test_draws_reports_that_all_lie_at_one_far_place() -> None:
    reports = report_table(5)
    reports.measurement[:] = 1e9
    assert pixels(picture_of_run(Scene(reports, TrackTable.empty(2)))).size


def test_the_same_scene_gives_the_same_bytes_whatever_the_users_style() -> None:
    scene = Scene(report_table(50), track_table(4), truth_table(), {0: 1, 7: 2}, {"r": (0.0, 5.0)})
    first = picture_of_run(scene)
    with mpl.rc_context({"axes.facecolor": "black", "font.size": 30, "lines.linewidth": 9}):
        assert picture_of_run(scene) == first
    assert b"matplotlib" not in first.lower()


def test_leaves_no_figures_and_settings_behind() -> None:
    before = dict(mpl.rcParams)
    picture_of_run(Scene(report_table(5), track_table(1)))
    assert dict(mpl.rcParams) == before


def test_axes_have_equal_scales_in_metres_or_kilometres(canvas: Iterator[list[Canvas]]) -> None:
    sheet = drawn(Scene(report_table(50, extent=90_000.0), TrackTable.empty(2)), canvas)
    box = sheet.axes.get_window_extent()
    (left, right), (bottom, top) = sheet.axes.get_xlim(), sheet.axes.get_ylim()
    assert box.width / (right - left) == pytest.approx(box.height / (top - bottom))
    assert sheet.axes.get_xlabel() == "x, east [km]"
    assert right - left < 120
    assert open_canvas(np.array([[0.0, 0.0], [100.0, 4000.0]])).unit_m == 1.0


@pytest.mark.parametrize("corner", [(1000.0, 1.0), (1.0, 1000.0), (0.0, 700.0), (0.0, 0.0)])
def test_the_sheet_shows_every_place_and_stays_a_page(corner: tuple[float, float]) -> None:
    sheet = open_canvas(np.array([(0.0, 0.0), corner]))
    paper = sheet.on_paper(np.array([(0.0, 0.0), corner]))
    size = np.array(sheet.figure.get_size_inches())
    assert paper.min() > 0
    assert np.all(paper < size * 72)
    assert size.max() < 13


def test_the_legend_counts_reports_false_alarms_truth_and_tracks(
    canvas: Iterator[list[Canvas]],
) -> None:
    scene = Scene(report_table(50), track_table(3), truth_table(), {0: 1, 7: 2}, {"r": (0.0, 5.0)})
    words = legend(drawn(scene, canvas))
    expected = ["tracks (3)", "false alarms (48)", "reports of tracks (2)", "truth (2)", "sensors"]
    assert words[:5] == expected
    assert "95 % ellipse" in words


def test_without_assignments_reports_are_just_reports(canvas: Iterator[list[Canvas]]) -> None:
    sheet = drawn(Scene(report_table(50), TrackTable.empty(2)), canvas)
    assert legend(sheet) == ["reports"]


def test_writes_each_identifier_once_but_not_hundreds(canvas: Iterator[list[Canvas]]) -> None:
    sheet = drawn(Scene(report_table(50), track_table(9)), canvas)
    assert sorted(text.get_text() for text in sheet.axes.texts) == list("123456789")


def test_very_many_tracks_go_without_identifiers(canvas: Iterator[list[Canvas]]) -> None:
    sheet = drawn(Scene(report_table(50), track_table(300)), canvas)
    assert len(sheet.axes.texts) == 0
    assert "95 % ellipse" not in legend(sheet)


def test_neighbouring_colours_differ_in_a_grey_print() -> None:
    # Luminance, which is what a grey print keeps.
    weights = np.array([0.299, 0.587, 0.114])
    rgb = np.array([mpl.colors.to_rgb(colour) for colour in _canvas.COLOURS])
    grey = rgb @ weights
    assert np.abs(grey - np.roll(grey, 1)).min() > 0.1


def test_coasting_ellipses_are_outlines_that_fade(canvas: Iterator[list[Canvas]]) -> None:
    tracks = track_table(1)
    status = tracks.status.copy()
    status[-4:] = COASTING
    sheet = drawn(Scene(report_table(5), replace(tracks, status=status)), canvas)
    ellipses = next(c for c in sheet.axes.collections if hasattr(c, "get_widths"))
    fill, outline = ellipses.get_facecolor()[:, 3], ellipses.get_edgecolor()[:, 3]
    # From the track's end backwards.
    assert fill[0] == 0.0
    assert fill[-1] > 0.0
    assert outline[0] < outline[1] <= outline[-1]


def test_tentative_rows_are_not_drawn(canvas: Iterator[list[Canvas]]) -> None:
    sheet = drawn(Scene(report_table(5), track_table(1)), canvas)
    lengths = [
        len(line.get_xdata()) for line in sheet.axes.lines if line.get_linestyle() != "None"
    ]
    assert lengths == [10]


def test_an_ellipse_is_as_long_as_95_per_cent_asks(canvas: Iterator[list[Canvas]]) -> None:
    sheet = drawn(Scene(report_table(5), track_table(1)), canvas)
    ellipses = next(c for c in sheet.axes.collections if hasattr(c, "get_widths"))
    # Variances 400 and 100 m²: half axes are 2.4477 sigma.
    assert ellipses.get_widths() == pytest.approx(2 * 2.4477 * 20, rel=1e-4)
    assert ellipses.get_heights() == pytest.approx(2 * 2.4477 * 10, rel=1e-4)
    assert np.abs(np.sin(np.radians(ellipses.get_angles()))) == pytest.approx(0.0, abs=1e-9)
