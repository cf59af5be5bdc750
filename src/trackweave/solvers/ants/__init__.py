"""Ants."""

from trackweave.solvers.ants.ant_system import AntSystem as AntSystem

__all__ = ["AntSystem", "MaxMinAntSystem"]
from trackweave.solvers.ants.max_min import MaxMinAntSystem as MaxMinAntSystem
