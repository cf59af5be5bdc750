"""Input diagnostics: where reports contradict one another, or what was told of them."""

from trackweave.run.diagnostics.case import Case, Finding
from trackweave.run.diagnostics.diagnose import diagnose

__all__ = ["Case", "Finding", "diagnose"]
