"""Figures of a page are placed without drawing them: what was reckoned is what a drawing finds."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, findfont, get_font
from matplotlib.text import Text
from matplotlib.textpath import text_to_path
from matplotlib.transforms import Affine2D
from test_figures import poisoned, results

from inertialcal.report.figures import Picture, figures, on_new_figure
from inertialcal.report.figures.drawing.metrics import _advance, folded, shortened, width
from inertialcal.report.figures.drawing.scales import signed_log

SLACK = 2.0  # pt: kerning, rounding
FINE = 10  # dots a point: letters then stand where they do in a file of shapes
LETTERS = st.text(st.characters(codec="ascii", exclude_categories=["Cc"]), max_size=60)


@pytest.mark.parametrize("text", ["rate [deg/s]", "−0.0050", "INCONCLUSIVE (3)", "WWWW", "iiii"])
def test_a_width_is_that_of_the_font(text: str) -> None:
    found, _, _ = text_to_path.get_text_width_height_descent(
        text, FontProperties(family=["DejaVu Sans"], size=9), False
    )
    assert width(text, 9.0) == pytest.approx(found, abs=SLACK)


def test_a_width_stays_whatever_is_drawn_meanwhile() -> None:
    before = [width(letter, 9.0) for letter in "aW0"]
    _advance.cache_clear()
    text_to_path.get_text_width_height_descent("aW0", FontProperties(family=["DejaVu Sans"], size=31), False)
    get_font(findfont(FontProperties(family=["DejaVu Sans"]))).set_size(31.0, 300)
    assert [width(letter, 9.0) for letter in "aW0"] == before


@given(LETTERS, st.floats(20.0, 200.0))
def test_folding_keeps_every_letter_and_the_width(text: str, widest: float) -> None:
    lines = folded(text, 9.0, widest)
    assert lines.replace("\n", "").replace(" ", "") == text.replace(" ", "")
    assert width(lines, 9.0) <= widest
    assert width(shortened(text, 9.0, widest), 9.0) <= widest


def texts_of(figure: Figure) -> list[tuple[str, Any]]:
    figure.set_dpi(72 * FINE)
    figure.draw_without_rendering()
    shown = [one for ax in figure.axes for one in ax.findobj(Text) if isinstance(one, Text) and one.get_text()]
    axes = {id(one) for ax in figure.axes for axis in (ax.xaxis, ax.yaxis) for one in axis.findobj(Text)}
    return [
        (one.get_text(), one.get_window_extent().transformed(Affine2D().scale(1 / FINE)))
        for one in shown
        if id(one) not in axes and one.get_visible()
    ]


PLACES = [
    pytest.param(name, text, marks=pytest.mark.slow if text and (number + kind) % 2 else [])
    for number, name in enumerate(figures())
    for kind, text in enumerate(["", "W" * 60, "a long name of many words, longer than any"])
]


@pytest.mark.parametrize(("name", "text"), PLACES)
def test_no_text_is_cut_or_lies_over_another(name: str, text: str) -> None:
    figure = on_new_figure(figures()[name].pictures(poisoned(text) if text else results())[0], titled=False)
    found = texts_of(figure)
    wide, high = (72.0 * size for size in figure.get_size_inches())
    for label, box in found:
        assert box.x0 > -SLACK, label
        assert box.y0 > -SLACK, label
        assert box.x1 < wide + SLACK, label
        assert box.y1 < high + SLACK, label
    for count, (label, one) in enumerate(found):
        for other, two in found[:count]:
            over = min(one.x1, two.x1) - max(one.x0, two.x0), min(one.y1, two.y1) - max(one.y0, two.y0)
            assert min(over) < SLACK, f"{label!r} over {other!r}"


@pytest.mark.parametrize("name", list(figures()))
@pytest.mark.parametrize("text", ["", pytest.param("W" * 60, marks=pytest.mark.slow)])
def test_no_legend_or_heading_of_a_file_is_cut(name: str, text: str) -> None:
    """Files have titles, and another layout than pages."""
    figure = on_new_figure(figures()[name].pictures(poisoned(text) if text else results())[0], titled=True)
    figure.draw_without_rendering()
    legends = [legend for ax in figure.axes if (legend := ax.get_legend()) is not None]
    headings = [one for one in figure.texts if one.get_text()]
    for one in (*headings, *(label for legend in legends for label in legend.get_texts())):
        box = one.get_window_extent()
        assert box.x0 > -SLACK, one.get_text()
        assert box.x1 < figure.bbox.width + SLACK, one.get_text()
        assert box.y0 > -SLACK, one.get_text()
        assert box.y1 < figure.bbox.height + SLACK, one.get_text()


@pytest.mark.parametrize("wide", [2.5, 3.6, 5.0])
def test_labels_of_decades_do_not_touch(wide: float) -> None:
    rates = np.array([-3.0, -0.1, -0.01, 0.0, 0.01, 0.1, 3.0])

    def draw(axes: Sequence[Axes], title: str) -> None:
        assert signed_log(axes[0], "x", rates)
        axes[0].plot(rates, rates, "o")

    figure = on_new_figure(Picture("made", "t", "x", "found", "shows", (1.5,), draw, width=wide), titled=False)
    figure.canvas.draw()
    ax = figure.axes[0]
    upright = ax.bbox.y0
    boxes = [text.get_window_extent() for text in ax.texts if text.get_text() and text.get_window_extent().y1 < upright]
    edges = sorted((box.x0, box.x1) for box in boxes)
    texts = {text.get_text() for text in ax.texts}
    assert {"−1", "0", "1"} <= texts
    assert all(b[0] - a[1] > 2.0 for a, b in pairwise(edges))
    assert ("−0.01" in texts) == (wide > 3.0)
