"""Positions that a turning beam made count as the ranges and azimuths that it measured."""

import json
import subprocess
import sys

import numpy as np
import polars as pl
import pytest

import trackweave as tw
from run.turning_radar import on_a_plane, radar
from trackweave.domain.frames import LocalFrame
from trackweave.run.cartesian_to_polar import as_measured
from trackweave.run.polar_to_cartesian import laid

pytestmark = pytest.mark.slow

AT, HIGH = (4e3, -7e3), 350.0
TOLD = {"measurement": "range-azimuth", "position": [*AT, HIGH]}


@pytest.mark.parametrize("frame", [None, (47.0, 8.0)])
@pytest.mark.parametrize("height", [None, [9_000.0, None, 350.0]])
def test_what_was_taken_apart_is_laid_where_it_was(frame, height):
    place = np.array([[30e3, 40e3], [-50e3, 2e3], [4e3, -6e3]])
    columns = {"time": [1.0, 2.0, 3.0]}
    if frame is None:
        columns |= {"x": place[:, 0], "y": place[:, 1]}
    else:
        latitude, longitude, _ = LocalFrame(*frame).to_geodetic(place)
        columns |= {"lat": latitude, "lon": longitude}
    if height is not None:
        columns["height_m"] = height
    reports = tw.read_reports(pl.DataFrame(columns), frame_origin=frame)
    apart = as_measured(reports, lambda _: TOLD)
    assert apart.kinds == (tw.MeasurementKind.RANGE_AZIMUTH,)
    on_plane, _ = laid(apart, {"default": (*AT, HIGH)})
    away = np.stack(
        [np.sin(on_plane.measurement[:, 1]), np.cos(on_plane.measurement[:, 1])], axis=1
    )
    assert AT + on_plane.measurement[:, :1] * away == pytest.approx(place, abs=0.05)


def test_a_beam_s_positions_have_the_noise_of_ranges_and_azimuths():
    table = radar()
    result = tw.track(on_a_plane(table, 40e3, 10e3).drop("target"))
    used = result.run["configuration"]["sensors"]["default"]
    assert used["measurement"] == "range-azimuth"
    assert used["position"] == pytest.approx([40e3, 10e3], abs=20)
    assert used["sigma"]["range_m"] == pytest.approx(60, rel=0.15)
    assert used["sigma"]["azimuth_deg"] == pytest.approx(0.12, rel=0.15)
    sources = result.run["sources"]
    assert sources["sensors.default.measurement"] == "estimated"
    assert any("ranges and azimuths that a beam which turns" in n for n in result.run["notes"])
    measured = tw.track(table.drop("target"), {"sensors": {"default": {"position": [0, 0]}}})
    assert result.assignments["track"].equals(measured.assignments["track"])


@pytest.mark.parametrize(
    "told", [{"sigma": 100.0}, {"rotation": "none"}, {"measurement": "position"}, {"trust": True}]
)
def test_who_speaks_of_positions_has_positions(told):
    told = {"position": [40e3, 10e3], **told}
    result = tw.track(
        on_a_plane(radar(n_turns=12), 40e3, 10e3).drop("target"), {"sensors": {"default": told}}
    )
    assert result.run["configuration"]["sensors"]["default"]["measurement"] == "position"


def test_a_configuration_as_used_makes_the_same_tracks_again():
    table = on_a_plane(radar(n_turns=30), 40e3, 10e3).drop("target")
    first = tw.track(table)
    again = tw.track(table, first.run["configuration"])
    assert again.tracks.equals(first.tracks)
    assert again.assignments.equals(first.assignments)


def test_the_command_reads_what_init_wrote(tmp_path):
    reports, told = tmp_path / "reports.csv", tmp_path / "told.toml"
    on_a_plane(radar(n_turns=30), 40e3, 10e3).drop("target").write_csv(reports)
    for command in (
        ["init", reports, "--out", told],
        ["track", reports, "--config", told, "--out", tmp_path / "out"],
    ):
        done = subprocess.run(
            [sys.executable, "-m", "trackweave", *map(str, command)],
            capture_output=True,
            text=True,
        )
        assert done.returncode == 0, done.stderr
    assert 'measurement = "range-azimuth"' in told.read_text()
    record = json.loads((tmp_path / "out/run.json").read_bytes())
    assert record["totals"]["tracks"] == 12
