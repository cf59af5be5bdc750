"""Figures of strings of genes, drawn as rows of boxes."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from trackweave.plotting._canvas import own_style, png_of

__all__ = ["StringRow", "picture_of_strings"]

BOX_IN = 0.42
LEFT = 2.2


@dataclass(frozen=True, slots=True)
class StringRow:
    """A string of a figure."""

    name: str  # What stands before it
    genes: tuple[str, ...]  # What stands in its boxes
    marked: tuple[int, ...] = ()  # Places of boxes that stand out


def picture_of_strings(figures: Mapping[str, Sequence[StringRow]]) -> bytes:
    """Return figures of strings by their titles, below one another, as PNG."""
    longest = max(len(row.genes) for rows in figures.values() for row in rows)
    height = sum(len(rows) + 1.8 for rows in figures.values())
    with own_style():
        size = ((longest + LEFT + 0.5) * BOX_IN, height * BOX_IN)
        figure = Figure(figsize=size, facecolor="white")
        axes = figure.add_axes(
            (0.0, 0.0, 1.0, 1.0), xlim=(-LEFT, longest + 0.5), ylim=(-height, 0)
        )
        axes.set_axis_off()
        down = 0.0
        for title, rows in figures.items():
            axes.text(0.3 - LEFT, -down - 0.8, title, va="center", fontsize=10)
            down += 1.4
            for row in rows:
                axes.text(-0.2, -down - 0.5, row.name, ha="right", va="center", fontsize=9)
                for place, gene in enumerate(row.genes):
                    colour = "#F0E442" if place in row.marked else "white"
                    axes.add_patch(
                        Rectangle((place, -down - 1), 1, 1, facecolor=colour, edgecolor="black")
                    )
                    axes.text(place + 0.5, -down - 0.5, gene, ha="center", va="center", fontsize=9)
                down += 1.0
            down += 0.4
        return png_of(figure)
