"""Stone Soup's objects in and out."""

import runpy
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

import trackweave as tw

pytest.importorskip("stonesoup", reason="needs the extra stonesoup")

from stonesoup.models.measurement.linear import LinearGaussian
from stonesoup.models.measurement.nonlinear import CartesianToBearingRange
from stonesoup.types.detection import Detection
from stonesoup.types.groundtruth import GroundTruthPath, GroundTruthState
from stonesoup.types.update import GaussianStateUpdate

from trackweave.adapters.stonesoup import StoneSoupTracker, reports_of, tracks_of, truth_of
from trackweave.errors import InvalidInputError

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "stone_soup.py"
BEGIN = datetime(2024, 5, 1, 12)
LINEAR = LinearGaussian(4, (0, 2), np.diag([4.0, 9.0]))
CONFIG = {
    "motion": {"process_noise": 0.1, "max_speed": 30.0},
    "sensors": {"default": {
        "sigma": 3.0, "detection_probability": 0.95, "clutter_density": 1e-7, "scan_period": 1.0,
    }},
    "lifecycle": {"new_target_density": 1e-6},
}  # fmt: skip


def scene(n: int = 20) -> list[tuple[datetime, list[Detection]]]:
    """Two objects, at 10 m/s to the east, 200 m apart."""
    rng = np.random.default_rng(4)
    return [
        (
            BEGIN + timedelta(seconds=k),
            [
                Detection(
                    [10.0 * k + rng.normal(0, 2), 200.0 * which + rng.normal(0, 3)],
                    timestamp=BEGIN + timedelta(seconds=k),
                    measurement_model=LINEAR,
                )
                for which in range(2)
            ],
        )
        for k in range(n)
    ]


@pytest.mark.slow
def test_detections_are_tracked_and_come_back_as_updates():
    detections = [each for _, some in scene() for each in some]
    reports = reports_of(detections)
    assert reports.select("sigma_x", "sigma_y").row(0) == (2.0, 3.0)
    tracks = tracks_of(tw.track(reports, CONFIG), detections)
    assert len(tracks) == 2
    for track in tracks:
        assert sum(isinstance(state, GaussianStateUpdate) for state in track) >= 18
        last = track[-1]
        assert last.timestamp == BEGIN + timedelta(seconds=19)
        assert last.state_vector.ravel()[:2] == pytest.approx([190.0, 10.0], abs=6.0)
        assert last.hypothesis.measurement in detections


def test_a_truth_is_what_results_are_compared_with():
    paths = {
        GroundTruthPath(
            [
                GroundTruthState([10.0 * k, 10.0, 200.0 * which, 0.0],
                                 timestamp=BEGIN + timedelta(seconds=k))
                for k in range(20)
            ]
        )
        for which in range(2)
    }  # fmt: skip
    reports = reports_of([each for _, some in scene() for each in some])
    assert tw.track(reports, CONFIG).evaluate(truth_of(paths)).n_found == 2


def test_bearings_count_clockwise_from_north_here():
    model = CartesianToBearingRange(
        4, (0, 2), np.diag([np.radians(0.5) ** 2, 100.0]), translation_offset=[[5.0], [7.0]]
    )
    seen = Detection([np.radians(30.0), 100.0], timestamp=BEGIN, measurement_model=model)
    row = reports_of([seen]).row(0, named=True)
    assert (row["azimuth_deg"], row["range_m"]) == pytest.approx((60.0, 100.0))
    assert (row["sigma_azimuth_deg"], row["sigma_range_m"]) == pytest.approx((0.5, 10.0))
    assert (row["sensor_x"], row["sensor_y"]) == (5.0, 7.0)


def test_what_cannot_be_understood_is_refused():
    with pytest.raises(InvalidInputError, match="expected positions"):
        reports_of([Detection([1.0], timestamp=BEGIN)])
    with pytest.raises(InvalidInputError, match="expected a datetime"):
        reports_of([Detection([1.0, 2.0], timestamp=None)])


def test_the_example_judges_our_tracks_by_their_metric(capsys):
    main = runpy.run_path(str(EXAMPLE))["main"]
    main()
    assert capsys.readouterr().out.startswith("2 tracks; GOSPA at most ")


def test_our_tracker_iterates_as_stone_soups_do():
    steps = scene()
    steps[7] = (steps[7][0], [])
    tracker = StoneSoupTracker(detector=[(t, set(some)) for t, some in steps], config=CONFIG)
    times, counts = [], []
    for time, tracks in tracker:
        times.append(time)
        counts.append(len(tracks))
    assert times == [t for t, _ in steps]
    assert counts[-1] == 2
    assert all(len(track) >= 15 for track in tracker.tracks)
    assert {track[-1].timestamp for track in tracker.tracks} == {times[-1]}


def test_axes_of_a_detection_are_those_that_its_model_says() -> None:
    swapped = LinearGaussian(4, (2, 0), np.diag([4.0, 9.0]))
    found = Detection([[1.0], [2.0]], timestamp=datetime(2024, 1, 1), measurement_model=swapped)
    row = reports_of([found]).row(0, named=True)
    assert (row["x"], row["y"], row["sigma_x"], row["sigma_y"]) == (2.0, 1.0, 3.0, 2.0)


def test_noise_that_is_correlated_between_axes_is_refused() -> None:
    model = LinearGaussian(4, (0, 2), np.array([[4.0, 3.0], [3.0, 4.0]]))
    found = Detection([[1.0], [2.0]], timestamp=datetime(2024, 1, 1), measurement_model=model)
    with pytest.raises(InvalidInputError, match="correlated between axes"):
        reports_of([found])


@pytest.mark.parametrize("given", [[1], 5, [None]])
def test_what_are_no_detections_are_refused(given: object) -> None:
    with pytest.raises(InvalidInputError, match=r"detections.*; expected .*Detection"):
        reports_of(given)  # type: ignore[arg-type]


def test_fewer_detections_than_reports_are_refused() -> None:
    every = [each for _, detections in scene() for each in detections]
    result = tw.track(reports_of(every), CONFIG)
    with pytest.raises(
        InvalidInputError, match=r"detections: 5 of them, of \d+ reports; expected"
    ):
        tracks_of(result, every[:5])


def test_times_that_go_backwards_are_refused() -> None:
    steps = scene(3)
    tracker = StoneSoupTracker(detector=[steps[1], steps[0]], config=CONFIG)
    next(tracker)
    with pytest.raises(InvalidInputError, match="1 s before the one yielded last; expected times"):
        next(tracker)
