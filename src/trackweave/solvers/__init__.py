"""Solvers of the assignment problem: any of them solves any problem.

Each but the default is imported when it is first used: a run takes one of them.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

# At once: the function has the name of its module, which would come in its place.
from trackweave.solvers.solve import solve as solve

if TYPE_CHECKING:
    from trackweave.solvers.ants import AntSystem as AntSystem
    from trackweave.solvers.auto import Auto as Auto
    from trackweave.solvers.dual import Dual as Dual
    from trackweave.solvers.exact import Exact as Exact
    from trackweave.solvers.genetic import Genetic as Genetic
    from trackweave.solvers.genetic import ListGenetic as ListGenetic
    from trackweave.solvers.greedy import Greedy as Greedy
    from trackweave.solvers.islands import Islands as Islands
    from trackweave.solvers.local import Annealing as Annealing
    from trackweave.solvers.local import TabuSearch as TabuSearch
    from trackweave.solvers.m_best import MBest as MBest
    from trackweave.solvers.m_best import Ranking as Ranking
    from trackweave.solvers.protocol import Hint as Hint
    from trackweave.solvers.protocol import Solver as Solver
    from trackweave.solvers.protocol import Stop as Stop
    from trackweave.solvers.resumable import SearchState as SearchState

# Where each public name lives.
_HOMES = {
    "Annealing": "trackweave.solvers.local",
    "AntSystem": "trackweave.solvers.ants",
    "Auto": "trackweave.solvers.auto",
    "Dual": "trackweave.solvers.dual",
    "Exact": "trackweave.solvers.exact",
    "Genetic": "trackweave.solvers.genetic",
    "Greedy": "trackweave.solvers.greedy",
    "Hint": "trackweave.solvers.protocol",
    "Islands": "trackweave.solvers.islands",
    "ListGenetic": "trackweave.solvers.genetic",
    "MBest": "trackweave.solvers.m_best",
    "Ranking": "trackweave.solvers.m_best",
    "SearchState": "trackweave.solvers.resumable",
    "Solver": "trackweave.solvers.protocol",
    "Stop": "trackweave.solvers.protocol",
    "TabuSearch": "trackweave.solvers.local",
}

__all__ = [
    "Annealing",
    "AntSystem",
    "Auto",
    "Dual",
    "Exact",
    "Genetic",
    "Greedy",
    "Hint",
    "Islands",
    "ListGenetic",
    "MBest",
    "Ranking",
    "SearchState",
    "Solver",
    "Stop",
    "TabuSearch",
    "solve",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
