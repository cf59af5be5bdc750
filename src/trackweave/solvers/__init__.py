"""Solvers of the assignment problem: any of them solves any problem."""

from trackweave.solvers.ants import AntSystem as AntSystem
from trackweave.solvers.ants import MaxMinAntSystem as MaxMinAntSystem
from trackweave.solvers.auto import Auto as Auto
from trackweave.solvers.dual import Dual as Dual
from trackweave.solvers.exact import Exact as Exact
from trackweave.solvers.genetic import Genetic as Genetic
from trackweave.solvers.genetic import ListGenetic as ListGenetic
from trackweave.solvers.greedy import Greedy as Greedy
from trackweave.solvers.local import Annealing as Annealing
from trackweave.solvers.local import TabuSearch as TabuSearch
from trackweave.solvers.m_best import MBest as MBest
from trackweave.solvers.m_best import Ranking as Ranking
from trackweave.solvers.metaheuristic import SearchState as SearchState
from trackweave.solvers.protocol import Hint as Hint
from trackweave.solvers.protocol import Solver as Solver
from trackweave.solvers.protocol import Stop as Stop
from trackweave.solvers.solve import solve as solve

__all__ = [
    "Annealing",
    "AntSystem",
    "Auto",
    "Dual",
    "Exact",
    "Genetic",
    "Greedy",
    "Hint",
    "ListGenetic",
    "MBest",
    "MaxMinAntSystem",
    "Ranking",
    "SearchState",
    "Solver",
    "Stop",
    "TabuSearch",
    "solve",
]
