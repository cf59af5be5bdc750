"""Genetic search."""

from trackweave.solvers.genetic.genetic import Genetic as Genetic
from trackweave.solvers.genetic.genetic import GeneticState as GeneticState

__all__ = ["Genetic", "GeneticState"]
