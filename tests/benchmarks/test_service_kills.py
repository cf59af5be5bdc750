"""The study of kills finds nothing where all is well, and something where it is not."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"
LYING = """
import sys
import service_kills as study
study.MortalDisk.sync = lambda self, handle: None
study.MOMENTS = 40
sys.exit(study.main())
"""


def run(*command):
    env = {**os.environ, "PYTHONPATH": os.pathsep.join([str(BENCHMARKS), *sys.path])}
    return subprocess.run(
        [sys.executable, *command], capture_output=True, text=True, check=False, env=env
    )


@pytest.mark.slow
def test_a_few_kills_lose_nothing_and_change_nothing():
    done = run(str(BENCHMARKS / "service_kills.py"), "--kills", "10", "--seed", "3")
    assert done.returncode == 0, done.stdout + done.stderr
    assert "kills: 10, power cuts: " in done.stdout
    assert "acknowledged records lost or trackers changed: 0" in done.stdout


@pytest.mark.slow
def test_a_disk_that_does_not_sync_is_found_out():
    done = run("-c", LYING, "--kills", "30", "--seed", "3")
    assert done.returncode == 1
    assert "acknowledged, and" in done.stdout
