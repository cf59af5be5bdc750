"""Genetic search."""

from trackweave.solvers.genetic.genetic import Genetic as Genetic

__all__ = ["Genetic"]
