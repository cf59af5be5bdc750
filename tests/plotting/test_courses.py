"""Tests of figures of courses."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from trackweave.plotting import courses
from trackweave.plotting.courses import CoursePanel, Layer, picture_of_courses


def test_plans_side_by_side_show_the_same_ground(monkeypatch: pytest.MonkeyPatch) -> None:
    sheets: list[Figure] = []
    real = courses.png_of

    def watched(figure: Figure) -> bytes:
        sheets.append(figure)
        return real(figure)

    monkeypatch.setattr(courses, "png_of", watched)
    everywhere, inside = np.array([0.0, 20.0]), np.array([9.0, 11.0])
    picture_of_courses(
        [
            CoursePanel("all", "east", "north", (Layer("false alarms", "false", x, x),))
            for x in (everywhere, inside)
        ]
    )
    wide, near = sheets[0].axes
    assert near.get_xlim() == pytest.approx(wide.get_xlim())
    assert near.get_ylim() == pytest.approx(wide.get_ylim())
