"""The examples of the page on extending run, from Python and named in a file."""

import re
import tomllib
from pathlib import Path

import polars as pl
import pytest

import trackweave as tw
from oracles.plugin_site import installed

PAGE = Path(__file__).resolve().parents[2] / "docs" / "how-to" / "extending.md"


def blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", PAGE.read_text(), flags=re.DOTALL)


def test_every_example_in_python_runs() -> None:
    known: dict[str, object] = {"__name__": "extending"}
    for code in blocks("python"):
        exec(compile(code, str(PAGE), "exec", dont_inherit=True), known)
    assert {"Drifting", "Distance", "Patient"} <= known.keys()


@pytest.fixture
def package(tmp_path: Path):
    """Install what the page shows as the package that its entry points name."""
    folder = tmp_path / "my_package"
    folder.mkdir()
    (folder / "__init__.py").write_text("")
    code = "\n".join(blocks("python"))
    for name in ("drifting", "distance"):
        (folder / f"{name}.py").write_text(code)
    points: dict[str, dict[str, str]] = {}
    for text in blocks("toml"):
        points |= tomllib.loads(text).get("project", {}).get("entry-points", {})
    with installed(tmp_path, points):
        yield


@pytest.mark.usefixtures("package")
def test_what_the_page_names_in_files_tracks() -> None:
    told: dict[str, object] = {}
    for text in blocks("toml"):
        told |= {key: value for key, value in tomllib.loads(text).items() if key != "project"}
    sensors = dict(told["sensors"])  # type: ignore[call-overload]
    sensors["radar"] = {
        "sigma": 5.0, "detection_probability": 0.9, "clutter_density": 1e-7, "scan_period": 2.0,
    }  # fmt: skip
    rows = [(2.0 * k, "radar", 100.0 + k, 40.0, None, None, None) for k in range(12)]
    rows += [
        (2.0 * k + 1, "beacons", None, None, ((100.5 + k) ** 2 + 260.0**2) ** 0.5, 0.0, 300.0)
        for k in range(12)
    ]
    columns = ["time", "sensor", "x", "y", "distance_m", "beacon_x", "beacon_y"]
    reports = pl.DataFrame(rows, schema=columns, orient="row")
    result = tw.track(reports, {**told, "sensors": sensors})
    assert result.reports["track"].n_unique() == 1
    assert result.run["configuration"]["motion"]["fading"] == 30.0
