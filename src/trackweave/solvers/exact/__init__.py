"""The optimum by branch and bound on linear programs."""

from trackweave.solvers.exact.exact import Exact as Exact

__all__ = ["Exact"]
