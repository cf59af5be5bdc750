"""Cells that divide: tracks and lineages, judged by traccuracy, beside laptrack and btrack."""

import argparse
import logging
import os
import tempfile
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
from bench_data import BESIDE
from dividing_cells import simulated
from dividing_peers import by_btrack, by_laptrack
from recordings_data import by_hand
from recordings_formats import cells
from text_tables import command, heading, table

import trackweave as tw
from trackweave.formats.format import Output
from trackweave.formats.registry import format_named

HEAD = ["sequence", "tracker", "DET", "TRA", "LNK", "CT", "divisions found", "wrong", "CPU s"]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, nargs="+", default=[11, 12, 13])
    parser.add_argument("--recordings", type=Path, default=BESIDE / "data")
    arguments = parser.parse_args()
    try:
        import traccuracy  # noqa: F401 a peer, which is not there everywhere
    except ImportError:
        print("Skipped: needs traccuracy (see dividing_peers.py for it and the peers).")
        return
    warnings.simplefilter("ignore")
    logging.disable(logging.WARNING)
    os.environ["TQDM_DISABLE"] = "1"
    rows = []
    for seed in arguments.seeds:
        truth, detections = simulated(seed)
        rows += judged(f"seed {seed}", truth, detections, None)
    folder = arguments.recordings / "cell_btrack"
    if folder.is_dir():
        truth = cells_truth(folder)
        rows += judged("cell_btrack", truth, cells(folder)[0], by_hand("cells"))
    print(heading(command("dividing.py").partition(" --recordings")[0]), end="\n\n")
    print(table(HEAD, rows))


def judged(
    name: str, truth: pl.DataFrame, detections: pl.DataFrame, told: dict[str, Any] | None
) -> list[list[Any]]:
    """Return a row for each tracker on the same detections."""
    found = detections.select("time", "x", "y")
    methods: dict[str, Callable[[], pl.DataFrame]] = {
        "trackweave, nothing told": lambda: ours(found, {})
    }
    if told is not None:
        methods["trackweave, `cells.toml`"] = lambda: ours(found, told)
    methods |= {"laptrack": lambda: by_laptrack(found), "btrack": lambda: by_btrack(found)}
    rows = []
    for method, follow in methods.items():
        begin = time.process_time()
        try:
            tracks = follow()
        except ImportError:
            continue
        spent = time.process_time() - begin
        rows.append([name, method, *measures(truth, tracks), spent])
    return rows


def ours(detections: pl.DataFrame, told: dict[str, Any]) -> pl.DataFrame:
    """Return our tracks, after the fact, with ``divide = true``."""
    told = {**told, "lifecycle": {**told.get("lifecycle", {}), "divide": True}}
    history = tw.track(detections, told).history
    return history.filter(pl.col("status") != "tentative").select(
        "time", "track", "parent", "x", "y"
    )


def measures(truth: pl.DataFrame, tracks: pl.DataFrame) -> list[Any]:
    """Return what traccuracy says of Cell Tracking Challenge folders."""
    from traccuracy import run_metrics
    from traccuracy.loaders import load_ctc_data
    from traccuracy.matchers import CTCMatcher, IOUMatcher
    from traccuracy.metrics import CompleteTracks, CTCMetrics, DivisionMetrics

    with tempfile.TemporaryDirectory() as place:
        graphs = []
        for name, states in (("true", truth), ("found", tracks)):
            folder = painted(states, Path(place) / name)
            graphs.append(
                load_ctc_data(str(folder), str(folder / "res_track.txt"), name, run_checks=False)
            )
        in_images_of_one_size(graphs)
        results, _ = run_metrics(*graphs, CTCMatcher(), [CTCMetrics()])
        metrics = [CompleteTracks(), DivisionMetrics(max_frame_buffer=2)]
        results += run_metrics(*graphs, IOUMatcher(0.25, one_to_one=True), metrics)[0]
    ctc, whole, split = (one["results"] for one in results)
    split = split["Frame Buffer 2"]
    n_true = split["Total GT Divisions"]
    return [
        *(f"{ctc[name]:.4f}" for name in ("DET", "TRA", "LNK")),
        f"{whole['complete_tracklets']:.2f}",
        f"{split['True Positive Divisions']} of {n_true}", split["False Positive Divisions"],
    ]  # fmt: skip


def painted(states: pl.DataFrame, folder: Path) -> Path:
    """Write tracks as a folder of the challenge."""
    writer = format_named("ctc", writes=True).writer
    assert writer is not None
    for name, data in writer(Output(states)).items():
        path = folder / name.partition("/")[2]
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
    return folder


def in_images_of_one_size(graphs: list[Any]) -> None:
    """Widen images to the largest: each is as large as its own tracks need."""
    shape = np.max([graph.segmentation.shape for graph in graphs], axis=0)
    # Frames count the times that there are: all have to be there.
    assert len({graph.segmentation.shape[0] for graph in graphs}) == 1
    for graph in graphs:
        pairs = zip(shape, graph.segmentation.shape, strict=True)
        more = [(0, int(most - own)) for most, own in pairs]
        graph.segmentation = np.pad(graph.segmentation, more)


def cells_truth(folder: Path) -> pl.DataFrame:
    """Return the true states of btrack's recording, with the mother of each cell."""
    import json

    graph = json.loads((folder / "test_graph.json").read_text(encoding="utf-8"))
    mothers = {int(child): mother[0] for child, mother in graph.items()}
    states = cells(folder)[1].with_columns(track=pl.col("target").cast(pl.Int64))
    column = pl.col("track").replace_strict(mothers, default=None, return_dtype=pl.Int64)
    return states.select("time", "track", column.alias("parent"), "x", "y")


if __name__ == "__main__":
    main()
