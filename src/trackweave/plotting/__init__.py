"""Pictures of runs."""

from trackweave.plotting.run import picture_of_run, plot_run
from trackweave.plotting.scene import ScanSeries, Scene

__all__ = ["ScanSeries", "Scene", "picture_of_run", "plot_run"]
