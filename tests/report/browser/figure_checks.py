"""What is wrong with figures on a page: nothing drawn, texts too small or too faint, a blank picture, cut by paper."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
from browsing import PATIENCE
from layout import Texts
from numpy.typing import NDArray
from PIL import Image
from playwright.sync_api import Page

CONTRAST = 4.5  # WCAG 2.2, 1.4.3, for text of normal size
SMALLEST_TEXT = 6.0  # px: height of a line in a figure that a person can still read on a phone
ONE_COLOUR = 0.99  # share of a picture that is blank
SHADES = 16  # of grey that count as one colour: the picture is taken as JPEG
FEWEST_POINTS = 5  # of data; three lines of limits are none

# Points of what is drawn in the axes, which cut it (ticks, frames and legends are not cut), besides the grid.
FIGURES = r"""() => [...document.querySelectorAll('svg')].filter(e => e.checkVisibility()).map(svg => {
  const inside = [...svg.querySelectorAll('[clip-path] path, [clip-path] use, path[clip-path], use[clip-path]')];
  const grid = e => e && e !== svg && (/--fig-grid/.test(e.getAttribute('style') || '') || grid(e.parentElement));
  const drawn = inside.filter(e => !e.closest('defs') && !grid(e)).filter(e => {
    const r = e.getBoundingClientRect(); return r.width + r.height > 1; });
  const points = e => e.tagName === 'use' ? 1 : (e.getAttribute('d') || '').split(/[MLCQHVAmlcqhva]/).length - 1;
  const counted = drawn.map(points).map(n => n > 2 ? n : 1).reduce((a, b) => a + b, 0);
  return {name: svg.getAttribute('aria-label') || 'figure', points: counted + 9 * svg.querySelectorAll('image').length};
})"""

# Texts of figures: their colour, and the colour behind the figure.
INK = """() => [...document.querySelectorAll('svg text')].filter(e => e.checkVisibility()).map(e => {
  let behind = 'rgba(0, 0, 0, 0)';
  for (let p = e.closest('svg'); p && /, 0\\)$/.test(behind); p = p.parentElement)
    behind = getComputedStyle(p).backgroundColor;
  return {text: e.textContent.trim().slice(0, 40), ink: getComputedStyle(e).fill, behind};
}).filter(one => one.text)"""

PLACES = """() => [...document.querySelectorAll('svg')].filter(e => e.checkVisibility()).map(e => {
  const r = e.getBoundingClientRect(), x = scrollX, y = scrollY;
  return [r.left + x, r.top + y, r.right + x, r.bottom + y]; })"""

PAPER_BOXES = """() => ({
  figures: [...document.querySelectorAll('figure')].map(e => ({
    height: e.getBoundingClientRect().height, inside: getComputedStyle(e).breakInside,
    drawing: (e.querySelector('svg') || e).getBoundingClientRect().height})),
  rows: [...document.querySelectorAll('tr')].filter(e => getComputedStyle(e).breakInside !== 'avoid').length,
  scrolled: [...document.body.querySelectorAll('*')].filter(e => e.checkVisibility()
    && getComputedStyle(e).overflowX !== 'visible' && !(e instanceof SVGElement) && e.scrollWidth > e.clientWidth + 1
    && e.clientWidth > 1).map(e => e.tagName.toLowerCase() + '.' + e.className)
})"""


def empty_figures(page: Page) -> list[str]:
    """Return the figures without data."""
    found = page.evaluate(FIGURES)
    return [f"nothing in the axes of {one['name']!r}" for one in found if one["points"] < FEWEST_POINTS]


def small_texts(texts: Texts) -> list[str]:
    """Return the texts of figures that are too small to be read."""
    return [
        f"{min(line[2] - line[0], line[3] - line[1]):.1f} px high: {one['text']!r}"
        for one in texts
        for line in one["lines"][:1]
        if one["drawn"] and min(line[2] - line[0], line[3] - line[1]) < SMALLEST_TEXT and len(one["text"]) > 1
    ]


def faint_texts(page: Page) -> list[str]:
    """Return the texts of figures with too little contrast; axe does not look at them."""
    return [
        f"contrast {ratio:.1f}: {one['text']!r} {one['ink']} on {one['behind']}"
        for one in page.evaluate(INK)
        if (ratio := _contrast(one["ink"], one["behind"])) < CONTRAST
    ]


def _contrast(one: str, other: str) -> float:
    """Ratio of relative luminances (WCAG 2.2) of two computed colours."""
    low, high = sorted((_luminance(one), _luminance(other)))
    return (high + 0.05) / (low + 0.05)


def _luminance(colour: str) -> float:
    numbers = [float(part) for part in colour.partition("(")[2].rstrip(")").replace("/", " ").replace(",", " ").split()]
    if len(numbers) < 3 or (len(numbers) > 3 and numbers[3] == 0.0):
        return 1.0  # nothing painted: the white of the window
    s = np.array(numbers[:3]) / 255.0
    linear = np.where(s <= 0.04045, s / 12.92, ((s + 0.055) / 1.055) ** 2.4)
    return float(linear @ (0.2126, 0.7152, 0.0722))


def blank(page: Page) -> list[str]:
    """Return what is blank in a picture of the whole page: the page, or one of its figures."""
    picture = np.asarray(Image.open(io.BytesIO(_taken(page))).convert("L"), dtype=np.uint8) // SHADES
    shares = {"the page": _share(picture)}
    for number, (left, top, right, bottom) in enumerate(page.evaluate(PLACES), 1):
        shares[f"figure {number}"] = _share(picture[int(top) : int(bottom), int(left) : int(right)])
    return [f"{share:.2%} of {name} is one colour" for name, share in shares.items() if share > ONE_COLOUR]


def _taken(page: Page) -> bytes:
    return page.screenshot(full_page=True, type="jpeg", quality=60, timeout=PATIENCE)


def _share(picture: NDArray[np.uint8]) -> float:
    """Share of the commonest colour; 1 where there is nothing."""
    return float(np.bincount(picture.ravel()).max()) / picture.size if picture.size else 1.0


def cut_on_paper(page: Page, height: float) -> list[str]:
    """Return what pages of paper cut: figures that may break or are too high, rows that may break, scrolled boxes."""
    found: dict[str, Any] = page.evaluate(PAPER_BOXES)
    faults = [f"on paper only part is seen of {name}" for name in found["scrolled"]]
    for number, one in enumerate(found["figures"], 1):
        if one["inside"] != "avoid":
            faults.append(f"figure {number} may be cut by the end of a page")
        if one["drawing"] > height:
            faults.append(f"figure {number} is {one['drawing']:.0f} px high, a page has {height:.0f} px")
    if found["rows"]:
        faults.append(f"{found['rows']} row(s) of tables may be cut by the end of a page")
    return faults
