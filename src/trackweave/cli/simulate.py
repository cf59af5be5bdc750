"""The command ``simulate``."""

from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from trackweave.cli.edge import Voice
from trackweave.errors import InvalidInputError
from trackweave.io.encoding import encode_table
from trackweave.io.frames_out import reports_frame, truth_frame
from trackweave.io.output import OutputDirectory
from trackweave.simulation import Simulation, read_scenario, simulate

__all__ = ["run_simulate", "simulated_tables"]


def run_simulate(voice: Voice, scenario: Path, out: Path, seed: int | None) -> dict[str, Any]:
    """Simulate a scenario file and write reports and truth; return how many."""
    place = OutputDirectory(out, "simulate")
    place.check([scenario])
    planned = read_scenario(scenario)
    if seed is None:
        seed = planned.seed
    scene = simulate(planned, np.random.default_rng(seed))
    if len(scene.reports) == 0:
        raise InvalidInputError(
            f"{scenario}: no report comes of it; expected targets that a sensor sees, or false "
            "alarms"
        )
    found = {
        "reports": len(scene.reports),
        "false_alarms": int(np.sum(np.asarray(scene.reports.carried["target"]) == "")),
        "targets": len(set(scene.truth.target.tolist())),
        "seed": seed,
    }
    record = {"trackweave": version("trackweave"), "scenario": scenario.name, "totals": found}
    place.write(simulated_tables(scene), record)
    voice.say(
        f"{found['reports']} reports, {found['false_alarms']} of them false alarms, of "
        f"{found['targets']} targets: {out}"
    )
    return {**found, "out": str(out)}


def simulated_tables(scene: Simulation) -> dict[str, bytes]:
    """Return the files of a simulation."""
    return {
        "reports.csv": encode_table(reports_frame(scene.reports), "reports.csv"),
        "truth.csv": encode_table(truth_frame(scene.truth), "truth.csv"),
    }
