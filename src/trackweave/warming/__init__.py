"""Compiling beforehand: runs that reach kernels, and what they compile packed into a wheel."""
