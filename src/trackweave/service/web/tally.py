"""What the web counts of itself."""

from collections import Counter
from collections.abc import Callable, Iterator

__all__ = ["Tally"]


class Tally:
    """Counts events by name and labels, and asks for what is measured when it is read."""

    def __init__(self) -> None:
        self.measured: dict[str, Callable[[], float]] = {}
        self._counts: Counter[tuple[str, tuple[tuple[str, str], ...]]] = Counter()

    def add(self, name: str, count: float = 1, **labels: str) -> None:
        """Count; ``labels`` must be of few different values, none of which comes from outside."""
        self._counts[name, tuple(labels.items())] += count  # type: ignore[assignment]

    def count(self, name: str, **labels: str) -> float:
        """Return what was counted of a name, over all labels but those that are told."""
        told = set(labels.items())
        return sum(n for (each, of), n in self._counts.items() if each == name and told <= {*of})

    def __iter__(self) -> Iterator[tuple[str, dict[str, str], float]]:
        """Yield names, labels and counts, those of one name together."""
        for (name, labels), count in sorted(self._counts.items()):
            yield name, dict(labels), count
        for name, measure in self.measured.items():
            yield name, {}, measure()
