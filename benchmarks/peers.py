"""Stone Soup's JPDA and GNN on the bench, on the same seeds as our own tracker.

Needs ``stonesoup`` and ``pyehm``, which need not live beside trackweave:

    python3 -m venv peers && peers/bin/pip install stonesoup pyehm
    peers/bin/python benchmarks/peers.py

Both are told what the scenes were made with: noise, detection probability, clutter density, the
motion and noisy states of all targets at the first scan; no track is begun or ended. Results are
kept in the cache folder, where ``tracking.py`` finds them.

JPDA's hypotheses can grow without bound where many targets share reports: one scene took 24 GB.
Each run is therefore a process of its own with bounded memory and time, and one that exceeds a
bound counts as not finished.
"""

import argparse
import datetime
import importlib.util
import json
import multiprocessing
import resource
import sys
import time
from typing import Any

import numpy as np
from bench_data import Bench, Scene, add_arguments, bench_of, repeats
from text_tables import command, heading, table

METHODS = ("JPDA", "GNN")
GATE_PROBABILITY = 0.9999
MOST_MEMORY = 3 * 1024**3
MOST_SECONDS = 180
START = datetime.datetime(2000, 1, 1)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    add_arguments(parser)
    parser.add_argument("--targets", type=int, nargs="+", default=[20, 50, 100])
    parser.add_argument("--again", action="store_true", help="measure anew what is in the cache")
    arguments = parser.parse_args()
    bench = bench_of(arguments)
    kept = arguments.cache / "peers.json"
    results: dict[str, Any] = json.loads(kept.read_text()) if kept.exists() else {}
    for targets in arguments.targets:
        for repeat in repeats(arguments):
            for method in METHODS:
                key = f"{method} T{targets} r{repeat}"
                if key in results and not arguments.again:
                    continue
                if not _installed():
                    print("Skipped: needs stonesoup and pyehm (pip install stonesoup pyehm).")
                    return
                results[key] = bounded(bench, bench.scene(targets, 1, repeat), method)
                kept.write_text(json.dumps(results, indent=1))
                print(key, results[key], file=sys.stderr, flush=True)
    print(heading(command("peers.py")), end="\n\n")
    print(per_seed(results, arguments))


def per_seed(results: dict[str, Any], arguments: argparse.Namespace) -> str:
    """Return one row per scene, then the means."""
    head = ["scene"]
    for method in METHODS:
        head += [f"{method} GOSPA", "switches", "missed", "false", "RMSE m", "CPU ms/scan"]
    names = ("gospa", "switches", "missed_per_scan", "false_per_scan", "rmse", "cpu_ms")
    rows = []
    for targets in arguments.targets:
        cells = []
        for repeat in repeats(arguments):
            found = [results[f"{method} T{targets} r{repeat}"] for method in METHODS]
            cells.append(
                [float(result[name]) if result else np.nan for result in found for name in names]
            )
            rows.append([f"T{targets} r{repeat}", *_readable(cells[-1])])
        rows.append([f"**T{targets} mean**", *_readable(np.mean(cells, axis=0).tolist())])
    return table(head, rows)


def _readable(values: list[float]) -> list[float | str]:
    return ["not finished" if np.isnan(value) else value for value in values]


def bounded(bench: Bench, scene: Scene, method: str) -> dict[str, float] | None:
    """Return a method's measures on a scene, None where it exceeds its memory or time."""
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe(duplex=False)
    child = context.Process(target=_child, args=(theirs, bench, scene, method))
    child.start()
    theirs.close()
    found: dict[str, float] | None = None
    try:
        if ours.poll(MOST_SECONDS):
            found = ours.recv()
    except EOFError:
        pass
    if child.is_alive() and found is None:
        child.kill()
    child.join()
    return found


def _child(answer: Any, bench: Bench, scene: Scene, method: str) -> None:
    # Before anything is imported: an allocation beyond it fails here and starves nobody else.
    resource.setrlimit(resource.RLIMIT_AS, (MOST_MEMORY, MOST_MEMORY))
    resource.setrlimit(resource.RLIMIT_CPU, (MOST_SECONDS, MOST_SECONDS))
    answer.send(judged(bench, scene, method))


def judged(bench: Bench, scene: Scene, method: str) -> dict[str, float]:
    """Return a method's measures on a scene."""
    begun = time.process_time()
    rows = _track(scene, method)
    cpu = time.process_time() - begun
    return {**bench.score(scene, rows), "cpu_ms": 1e3 * cpu / scene.n_scans}


def _installed() -> bool:
    return all(importlib.util.find_spec(name) is not None for name in ("stonesoup", "pyehm"))


def _track(scene: Scene, method: str) -> list[tuple[int, int, float, float]]:
    from stonesoup.types.detection import Detection

    associator, updater, model = _associator(scene, method)
    tracks = _tracks(scene)
    rows = []
    for scan in range(scene.n_scans):
        now = START + datetime.timedelta(seconds=float(scan))
        found = scene.detections[scene.detections["scan"] == scan]
        detections = {
            Detection([[x], [y]], timestamp=now, measurement_model=model)
            for x, y in zip(found["x"], found["y"], strict=True)
        }
        hypotheses = associator.associate(set(tracks), detections, now)
        for number, track in enumerate(tracks):
            track.append(_updated(hypotheses[track], updater))
            x, _, y, _ = np.asarray(track.state_vector, dtype=float).ravel()
            rows.append((scan, number, x, y))
    return rows


def _associator(scene: Scene, method: str) -> tuple[Any, Any, Any]:
    from pyehm.plugins.stonesoup import JPDAWithEHM2
    from stonesoup.dataassociator.neighbour import GNNWith2DAssignment
    from stonesoup.hypothesiser.probability import PDAHypothesiser
    from stonesoup.models.measurement.linear import LinearGaussian
    from stonesoup.models.transition.linear import (
        CombinedLinearGaussianTransitionModel,
        ConstantVelocity,
    )
    from stonesoup.predictor.kalman import KalmanPredictor
    from stonesoup.updater.kalman import KalmanUpdater

    meta = scene.meta
    motion = CombinedLinearGaussianTransitionModel([ConstantVelocity(meta["q"])] * 2)
    model = LinearGaussian(4, (0, 2), np.diag([meta["sigma"] ** 2] * 2))
    updater = KalmanUpdater(model)
    hypothesiser = PDAHypothesiser(
        predictor=KalmanPredictor(motion), updater=updater,
        clutter_spatial_density=meta["clutter_density"], prob_detect=meta["pd"],
        prob_gate=GATE_PROBABILITY,
    )  # fmt: skip
    kind = JPDAWithEHM2 if method == "JPDA" else GNNWith2DAssignment
    return kind(hypothesiser), updater, model


def _tracks(scene: Scene) -> list[Any]:
    from stonesoup.types.state import GaussianState
    from stonesoup.types.track import Track

    tracks = []
    for prior in scene.priors:
        mean = [[prior[name]] for name in ("x", "vx", "y", "vy")]
        spread = np.diag([prior[name] for name in ("p_x", "p_vx", "p_y", "p_vy")])
        tracks.append(Track([GaussianState(mean, spread, timestamp=START)]))
    return tracks


def _updated(hypothesis: Any, updater: Any) -> Any:
    """Return the state after a scan; over several hypotheses, their moment-matched mixture."""
    from stonesoup.functions import gm_reduce_single
    from stonesoup.types.array import StateVectors
    from stonesoup.types.multihypothesis import MultipleHypothesis
    from stonesoup.types.update import GaussianStateUpdate

    if not isinstance(hypothesis, MultipleHypothesis):
        return updater.update(hypothesis) if hypothesis else hypothesis.prediction
    states = [updater.update(single) if single else single.prediction for single in hypothesis]
    mean, covariance = gm_reduce_single(
        StateVectors([state.state_vector for state in states]),
        np.stack([state.covar for state in states], axis=2),
        np.array([float(single.probability) for single in hypothesis]),
    )
    any_prediction = hypothesis[0].prediction
    return GaussianStateUpdate(mean, covariance, hypothesis, any_prediction.timestamp)


if __name__ == "__main__":
    main()
