"""Recordings: where they lie, how they are read, and a run on them with identities hidden."""

import argparse
import importlib.util
import time
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import polars as pl
from bench_data import BESIDE
from scipy.optimize import linear_sum_assignment

from trackweave import track
from trackweave.domain.truth import TruthTable
from trackweave.metrics import align
from trackweave.run import TrackingResult

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"
CONFIGURATIONS = Path(__file__).with_name("recordings")
HIDDEN = ["target", "identity"]


@dataclass(frozen=True)
class Run:
    """A run, or why there is none."""

    name: str
    result: TrackingResult | None
    cpu: float
    refused: str = ""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Let a script be told where the recordings lie."""
    parser.add_argument(
        "--recordings", type=Path, default=BESIDE / "data", help="folder of the recordings"
    )


def example(name: str) -> ModuleType:
    """Return a reader out of ``examples/``."""
    path = EXAMPLES / f"{name}.py"
    spec = importlib.util.spec_from_file_location(f"example_{name}", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def by_hand(name: str) -> Mapping[str, Any]:
    """Return a configuration that was made with the recording in view."""
    text = (CONFIGURATIONS / f"{name}.toml").read_text(encoding="utf-8")
    return tomllib.loads(text)


def run(name: str, reports: pl.DataFrame, configuration: Mapping[str, Any] | None) -> Run:
    """Track reports without the columns that say whose they are."""
    shown = reports.drop(HIDDEN, strict=False)
    if configuration is not None:
        # A configuration may name more sensors than this table has.
        there = set(reports["sensor"].unique()) if "sensor" in reports.columns else set()
        sensors = configuration.get("sensors", {})
        kept = {key: value for key, value in sensors.items() if key in there | {"default"}}
        configuration = {**configuration, "sensors": kept}
    begun = time.process_time()
    try:
        result = track(shown, configuration, rng=np.random.default_rng(1))
    except Exception as error:  # one table that fails must not hide the others
        return Run(name, None, 0.0, f"{type(error).__name__}: {error}")
    return Run(name, result, time.process_time() - begun)


@dataclass
class Followed:
    """How one target was followed."""

    n_times: int = 0
    errors: list[float] | None = None
    tracks: list[int] | None = None

    def enter(self, track_number: int | None, error: float) -> None:
        """Note one time, ``None`` where no track was near."""
        self.n_times += 1
        self.errors, self.tracks = self.errors or [], self.tracks or []
        if track_number is not None:
            self.errors.append(error)
            self.tracks.append(track_number)

    @property
    def share(self) -> float:
        """Share of its times at which a track was near."""
        return len(self.errors or []) / max(self.n_times, 1)

    @property
    def switches(self) -> int:
        """How often its track was another than the last."""
        return int(np.count_nonzero(np.diff(self.tracks or [])))


def follow(truth: TruthTable, tracks: Any, cutoff: float, max_gap: float) -> dict[str, Followed]:
    """Return for each target how it was followed: one track a target, kept while near."""
    moments = align(truth, tracks, max_gap)
    names = np.unique(truth.target.astype(str)).tolist()  # the order of their numbers
    followed = {name: Followed() for name in names}
    kept: dict[int, int] = {}
    for moment in moments:
        distance = np.where(moment.distance < cutoff, moment.distance, 10 * cutoff)
        for target, number in kept.items():
            pair = np.ix_(moment.targets == target, moment.tracks == number)
            # A pair of the time before stays one while it is near.
            distance[pair] = np.where(distance[pair] < cutoff, distance[pair] - 5 * cutoff, 1e9)
        rows, columns = linear_sum_assignment(distance) if distance.size else ([], [])
        pairs = {
            int(moment.targets[row]): column
            for row, column in zip(rows, columns, strict=True)
            if moment.distance[row, column] < cutoff
        }
        for row, target in enumerate(moment.targets.tolist()):
            column = pairs.get(target)
            one = followed[names[target]]
            if column is None:
                one.enter(None, np.nan)
            else:
                number = int(moment.tracks[column])
                one.enter(number, float(moment.distance[row, column]))
                kept[target] = number
    return followed


def root_mean_square(errors: list[float]) -> float | None:
    """Return the root of the mean square, None of nothing."""
    return float(np.sqrt(np.mean(np.square(errors)))) if errors else None
