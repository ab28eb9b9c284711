"""Pictures of one page in its states, compared with its layout and with each other.

No picture is kept: a reference would follow the fonts and the browser of one machine. What must agree stands on the
page itself. A text of the layout is seen in the picture; dark shows the same as light, the other way round; paper and
an enlarged figure show what the screen does, at another size.
"""

from __future__ import annotations

import io
from itertools import islice
from typing import Any

import numpy as np
from browsing import PATIENCE
from numpy.typing import NDArray
from PIL import Image
from playwright.sync_api import Locator, Page

Grey = NDArray[np.float64]
CELL = 16  # px: side of a cell in which ink is compared
GRID = (40, 60)  # cells of a figure, high and wide
CONTRAST = 48.0  # of 255: between a text and what is behind it, at least
INK = 50.0  # of 255: mean difference of the ink of a cell in light and dark, at most; the palettes differ by 40
ALIKE = 0.8  # correlation of two pictures of one figure, at least


def taken(seen: Page | Locator, **options: Any) -> Grey:
    """Return a picture as luminance, 0 to 255, shape (px high, px wide)."""
    data = seen.screenshot(type="png", timeout=PATIENCE, **options)
    return np.asarray(Image.open(io.BytesIO(data)).convert("L"), dtype=np.float64)


def unseen_texts(picture: Grey, texts: list[dict[str, Any]]) -> list[str]:
    """Return the texts of the layout of which the picture shows nothing; the page is not scrolled."""
    faults = []
    for one in texts:
        left, top, right, bottom = (round(edge) for edge in one["lines"][0])
        part = picture[max(top, 0) : bottom, max(left, 0) : right]
        if part.size and bottom <= len(picture) and np.ptp(part) < CONTRAST:
            faults.append(f"not to be seen: {one['text']!r}")
    return faults


def ink(picture: Grey) -> Grey:
    """Return how much of each cell stands out from the ground of the page, 0 to 255."""
    levels, counts = np.unique(picture, return_counts=True)
    high, wide = (size // CELL for size in picture.shape)
    cut = picture[: high * CELL, : wide * CELL].reshape(high, CELL, wide, CELL)
    return np.asarray(np.abs(cut - levels[np.argmax(counts)]).mean(axis=(1, 3)))


def unlike_inks(light: Grey, dark: Grey) -> list[str]:
    """Return the cells that show something in one scheme and not, or another thing, in the other."""
    one, other = ink(light), ink(dark)
    if one.shape != other.shape:
        return [f"the page is {light.shape} px in light, {dark.shape} px in dark"]
    apart = np.argwhere(np.abs(one - other) > INK)
    said = (f"cell at {x * CELL}, {y * CELL} px: ink {one[y, x]:.0f}, {other[y, x]:.0f}" for y, x in apart)
    return list(islice(said, 5))


def drawn(page: Page, figure: Locator) -> Grey:
    """Return a picture of a figure without what is free at its sides because it is as high as the window."""
    box, shape = figure.bounding_box(), figure.evaluate("one => one.viewBox.baseVal.width / one.viewBox.baseVal.height")
    assert box is not None
    wide, high = min(box["width"], box["height"] * shape), min(box["height"], box["width"] / shape)
    x, y = box["x"] + (box["width"] - wide) / 2.0, box["y"] + (box["height"] - high) / 2.0
    return taken(page, clip={"x": x, "y": y, "width": wide, "height": high})


def coarse(figure: Grey) -> Grey:
    """Return a figure as a grid of cells; its margins are part of it."""
    image = Image.fromarray(figure.astype(np.uint8))
    return np.asarray(image.resize(GRID[::-1], Image.Resampling.BOX), dtype=np.float64)


def unlike_figures(one: Grey, other: Grey) -> list[str]:
    """Return what is wrong if two pictures of one figure, of any sizes, do not show the same."""
    alike = float(np.corrcoef(coarse(one).ravel(), coarse(other).ravel())[0, 1])
    return [] if alike >= ALIKE else [f"correlation {alike:.2f}"]
