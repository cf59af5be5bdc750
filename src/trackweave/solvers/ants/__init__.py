"""Ants."""

from trackweave.solvers.ants.ant_system import AntSystem as AntSystem

__all__ = ["AntSystem"]
