"""Pictures of runs."""

from trackweave.plotting.run import figure_of_run, picture_of_run
from trackweave.plotting.scene import ScanSeries, Scene

__all__ = ["ScanSeries", "Scene", "figure_of_run", "picture_of_run"]
