"""Searches side by side that exchange answers."""

from trackweave.solvers.islands.islands import Islands as Islands

__all__ = ["Islands"]
