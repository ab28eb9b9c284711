"""Values that marks show when the pointer rests on them: those of the data, at the place where the mark is drawn."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from matplotlib.axes import Axes

from inertialcal.report.figures import Picture, to_svg
from inertialcal.report.figures.drawing.style import set_labels
from inertialcal.report.figures.drawing.svg import _NUMBER, _short_path
from inertialcal.report.figures.drawing.values import MOST

NAMESPACE = "{http://www.w3.org/2000/svg}"
TENTH = 0.051  # pt: places are rounded
X, Y = (-2.0, 0.0, 3.5), (0.25, 0.5, -1.0)
Shown = list[tuple[str, list[tuple[float, float]]]]


def picture(draw: Callable[[Sequence[Axes], str], None], panels: int = 1) -> Picture:
    return Picture("made", "t", "x", "found", "shows", (1.5,) * panels, draw)


def shown(of: Picture) -> Shown:
    """Return the texts and the places of their marks, from the left and the top."""
    root = ET.fromstring(to_svg(of, "p", with_values=True))
    whole = root.find(f"{NAMESPACE}g[@class='v']")
    if whole is None:
        return []
    right, down = map(float, _NUMBER.findall(whole.attrib["transform"]))
    found: Shown = []
    for group in whole:
        places = re.findall(r"M([^h]+)h0", group[0].attrib["d"])
        pairs = [tuple(map(float, _NUMBER.findall(one))) for one in places]
        found.append((group[1].text or "", [(right + x, down + y) for x, y in pairs]))
    return found


def corners(of: Picture) -> list[tuple[float, float]]:
    """Return where the marks themselves are drawn: the pieces of `use`."""
    uses = ET.fromstring(to_svg(of, "p")).iter(f"{NAMESPACE}use")
    return [(float(one.attrib["x"]), float(one.attrib["y"])) for one in uses]


def two_panels(axes: Sequence[Axes], title: str) -> None:
    axes[0].plot(X, Y, "o")
    axes[1].plot(X, [10.0 * y for y in Y], "o")
    axes[1].axhline(0.0)
    set_labels(axes[0], y="reading [deg/s]")
    set_labels(axes[1], "applied [deg/s]", "residual [deg/s]")


def test_each_point_says_the_values_of_all_panels_where_its_marks_are() -> None:
    of = picture(two_panels, 2)
    found = shown(of)
    assert [text for text, _ in found] == [
        "applied -2, reading 0.25, residual 2.5",
        "applied 0, reading 0.5, residual 5",
        "applied 3.5, reading -1, residual -10",
    ]
    drawn = corners(of)
    assert len(drawn) == 6
    expected = [[drawn[i], drawn[i + 3]] for i in range(3)]
    np.testing.assert_allclose([places for _, places in found], expected, atol=2.0 * TENTH)


def test_series_of_one_panel_go_by_the_names_of_their_legend() -> None:
    def draw(axes: Sequence[Axes], title: str) -> None:
        axes[0].plot(X, Y, "o", label="raw")
        axes[0].plot(X, [0.0, np.nan, 0.125], "D", label="compensated")
        set_labels(axes[0], "rate [deg/s]", "error [deg/s]")

    assert [text for text, _ in shown(picture(draw))] == [
        "rate -2, raw 0.25, compensated 0",
        "rate 0, raw 0.5",  # the other is not drawn
        "rate 3.5, raw -1, compensated 0.125",
    ]


def test_what_lies_outside_its_panel_shows_nothing() -> None:
    def draw(axes: Sequence[Axes], title: str) -> None:
        axes[0].plot(X, Y, "o")
        axes[0].set_ylim(0.0, 1.0)

    assert len(shown(picture(draw))) == 2


@pytest.mark.parametrize(("n", "points"), [(MOST, MOST), (MOST + 1, 0)])
def test_too_many_points_show_none(n: int, points: int) -> None:
    def draw(axes: Sequence[Axes], title: str) -> None:
        axes[0].plot(np.arange(n), np.arange(n), "o")

    assert len(shown(picture(draw))) == points


def test_a_name_from_the_data_is_escaped() -> None:
    def draw(axes: Sequence[Axes], title: str) -> None:
        axes[0].plot(X, Y, "o")
        set_labels(axes[0], y="<script>alert(1)</script>")

    svg = to_svg(picture(draw), "p", with_values=True)
    assert "<script" not in svg
    assert all("<script>" in text for text, _ in shown(picture(draw)))


def test_without_values_a_figure_has_none() -> None:
    assert 'class="v"' not in to_svg(picture(two_panels, 2), "p")


@pytest.mark.parametrize(
    ("path", "short"),
    [
        ("M 10 20 L 14.4 20 L 14.4 23.5", "M10 20h4.4v3.5"),
        ("M 0.5 0.25 L 0.75 -0.5", "M.5.2l.3-.7"),  # half to even: 0.25 is 0.2, 0.75 is 0.8
        ("M 0 0 L 3 4.5 Z", "M0 0l3 4.5z"),
        ("M 1 1 L 1 1", "M1 1h0"),
    ],
)
def test_paths_are_short(path: str, short: str) -> None:
    assert _short_path(path) == short
