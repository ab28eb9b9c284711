"""A figure in text: dots lie where the curve is, on both scales."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from inertialcal.report.figures.drawing.picture import Picture
from inertialcal.report.text_plot import BLANK, DOTS, HEIGHT, text_plot

X = np.linspace(0.0, 1.0, 50)


def picture(scale: str = "linear", joined: bool = True) -> Picture:
    def draw(axes: Sequence[Any], title: str) -> None:
        x = X if scale == "linear" else 10.0**X
        axes[0].plot(x, x, "-" if joined else "o")
        axes[0].set(xlim=(x[0], x[-1]), ylim=(x[0], x[-1]), xscale=scale, yscale=scale, xlabel="time [s]", ylabel="y")

    return Picture("line", "", "", "A line", "y over x", (2.0,), draw)


def dots(text: str) -> list[tuple[int, int]]:
    """Column and row, from the lower left, of each dot of a plot in Braille."""
    rows = [line.partition("|")[2] for line in text.split("\n") if "|" in line]
    assert len(rows) == HEIGHT
    found = []
    for i, row in enumerate(rows):
        for j, sign in enumerate(row):
            bits = 0 if sign == " " else ord(sign) - BLANK
            found += [
                (2 * j + column, 4 * (HEIGHT - i) - 1 - dot)
                for dot in range(4)
                for column in range(2)
                if bits & DOTS[dot, column]
            ]
    return found


@pytest.mark.parametrize("scale", ["linear", "log"])
@pytest.mark.parametrize("joined", [True, False])
def test_a_line_at_45_degrees_is_one_on_both_scales(scale: str, joined: bool) -> None:
    text = text_plot([picture(scale, joined)], 80)
    found = dots(text)
    assert len(found) >= 45
    columns = max(x for x, _ in found)
    for x, y in found:
        assert y / (4 * HEIGHT - 1) == pytest.approx(x / columns, abs=1.5 / (4 * HEIGHT - 1))
    assert max(map(len, text.split("\n"))) <= 80
    assert "time [s]" in text


def test_in_ascii_too() -> None:
    text = text_plot([picture()], 60, braille=False)
    assert text.isascii()
    marks = [line.partition("|")[2].rstrip() for line in text.split("\n") if "|" in line]
    ends = [len(row) for row in marks]
    assert ends == sorted(ends, reverse=True)
    assert set("".join(marks)) == {"*", " "}
