"""The configuration: reading it, checking it, filling what it leaves out."""

from trackweave.config.load import load_configuration
from trackweave.config.sections import Configuration

__all__ = ["Configuration", "load_configuration"]
