"""Tests of panels of curves with their spread."""

from collections.abc import Mapping
from itertools import pairwise

import numpy as np
import pytest
from matplotlib.figure import Figure

from trackweave.plotting import panels_of_curves
from trackweave.plotting.panels_of_curves import Panel, SpreadCurve, picture_of_panels


def drawn(monkeypatch: pytest.MonkeyPatch, curves: Mapping[str, SpreadCurve]) -> Figure:
    sheets: list[Figure] = []
    real = panels_of_curves.png_of

    def watched(figure: Figure) -> bytes:
        sheets.append(figure)
        return real(figure)

    monkeypatch.setattr(panels_of_curves, "png_of", watched)
    picture_of_panels([Panel("title", "x", "y", curves, x_logarithmic=True)])
    return sheets[0]


def test_bars_reach_both_ends_of_an_interval_that_is_not_symmetric(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    curve = SpreadCurve(np.array([1.0]), np.array([95.0]), np.array([[8.0], [5.0]]))
    axes = drawn(monkeypatch, {"one": curve}).axes[0]
    (bar,) = axes.collections[0].get_segments()  # type: ignore[attr-defined]
    assert sorted(bar[:, 1]) == [87.0, 100.0]


def test_neighbouring_ticks_of_large_numbers_do_not_overlap(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    x = np.array([1e1, 1e3, 1e5, 1e6])
    figure = drawn(monkeypatch, {"one": SpreadCurve(x, x)})
    labels = [label for label in figure.axes[0].get_xticklabels() if label.get_text()]
    assert {"10", "1k", "100k", "1M"} <= {label.get_text() for label in labels}
    boxes = [label.get_window_extent() for label in labels]
    assert not any(a.overlaps(b) for a, b in pairwise(boxes))
