"""Genetic search."""

from trackweave.solvers.genetic.genetic import Genetic as Genetic
from trackweave.solvers.genetic.list_genetic import ListGenetic as ListGenetic

__all__ = ["Genetic", "ListGenetic"]
