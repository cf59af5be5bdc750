"""A run starts soon: what it does not use is neither imported nor compiled."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

HEAVY = (
    "matplotlib", "pandas", "pyarrow", "rich", "narwhals", "highspy", "pymap3d", "scipy.stats",
    "scipy.spatial", "scipy.optimize", "scipy.sparse",
)  # fmt: skip
OURS = (
    "trackweave.plotting", "trackweave.fusion", "trackweave.simulation", "trackweave.studies",
    "trackweave.metrics", "trackweave.solvers.genetic", "trackweave.solvers.ants",
    "trackweave.solvers.m_best", "trackweave.solvers.warming", "trackweave.trackers.fused_plots",
    "trackweave.trackers.nearest_neighbour", "trackweave.association._plots",
)  # fmt: skip
COMPLETE = """
[motion]
process_noise = 0.1
max_speed = 30.0
[sensors.default]
sigma = 5.0
detection_probability = 0.9
clutter_density = 1e-6
scan_period = 1.0
[lifecycle]
new_target_density = 1e-8
initial_target_density = 1e-5
delete_after_misses = 5
"""
RUN = """
import json, sys
from trackweave.cli import main
try:
    main()
except SystemExit as end:
    assert not end.code
print(json.dumps(sorted(sys.modules)))
"""


def modules_of_a_run(folder: Path, *options: str) -> set[str]:
    """Track a small file in a process of its own and return the modules that it imported."""
    rows = [f"{time},{10 * time + place},{place}" for time in range(8) for place in (0, 300, 700)]
    reports = folder / "reports.csv"
    reports.write_text("\n".join(["time,x,y", *rows]) + "\n", encoding="utf-8")
    words = ["track", str(reports), "--out", str(folder / "out"), "--quiet", *options]
    done = subprocess.run(
        [sys.executable, "-c", RUN, *words],
        env=dict(os.environ),
        capture_output=True,
        text=True,
        check=True,
    )
    return set(json.loads(done.stdout.splitlines()[-1]))


@pytest.fixture(scope="module")
def modules(tmp_path_factory: pytest.TempPathFactory) -> set[str]:
    folder = tmp_path_factory.mktemp("complete")
    (folder / "tracker.toml").write_text(COMPLETE, encoding="utf-8")
    return modules_of_a_run(folder, "--config", str(folder / "tracker.toml"))


@pytest.mark.parametrize("name", [*HEAVY, *OURS])
def test_a_configured_run_does_not_import(modules: set[str], name: str) -> None:
    assert "trackweave.trackers.multi_hypothesis" in modules
    assert name not in modules


def test_estimating_from_few_reports_takes_nothing_of_scipy(tmp_path: Path) -> None:
    modules = modules_of_a_run(tmp_path)
    # Numba itself finds LAPACK in scipy.linalg.
    parts = {f"scipy.{part}" for part in ("optimize", "sparse", "spatial", "special")}
    assert not modules & {*parts, "matplotlib", "narwhals", *OURS}
