"""Solvers of the assignment problem: any of them solves any problem.

Each is imported when it is first used: a run takes one of them. A new one is a module and its
rows here; configuration, schema and commands follow.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

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
    from trackweave.solvers.solving import solve as solve

# What ``[search] method`` may name, and the class behind it.
METHODS = {
    "auto": "Auto",
    "greedy": "Greedy",
    "exact": "Exact",
    "dual": "Dual",
    "genetic": "Genetic",
    "list-genetic": "ListGenetic",
    "ant-system": "AntSystem",
    "annealing": "Annealing",
    "islands": "Islands",
    "tabu": "TabuSearch",
    "m-best": "MBest",
}
# In which module each public name lives.
_HOMES = {
    "Annealing": "local",
    "AntSystem": "ants",
    "Auto": "auto",
    "Dual": "dual",
    "Exact": "exact",
    "Genetic": "genetic",
    "Greedy": "greedy",
    "Hint": "protocol",
    "Islands": "islands",
    "ListGenetic": "genetic",
    "MBest": "m_best",
    "Ranking": "m_best",
    "SearchState": "resumable",
    "Solver": "protocol",
    "Stop": "protocol",
    "TabuSearch": "local",
    "solve": "solving",
}

__all__ = sorted([*_HOMES, "METHODS"])


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
