"""The configuration: reading it, checking it, filling what it leaves out."""

from trackweave.config.learned import with_learned
from trackweave.config.load import Configuration, load_configuration

__all__ = ["Configuration", "load_configuration", "with_learned"]
