"""Entry points of a package that is not installed: a folder that says what one would say."""

import sys
import tomllib
from contextlib import contextmanager
from pathlib import Path

EXAMPLES = Path(__file__).resolve().parent.parent.parent / "examples" / "plugins"


def example_entry_points():
    """Return the entry points of the example package, by group."""
    project = tomllib.loads((EXAMPLES / "pyproject.toml").read_text())
    return project["project"]["entry-points"]


@contextmanager
def installed(folder, groups, *paths):
    """Make entry points known, and modules in some folders importable."""
    info = Path(folder) / "some_plugins-1.0.dist-info"
    info.mkdir(parents=True, exist_ok=True)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: some-plugins\nVersion: 1.0\n")
    lines = [
        line
        for group, points in groups.items()
        for line in (f"[{group}]", *(f"{name} = {value}" for name, value in points.items()))
    ]
    (info / "entry_points.txt").write_text("\n".join(lines) + "\n")
    added = [str(folder), *map(str, paths)]
    sys.path[:0] = added
    try:
        yield
    finally:
        for path in added:
            sys.path.remove(path)
