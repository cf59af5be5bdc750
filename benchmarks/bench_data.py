"""The shared bench: its scenes over several seeds, and its judge.

The bench is a folder with ``gen.py``, which makes scenes, and ``score.py``, which judges tracks.
Nothing of it is copied in; scenes are made once into a cache folder.
"""

import argparse
import contextlib
import importlib.util
import io
import json
import os
import tempfile
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

BESIDE = Path(__file__).resolve().parent.parent.parent / "shared"
CACHE = Path(tempfile.gettempdir()) / "trackweave-benchmarks"


@dataclass(frozen=True)
class Scene:
    """One scene of the bench: the columns of its files as arrays, and what its maker knows."""

    name: str
    targets: int
    sensors: int
    seed: int
    detections: Any
    priors: Any
    meta: dict[str, Any]

    @property
    def n_scans(self) -> int:
        """Number of instants."""
        return int(self.meta["scans"])


class Bench:
    """Scenes and judge of the bench in a folder."""

    def __init__(self, folder: Path, cache: Path) -> None:
        self._folder = folder
        self._cache = cache

    def scene(self, targets: int, sensors: int, repeat: int) -> Scene:
        """Return the scene of a size and repetition, 1 and up; the first is the bench's own."""
        name = f"T{targets}_S{sensors}_r{repeat}"
        seed = 1000 * targets + (10 if sensors > 1 else 0) + repeat
        place = self._cache / "data" / name
        if not (place / "meta.json").exists():
            generator = _module(self._folder / "gen.py")
            generator.HERE = str(self._cache)
            with contextlib.redirect_stdout(io.StringIO()):
                generator.gen(name, targets, sensors, seed)
        return Scene(
            name=name, targets=targets, sensors=sensors, seed=seed,
            detections=_table(place / "detections.csv"), priors=_table(place / "priors.csv"),
            meta=json.loads((place / "meta.json").read_text(encoding="utf-8")),
        )  # fmt: skip

    def score(self, scene: Scene, rows: list[tuple[int, int, float, float]]) -> dict[str, float]:
        """Judge rows of scan, track, x, y; see the bench's own page for the measures."""
        os.environ["BENCH_DATA"] = str(self._cache / "data")
        judged: dict[str, float] = _module(self._folder / "score.py").score(scene.name, rows)
        return judged


def add_arguments(parser: argparse.ArgumentParser, seeds: int = 5) -> None:
    """Let a script be told where the bench lies and how many seeds to run."""
    parser.add_argument("--bench", type=Path, default=BESIDE / "bench", help="folder of the bench")
    parser.add_argument("--cache", type=Path, default=CACHE, help="folder for what is made")
    parser.add_argument("--seeds", type=int, default=seeds, help="scenes of each size")
    parser.add_argument("--first", type=int, default=1, help="number of the first scene, 1 and up")


def repeats(arguments: argparse.Namespace) -> range:
    """Return the numbers of the scenes to run."""
    return range(arguments.first, arguments.first + arguments.seeds)


def bench_of(arguments: argparse.Namespace) -> Bench:
    """Return the bench that the arguments name; exit where there is none."""
    if not (arguments.bench / "gen.py").exists():
        raise SystemExit(f"{arguments.bench}: no gen.py there; name the bench with --bench")
    arguments.cache.mkdir(parents=True, exist_ok=True)
    return Bench(arguments.bench, arguments.cache)


def _module(path: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location(f"bench_{path.stem}", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def _table(path: Path) -> Any:
    return np.genfromtxt(path, delimiter=",", names=True)
