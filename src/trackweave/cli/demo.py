"""The command ``demo``: a newcomer's first sight."""

from pathlib import Path
from typing import Any

import numpy as np

from trackweave.cli.edge import Voice
from trackweave.cli.simulate import simulated_tables
from trackweave.config import load_configuration
from trackweave.io.output import OutputDirectory
from trackweave.metrics import assignment_quality, evaluate
from trackweave.plotting import Scene, picture_of_run
from trackweave.run import TrackingResult, track
from trackweave.run.record import with_seed
from trackweave.simulation import Simulation, demo_configuration, demo_scenario, simulate

__all__ = ["run_demo"]

CUTOFF = 50.0
TIME = "cpu_ms_per_scan"


def run_demo(voice: Voice, out: Path, seed: int | None = None) -> dict[str, Any]:
    """Simulate, track, compare with the truth and write everything; return the comparison."""
    import tomllib

    seed = 1 if seed is None else seed
    place = OutputDirectory(out, "demo")
    place.check()
    scenario = demo_scenario()
    rng = np.random.default_rng(seed)
    scene = simulate(scenario, rng)
    text = demo_configuration(scenario, seed)
    configuration = load_configuration(tomllib.loads(text))
    with voice.progress("tracking") as progress:
        result = track(scene.reports, configuration, rng=rng, progress=progress)
    found = _compare(scene, result)
    positions = {sensor.name: sensor.position for sensor in scenario.sensors if sensor.position}
    picture = picture_of_run(
        Scene(
            reports=scene.reports,
            tracks=result.values.tracks,
            truth=scene.truth,
            assignment=result.values.assignment,
            sensor_positions=positions,
        )
    )
    files = {
        **simulated_tables(scene),
        **result.files(),
        "tracker.toml": text.encode(),
        "demo.png": picture,
    }
    # Its configuration file says the seed.
    record = with_seed(result.run, seed, "file")
    place.write(files, {**record, "evaluation": {k: v for k, v in found.items() if k != TIME}})
    rows = _rows(found)
    line = "; ".join(f"{name} {value}" for name, value in rows[:5])
    voice.table("Three radars, false alarms, misses and a crossing", rows, line)
    voice.say(f"The picture is {out / 'demo.png'}; all files are in {out}.")
    return {**found, "seed": seed, "out": str(out)}


def _compare(scene: Simulation, result: TrackingResult[Any]) -> dict[str, Any]:
    values = result.values
    assigned = [values.assignment.get(row, -1) for row in range(len(scene.reports))]
    quality = assignment_quality(scene.reports.carried["target"], assigned)
    found = evaluate(scene.truth, values.tracks, cutoff=CUTOFF).with_assignments(quality)
    totals, timing = result.run["totals"], result.run["timing"]
    return {
        **found.as_dict(),
        "mean_gap": totals["mean_gap"],
        "worst_gap": totals["worst_gap"],
        "proven_scans": totals["proven_scans"],
        "scans_optimal_among_kept": totals["scans_optimal_among_kept"],
        "scans": totals["scans"],
        TIME: timing["median_cpu_ms"],
    }


def _rows(found: dict[str, Any]) -> list[tuple[str, str]]:
    share, gap = found["right_share"], found["worst_gap"]
    return [
        ("targets found", f"{found['n_found']} of {found['n_truth']}"),
        ("GOSPA (cutoff 50 m)", f"{found['gospa']:.1f} m"),
        ("identity switches", str(found["switches"])),
        ("reports assigned rightly", "–" if share is None else f"{100 * share:.1f} %"),
        ("scans proven optimal", f"{found['proven_scans']} of {found['scans']}"),
        ("scans optimal among kept", str(found["scans_optimal_among_kept"])),
        ("worst gap to the bound", "–" if gap is None else f"{100 * gap:.2g} %"),
        ("time per scan (median)", f"{found['cpu_ms_per_scan']:.1f} ms"),
    ]
