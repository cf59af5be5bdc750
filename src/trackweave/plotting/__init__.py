"""Pictures of runs."""

from trackweave.plotting.run import Scene, picture_of_run, plot_run

__all__ = ["Scene", "picture_of_run", "plot_run"]
