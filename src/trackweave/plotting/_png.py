"""Figures as files whose bytes depend on nothing but what they show."""

import io

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

__all__ = ["png_of"]

DOTS_PER_INCH = 150


def png_of(figure: Figure) -> bytes:
    """Return a figure as PNG, with nothing in it of who drew it."""
    FigureCanvasAgg(figure)
    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=DOTS_PER_INCH, metadata={"Software": None})
    return file.getvalue()
