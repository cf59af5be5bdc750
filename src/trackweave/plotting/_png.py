"""Figures as files whose bytes depend on nothing but what they show."""

import io
from collections.abc import Iterator
from contextlib import contextmanager

import matplotlib as mpl
import matplotlib.style
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

__all__ = ["METADATA", "encoded", "own_style", "png_of"]

DOTS_PER_INCH = 150
# Without versions and dates in the file, its bytes depend on what is drawn alone.
METADATA = {
    "png": {"Software": None},
    "svg": {"Date": None, "Creator": None},
    "pdf": {"CreationDate": None, "Creator": None, "Producer": None},
}


@contextmanager
def own_style() -> Iterator[None]:
    """Keep the user's own style files from changing the picture."""
    with matplotlib.style.context("default"), mpl.rc_context({"svg.hashsalt": "trackweave"}):
        yield


def encoded(figure: Figure, file_format: str, dots_per_inch: float = DOTS_PER_INCH) -> bytes:
    """Return a figure as a file, with nothing in it of who drew it."""
    file = io.BytesIO()
    figure.savefig(file, format=file_format, dpi=dots_per_inch, metadata=METADATA[file_format])
    return file.getvalue()


def png_of(figure: Figure) -> bytes:
    """Return a figure that has no canvas yet as PNG."""
    FigureCanvasAgg(figure)
    return encoded(figure, "png")
