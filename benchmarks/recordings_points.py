"""Recordings of positions: a ferry's sensors, cells, a ship's radar."""

from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
from names_kept import HEAD, judged
from recordings_data import Followed, Run, by_hand, example, follow, root_mean_square, run
from recordings_formats import cells as read_cells
from scipy.optimize import linear_sum_assignment
from text_tables import table

from trackweave.domain.truth import TruthTable
from trackweave.metrics import assignment_quality

SCENARIOS = (2, 4, 13, 16)
SENSORS = (["radar"], ["radar", "lidar"], ["radar", "lidar", "ir", "eo"])
NEAR_M = 20.0
SEEN_WITHIN_S = 2.0


def autoferry(data: Path) -> str:
    """Return the table of Autoferry: how each reference vessel was followed."""
    reader, rows = example("autoferry"), []
    for number in SCENARIOS:
        reports, truth = reader.read(data / "autoferry" / f"scenario{number}")
        for sensors in SENSORS:
            chosen = reports.filter(pl.col("sensor").is_in(sensors))
            chosen = chosen[[one.name for one in chosen if one.null_count() < len(one)]]
            there = _seen(chosen, truth)
            for one in _both("autoferry", chosen):
                label = [number, " + ".join(sensors), one.name]
                if one.result is None:
                    rows.append([*label, one.refused[:60], *["–"] * 7])
                    continue
                rows.append([*label, *_vessels(one, truth, there), one.cpu])
    head = ["scenario", "sensors", "configuration", "Havfruen %", "other %"]
    head += ["afterwards %", "seen %", "RMSE m", "switches", "tracks at a time", "CPU s"]
    return table(head, rows)


def _both(name: str, reports: pl.DataFrame) -> list[Run]:
    return [run("none", reports, None), run(f"`{name}.toml`", reports, by_hand(name))]


def _truth_table(truth: pl.DataFrame) -> TruthTable:
    return TruthTable.from_columns(
        truth["time"].to_numpy(), truth["target"].to_list(), truth.select("x", "y").to_numpy()
    )


def _vessels(one: Run, truth: pl.DataFrame, there: str) -> list[Any]:
    assert one.result is not None
    values = one.result.values
    true = _truth_table(truth)
    followed = _followed(values.tracks, true, NEAR_M)
    after = _followed(values.history, true, NEAR_M)
    errors = [error for each in followed.values() for error in each.errors or []]
    live = values.tracks.status >= 1
    n_times = np.unique(values.tracks.time).size
    return [
        *(f"{100 * followed[name].share:.0f}" for name in ("havfruen", "other")),
        " ".join(f"{100 * after[name].share:.0f}" for name in ("havfruen", "other")), there,
        root_mean_square(errors), sum(each.switches for each in followed.values()),
        round(float(live.sum()) / n_times, 1),
    ]  # fmt: skip


def _followed(tracks: Any, truth: TruthTable, near: float) -> dict[str, Followed]:
    # A turn of the radar takes 1.7 s; rows of several sensors come closer together.
    return follow(truth, tracks, near, 4.0)


def _seen(reports: pl.DataFrame, truth: pl.DataFrame) -> str:
    """Return for each vessel the share of time at which a recent position was its own.

    One report is of one vessel, so that two boats in one plot are seen only once.
    """
    names = ("havfruen", "other")
    seen: dict[str, list[float]] = {name: [] for name in names}
    for (moment, _), scan in reports.drop_nulls("x").group_by("time", "sensor"):
        place = {name: _place(truth, name, float(moment)) for name in names}
        there = [name for name in names if place[name] is not None]
        where = np.array([place[name] for name in there]).reshape(-1, 2)
        apart = np.linalg.norm(where[:, None] - scan.select("x", "y").to_numpy()[None], axis=2)
        for row, column in zip(*linear_sum_assignment(np.minimum(apart, 1e3)), strict=True):
            if apart[row, column] < NEAR_M:
                seen[there[row]].append(float(moment))
    shares = []
    for name in names:
        times = truth.filter(pl.col("target") == name)["time"].to_numpy()
        moments = np.array(sorted(seen[name]))
        before = np.searchsorted(moments, times, side="right") - 1
        recent = (before >= 0) & (times - moments[before.clip(0)] < SEEN_WITHIN_S)
        shares.append(f"{100 * recent.mean():.0f}")
    return " ".join(shares)


def _place(truth: pl.DataFrame, name: str, moment: float) -> Any:
    own = truth.filter(pl.col("target") == name)
    if not own["time"][0] <= moment <= own["time"][-1]:
        return None
    return [np.interp(moment, own["time"], own[axis]) for axis in ("x", "y")]


def cells(data: Path) -> str:
    """Return the table of cells: whether the reports of each are given to one track."""
    reports, _ = read_cells(data / "cell_btrack")
    true = reports["target"].fill_null("").to_list()
    rows = []
    for one in _both("cells", reports):
        if one.result is None:
            rows.append([one.name, one.refused, *["–"] * 4])
            continue
        values = one.result.values
        found = np.full(len(reports), -1)
        for row, number in values.assignment.items():
            found[int(values.reports.report[row]) - 1] = number
        quality = assignment_quality(true, found)
        n_tracks = np.unique(found[found >= 0]).size
        rows.append(
            [
                one.name, f"{quality.idf1 or 0:.3f}", f"{quality.purity or 0:.4f}", n_tracks,
                int(np.count_nonzero(found < 0)), one.cpu,
            ]
        )  # fmt: skip
    head = ["configuration", "IDF1 of reports", "purity", "tracks", "reports on no track", "CPU s"]
    return table(head, rows)


def evening(data: Path) -> str:
    """Return the table of an evening at Barcelona's radar: whether aircraft keep their names."""
    reports = pl.read_csv(data / "radar_bcn" / "radar_bcn_20_24h.csv")
    return table(["configuration", *HEAD], [["none", *judged(reports, {})]])


def joyride(data: Path) -> str:
    """Return the table of the joyride: how the boat was followed."""
    reports, truth = example("joyride").read(data / "ntnu_joyride" / "joyride.mat")
    rows = []
    for one in _both("joyride", reports):
        if one.result is None:
            rows.append([one.name, one.refused, *["–"] * 6])
            continue
        values = one.result.values
        true = _truth_table(truth)
        row: list[Any] = [one.name]
        for tracks in (values.tracks, values.history):
            boat = follow(true, tracks, 50.0, 8.0)["boat"]
            row += [f"{100 * boat.share:.1f}", root_mean_square(boat.errors or []), boat.switches]
        confirmed = np.unique(values.tracks.track[values.tracks.status >= 1]).size
        rows.append([*row, confirmed, one.cpu])
    head = ["configuration", "tracked %", "RMSE m", "switches"]
    head += ["afterwards %", "RMSE m", "switches", "tracks", "CPU s"]
    return table(head, rows)
