"""A run as one page."""

import base64
import gzip
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cli.conftest import run  # noqa: F401 a fixture
from cli.run_directory import write_run
from trackweave.io.run_files import read_run
from trackweave.run.drawing import scene_of, series_of
from trackweave.service.picture import content, page_of_run

HOSTILE = "</script><img src=x onerror=alert(1)>\"'\u202egnp\u0000"


def page_of(directory: Path, title: str = "a run") -> str:
    files = read_run(directory)
    scene = scene_of(files, None, "the run", history=False, pixels=False)
    return page_of_run(files, scene, series_of(files), title).decode()


def content_of(page: str) -> dict[str, Any]:
    (packed,) = re.findall(r'id="run">([^<]*)</script>', page)
    return json.loads(gzip.decompress(base64.b64decode(packed)))


def summed(steps: list[int], parts: list[int]) -> np.ndarray:
    ends = np.cumsum(parts)
    return np.concatenate([np.cumsum(part) for part in np.split(steps, ends[:-1])])


def test_the_page_is_of_the_run_and_the_same_each_time(run, tmp_path: Path) -> None:  # noqa: F811
    directory = write_run(tmp_path / "run")
    pages = []
    for name in ("one.html", "two.HTML"):
        done = run("plot", directory, "-o", tmp_path / name, "--reports", tmp_path / "reports.csv")
        assert done.exit_code == 0, done.stderr
        pages.append((tmp_path / name).read_bytes())
    assert pages[0] == pages[1]
    assert pages[0].startswith(b"<!doctype html>")
    assert b"<title>run \xe2\x80\x93 trackweave</title>" in pages[0]


def test_rows_of_tracks_come_back(tmp_path: Path) -> None:
    directory = write_run(tmp_path / "run")
    found, table = content_of(page_of(directory)), read_run(directory).tracks
    assert [(track["id"], track["n"], track["hits"]) for track in found["tracks"]] == [
        ("1", 6, 6), ("2", 6, 0),
    ]  # fmt: skip
    parts, rows = [6, 6], found["rows"]
    order = np.lexsort((table.time, table.track))
    np.testing.assert_allclose(summed(rows["time"], parts) * found["unit_s"], table.time[order])
    np.testing.assert_allclose(summed(rows["x"], parts) * found["unit"], table.mean[order, 0])
    np.testing.assert_allclose(summed(rows["vy"], parts) / 100, table.mean[order, 3])
    assert rows["status"] == table.status[order].tolist()
    sigma = np.exp(summed(rows["sy"], parts) / 50)
    np.testing.assert_allclose(sigma, np.sqrt(table.covariance[order, 1, 1]), rtol=0.02)


def test_reports_know_their_tracks_and_sensors(run, tmp_path: Path) -> None:  # noqa: F811
    directory = write_run(tmp_path / "run")
    out = tmp_path / "picture.html"
    run("plot", directory, "-o", out, "--reports", tmp_path / "reports.csv")
    reports = content_of(out.read_text())["reports"]
    assert np.cumsum(reports["time"]).tolist() == [1000 * time for time in range(6) for _ in "ab"]
    assert sorted(reports["track"]) == [-1] * 6 + [0] * 6
    assert reports["sensor"] == [0, 0, 1, 1] * 3


def test_places_on_the_earth_are_degrees_with_land_around(tmp_path: Path) -> None:
    found = content_of(page_of(write_run(tmp_path / "run", geodetic=True)))
    assert found["geographic"] is True
    assert abs(found["rows"]["x"][0] * found["unit"] + 0.25) < 1e-3
    assert abs(found["rows"]["y"][0] * found["unit"] - 51.5) < 1e-3
    assert len(base64.b64decode(found["coast"])) > 10_000
    assert "coast" not in content_of(page_of(write_run(tmp_path / "plane")))


def test_a_silence_is_a_gap_and_an_end_before_the_runs_an_end(tmp_path: Path) -> None:
    directory = write_run(tmp_path / "run")
    times = [0, 1, 2, 3, 9, 10]
    rows = [f"{time},1,confirmed,0,0,1,0,9,0,9" for time in times]
    rows += [f"{time},2,confirmed,0,0,1,0,9,0,9" for time in range(20)]
    head = (directory / "tracks.csv").read_text().splitlines()[0]
    (directory / "tracks.csv").write_text("\n".join([head, *rows]) + "\n")
    first, second = content_of(page_of(directory))["tracks"]
    assert first["gaps"] == [[4000, 9000]]
    assert first["ended"] == 11_000
    assert (second["gaps"], second["ended"]) == ([], None)


def test_of_very_many_rows_each_so_many_are_in_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(content, "MOST_ROWS", 4)
    found = content_of(page_of(write_run(tmp_path / "run")))
    assert ["Rows drawn", "one of 3"] in found["facts"]
    np.testing.assert_allclose(np.cumsum(found["rows"]["time"][:3]), [0, 3000, 5000])


def test_an_empty_run_is_a_page_too(tmp_path: Path) -> None:
    directory = write_run(tmp_path / "run", scans=[], timing=None)
    for name in ("tracks.csv", "history.csv", "assignments.csv"):
        head = (directory / name).read_text().splitlines()[0]
        (directory / name).write_text(head + "\n")
    assert content_of(page_of(directory))["tracks"] == []


def test_the_page_needs_nothing_from_outside_and_may_fetch_nothing(tmp_path: Path) -> None:
    page = page_of(write_run(tmp_path / "run", geodetic=True))
    assert re.findall(r"(?:src|href|action)\s*=\s*\"(?!data:)", page) == []
    assert re.findall(r"https?://(?!www\.w3\.org/2000/svg)", page) == []
    (policy,) = re.findall(r'Content-Security-Policy" content="([^"]*)"', page)
    assert policy.startswith("default-src 'none'; script-src 'sha256-")
    assert "unsafe" not in policy


def test_hostile_names_stay_text(tmp_path: Path) -> None:
    directory = write_run(tmp_path / "run")
    record = json.loads((directory / "run.json").read_text())
    record["notes"] = [HOSTILE]
    (directory / "run.json").write_text(json.dumps(record))
    page = page_of(directory, HOSTILE)
    assert page.count("</script>") == 2
    assert page.lower().count("<script") == 2
    assert "<img" not in page
    assert "\u202e" not in page
    assert content_of(page)["notes"] == [HOSTILE]


def test_a_name_that_is_no_text_does_no_harm(tmp_path: Path) -> None:
    assert "\ufffd" not in page_of(write_run(tmp_path / "run"), "a\udcff")
