"""Where objects keep together, their distance is no noise: tracks that are likelier say so."""

from dataclasses import dataclass, replace

import numpy as np
import polars as pl
import pytest

import trackweave as tw
from trackweave.config import load_configuration
from trackweave.estimation.estimate import estimate
from trackweave.estimation.estimates import Estimates
from trackweave.metrics import assignment_quality
from trackweave.run.kept import Kept
from trackweave.run.likelier import likelier, told_by_tracks

pytestmark = pytest.mark.slow


def tags(spacing: float, minutes: float = 2.0, every: float = 1.0) -> pl.DataFrame:
    """Return five tags side by side on a winding way, each heard about so often [s], to 3 m."""
    rng, rows = np.random.default_rng(0), []
    for tag in range(5):
        time = rng.uniform(0.0, every)
        while time < 60.0 * minutes:
            place = np.array([spacing * tag + 15.0 * time, 200.0 * np.sin(time / 60.0)])
            rows.append((round(time, 3), *(place + rng.normal(0.0, 3.0, 2)), f"tag {tag}"))
            time += every * (1.0 + rng.normal(0.0, 0.1))
    return pl.DataFrame(rows, schema=["time", "x", "y", "target"], orient="row").sort("time")


def test_tags_that_keep_together_are_told_apart() -> None:
    frame = tags(20.0)
    result = tw.track(frame.drop("target"))
    quality = assignment_quality(frame["target"].to_list(), result.reports["track"].to_list())
    assert quality.idf1 > 0.95
    sensor = result.run["configuration"]["sensors"]["default"]
    assert sensor["sigma"] == pytest.approx(3.0, rel=0.3)


@pytest.mark.parametrize("sigma", [None, 4.0])
def test_a_pack_is_no_single_object_at_which_a_sensor_looks(sigma: float | None) -> None:
    # Each half as far from the next as it goes from report to report: 300 instants of one report.
    frame = tags(50.0, minutes=9.0, every=9.0)
    told = {} if sigma is None else {"sensors": {"default": {"sigma": sigma}}}
    result = tw.track(frame.drop("target"), told)
    quality = assignment_quality(frame["target"].to_list(), result.reports["track"].to_list())
    assert quality.idf1 > 0.85
    (note,) = [note for note in result.run["notes"] if "does not scan" in note]
    assert "as is told" not in note


def test_one_object_alone_stays_one() -> None:
    frame = tags(50.0, minutes=6.0, every=2.0).filter(pl.col("target") == "tag 0")
    result = tw.track(frame.drop("target"))
    assert result.reports["track"].n_unique() == 1
    assert not any("does not scan" in note for note in result.run["notes"])


@pytest.mark.parametrize("missed", [0, 30])
def test_looks_at_even_times_are_not_asked_about_packs(
    missed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    rng, time = np.random.default_rng(2), np.arange(200.0)
    kept = np.sort(rng.permutation(200)[: 200 - missed])
    place = np.column_stack([3.0 * time, time]) + rng.normal(0.0, 2.0, (200, 2))
    frame = pl.DataFrame({"time": time[kept], "x": place[kept, 0], "y": place[kept, 1]})
    reports = tw.read_reports(frame)
    estimates = estimate(reports)
    monkeypatch.setattr("trackweave.run.likelier.likelier", None)
    configuration = load_configuration(None)
    assert told_by_tracks(estimates, reports, configuration, Kept(), {}) is estimates


def test_a_told_noise_of_a_winding_pack_finds_its_process_noise() -> None:
    # Each reports exactly every ten seconds; threads that change cars seem to turn less.
    rng, rows = np.random.default_rng(3), []
    for car in range(5):
        time = np.arange(rng.uniform(0.0, 10.0), 1200.0, 10.0)
        time = time + rng.normal(0.0, 0.2, time.size)
        way = 15.0 * time - 50.0 * car
        place = np.column_stack([way, 40.0 * np.sin(way / 300.0)])
        place += rng.normal(0.0, 3.0, place.shape)
        rows += [(now, *at, str(car)) for now, at in zip(time, place, strict=True)]
    frame = pl.DataFrame(rows, ["time", "x", "y", "target"], orient="row").sort("time")
    result = tw.track(frame.drop("target"), {"sensors": {"default": {"sigma": 3.0}}})
    quality = assignment_quality(frame["target"].to_list(), result.reports["track"].to_list())
    assert quality.idf1 > 0.9


@dataclass(frozen=True)
class Asked:
    """What tags that keep together were found to be, and what it was asked with."""

    reports: tw.ReportTable
    before: Estimates
    kept: Kept
    found: Estimates | None


@pytest.fixture(scope="module")
def asked() -> Asked:
    reports, kept = tw.read_reports(tags(20.0, minutes=1.0).drop("target")), Kept()
    estimates = estimate(reports)
    sensor = replace(estimates.sensors["default"], sigma_height=35.0, height_offset=4.0)
    estimates = replace(estimates, sensors={"default": sensor}, notes=("Echoes are left out.",))
    found = likelier(estimates, reports, load_configuration(None), kept)
    return Asked(reports, estimates, kept, found)


def test_what_else_was_found_out_stays(asked: Asked) -> None:
    found = asked.found
    assert found is not None
    assert found.sensors["default"].sigma_height == 35.0
    assert found.sensors["default"].height_offset == 4.0
    assert found.notes[0] == "Echoes are left out."
    assert len(found.notes) == 2


def test_attempts_of_a_run_take_what_the_first_one_found(
    asked: Asked, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("trackweave.run.likelier.Stretch", None)
    again = likelier(asked.before, asked.reports, load_configuration(None), asked.kept)
    assert again is asked.found


def test_what_is_as_likely_is_left_as_it_was() -> None:
    reports = tw.read_reports(tags(500.0).drop("target"))
    estimates = estimate(reports)
    assert likelier(estimates, reports, load_configuration(None), Kept()) is None
