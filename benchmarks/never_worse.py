"""Our multi-hypothesis tracker beside our nearest-neighbour tracker, configured alike, everywhere.

Each row is a scene or recording under what is told of it. Rows are kept in a CSV file, so that
they can be measured one at a time (``--only``), and the table is that of all rows kept.
"""

import argparse
import csv
import time
import tomllib
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import recordings_boxes as boxes_of
from bench_data import CACHE, Bench, add_arguments
from eight_scenes import MUST, NEAREST, made, ways
from recordings_data import HIDDEN, Run, by_hand, example, follow
from recordings_data import add_arguments as add_recordings
from recordings_formats import cells, kitti_detections, kitti_truth, mot_detections, mot_truth
from recordings_points import NEAR_M, SENSORS, _truth_table
from runs import CONFIGURATION, configuration_for, reports_of, rows_of
from text_tables import command, heading, table

from trackweave import track
from trackweave.metrics import assignment_quality

SEED = 11
SCENARIOS = (2, 4, 13, 16)
BOAT_M, BOAT_GAP_S = 50.0, 8.0
COLUMNS = ("row", "figure", "default", "nearest-neighbour", "reports", "cpu")
# A difference counts from here on: of an IDF1 or share, and of a distance relative to it.
NOISE, NOISE_OF_DISTANCE = 0.01, 0.02
Row = tuple[str, Any, Mapping[str, Any], Callable[[Any], float]]
"""Figure, reports, what is told, and the figure of a result."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    add_arguments(parser)
    add_recordings(parser)
    parser.add_argument("--only", nargs="+", default=[], help="rows whose name holds one of these")
    parser.add_argument("--kept", type=Path, default=CACHE / "never_worse.csv")
    parser.add_argument("--anew", action="store_true", help="measure again what is kept")
    arguments = parser.parse_args()
    kept = _kept(arguments.kept)
    for name, make in rows(arguments).items():
        wanted = not arguments.only or any(part in name for part in arguments.only)
        if wanted and (arguments.anew or name not in kept):
            kept[name] = measured(name, make)
            _keep(arguments.kept, kept)
            print(*kept[name].values(), sep="  ", flush=True)
    print(heading(command("never_worse.py")), end="\n\n")
    head = ["scene or recording, and what is told", "figure", *COLUMNS[2:4], "beside it"]
    lines = [_cells(kept[name]) for name in rows(arguments) if name in kept]
    print(table([*head, "reports", "CPU s, default"], lines))


def _cells(row: Mapping[str, str]) -> list[str]:
    ours, nearest = float(row["default"]), float(row["nearest-neighbour"])
    is_distance = row["figure"] == "GOSPA"
    lead = nearest - ours if is_distance else ours - nearest
    noise = NOISE_OF_DISTANCE * nearest if is_distance else NOISE
    word = "level" if abs(lead) <= noise else "better" if lead > 0 else "**worse**"
    shown = (f"{value:.1f}" if is_distance else f"{value:.3f}" for value in (ours, nearest))
    return [row["row"], row["figure"], *shown, word, row["reports"], row["cpu"]]


def measured(name: str, make: Callable[[], Row]) -> dict[str, str]:
    """Return a row: both trackers' figure."""
    figure, reports, told, judged = make()
    begun = time.process_time()
    ours = judged(track(reports, told, rng=np.random.default_rng(1)))
    spent = time.process_time() - begun
    nearest = judged(track(reports, {**told, **NEAREST}, rng=np.random.default_rng(1)))
    values = (name, figure, f"{ours:.5f}", f"{nearest:.5f}", str(len(reports)), f"{spent:.1f}")
    return dict(zip(COLUMNS, values, strict=True))


def rows(arguments: argparse.Namespace) -> dict[str, Callable[[], Row]]:
    """Return all rows by name, the quick ones first; each is made when it is measured."""
    return dict([*_recordings(arguments.recordings), *_simulated(arguments.bench)])


Named = Iterator[tuple[str, Callable[[], Row]]]


def _recordings(data: Path) -> Named:
    for number in SCENARIOS:
        for sensors in SENSORS[:2]:
            name = f"Autoferry {number}, {' and '.join(sensors)}"
            yield name, partial(_autoferry, data / "autoferry" / f"scenario{number}", sensors)
    yield "joyride, nothing", partial(_joyride, data, {})
    yield "joyride, `joyride.toml`", partial(_joyride, data, by_hand("joyride"))
    yield "cells, nothing", partial(_cells_of, data, {})
    yield "cells, `cells.toml`", partial(_cells_of, data, by_hand("cells"))
    yield "TUD-Campus, nothing", partial(_people, data, {})
    yield "TUD-Campus, `tud_campus.toml`", partial(_people, data, by_hand("tud_campus"))
    for sequence in ("0000", "0002"):
        for kind in ("Car", "Pedestrian"):
            name = f"KITTI {sequence}, {kind.lower()}s"
            yield f"{name}, nothing", partial(_street, data, sequence, kind)
    yield "OpenSky, nothing", partial(_aircraft, data, {})
    told = tomllib.loads(Path(__file__).with_name("opensky.toml").read_text(encoding="utf-8"))
    yield "OpenSky, `opensky.toml`", partial(_aircraft, data, told)
    yield "radar_bcn, an hour, nothing", partial(_radar, data)


def _simulated(folder: Path) -> Named:
    bench = Bench(folder, CACHE)
    for targets in (20, 50):
        yield f"bench T{targets}, all", partial(_bench, bench, targets)
    if not (folder / "gen_cases.py").exists():
        return
    scenes = made(folder, "gen_cases.py", f"s{SEED}", ["--seed", str(SEED)])
    for scene in MUST:
        for words, told in ways(scenes / scene):
            yield f"{scene}, {words}", partial(_scene, scenes / scene, told)
    options = ["--ships", "80", "--minutes", "60", "--seed", str(SEED)]
    ships = made(folder, "gen_ais.py", f"ais-80-{SEED}", options)
    yield "80 ships, nothing", partial(_scene, ships, {})
    options = ["--aircraft", "60", "--radars", "2", "--minutes", "6", "--seed", str(SEED)]
    sky = made(folder, "gen_sky.py", f"sky-{SEED}", options)
    yield "sky, places and periods", partial(_scene, sky, _radars(sky, whole=False))
    yield "sky, places, periods and noise", partial(_scene, sky, _radars(sky, whole=True))


def _scene(folder: Path, told: Mapping[str, Any]) -> Row:
    reports = pl.read_csv(folder / "reports.csv", schema_overrides={"target": pl.String})
    return _of_reports(reports, told)


def _radars(folder: Path, *, whole: bool) -> Mapping[str, Any]:
    told: dict[str, dict[str, Any]] = {}
    for radar in pl.read_csv(folder / "radars.csv").iter_rows(named=True):
        own = {"position": [radar["x"], radar["y"]], "scan_period": radar["scan_period"]}
        sigma = {key: radar[f"sigma_{key}"] for key in ("range_m", "azimuth_deg")}
        told[radar["sensor"]] = {**own, "sigma": sigma} if whole else own
    return {"sensors": told}


def _of_reports(reports: pl.DataFrame, told: Mapping[str, Any]) -> Row:
    true = reports["target"].fill_null("").to_list()

    def judged(result: Any) -> float:
        found = result.assignments["track"].fill_null(-1).to_numpy()
        return assignment_quality(true, found).idf1 or 0.0

    return "IDF1 of reports", reports.drop(HIDDEN, strict=False), told, judged


def _radar(data: Path) -> Row:
    reports = pl.read_csv(data / "radar_bcn" / "radar_bcn_20_24h.csv")
    hour = reports.filter(pl.col("time") < pl.col("time").min() + 3600)
    height = (pl.col("flight_level") * 30.48).alias("height_m")
    hour = hour.with_columns(height).drop("flight_level", "mode_3a", "radar_track")
    return _of_reports(hour, {})


def _aircraft(data: Path, told: Mapping[str, Any]) -> Row:
    reports = pl.read_csv(data / "opensky" / "OpenSky_Plane_States.csv")
    columns = reports.select("time", "lat", "lon", pl.col("icao24").alias("target"))
    return _of_reports(columns, told)


def _cells_of(data: Path, told: Mapping[str, Any]) -> Row:
    reports, _ = cells(data / "cell_btrack")
    return _of_reports(reports, told)


def _autoferry(folder: Path, sensors: list[str]) -> Row:
    reports, truth = example("autoferry").read(folder)
    chosen = reports.filter(pl.col("sensor").is_in(sensors))
    chosen = chosen[[one.name for one in chosen if one.null_count() < len(one)]]
    true = _truth_table(truth)

    def judged(result: Any) -> float:
        # A turn of the radar takes 1.7 s; rows of several sensors come closer together.
        followed = follow(true, result.values.tracks, NEAR_M, 4.0)
        return float(np.mean([each.share for each in followed.values()]))

    shown = chosen.drop(HIDDEN, strict=False)
    return "share of time tracked", shown, {}, judged


def _joyride(data: Path, told: Mapping[str, Any]) -> Row:
    reports, truth = example("joyride").read(data / "ntnu_joyride" / "joyride.mat")
    true = _truth_table(truth)

    def judged(result: Any) -> float:
        return follow(true, result.values.tracks, BOAT_M, BOAT_GAP_S)["boat"].share

    shown = reports.drop(HIDDEN, strict=False)
    return "share of time tracked", shown, told, judged


def _people(data: Path, told: Mapping[str, Any]) -> Row:
    folder = data / "mot_tud_campus"
    reports = boxes_of.cornered(mot_detections(folder / "dets" / "det" / "det.txt"))
    truth = boxes_of.true_boxes(boxes_of.cornered(mot_truth(folder / "gt.txt")))
    return _of_boxes(reports, told, truth)


def _street(data: Path, sequence: str, kind: str) -> Row:
    folder = data / "kitti" / sequence
    truth = boxes_of.judged(kitti_truth(folder, kind))
    spared = partial(boxes_of.spared, ignored=boxes_of.ignored(folder, kind))
    return _of_boxes(kitti_detections(folder, kind), {}, truth, spared)


def _of_boxes(
    reports: pl.DataFrame, told: Mapping[str, Any], truth: Any, spared: Any = None
) -> Row:
    def judged(result: Any) -> float:
        run, shift = Run("", result, 0.0), spared is None
        found = truth, boxes_of.tracked_boxes(run, reports, rule="seen", shift=shift)
        return float(boxes_of.judge(*(spared(*found) if spared else found))[1]) / 100.0

    return "IDF1 of boxes", reports.drop(HIDDEN, strict=False), told, judged


def _bench(bench: Bench, targets: int) -> Row:
    scene = bench.scene(targets, 1, 1)

    def judged(result: Any) -> float:
        return float(bench.score(scene, rows_of(result))["gospa"])

    told = configuration_for(scene, CONFIGURATION, {})
    return "GOSPA", reports_of(scene), told, judged


def _kept(path: Path) -> dict[str, dict[str, str]]:
    if not path.exists():
        return {}
    with path.open(newline="", encoding="utf-8") as file:
        return {row["row"]: row for row in csv.DictReader(file)}


def _keep(path: Path, kept: Mapping[str, Mapping[str, str]]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        writer.writerows(kept.values())


if __name__ == "__main__":
    main()
