"""Local searches: annealing and tabu search."""

from trackweave.solvers.local.annealing import Annealing as Annealing
from trackweave.solvers.local.tabu import TabuSearch as TabuSearch

__all__ = ["Annealing", "TabuSearch"]
