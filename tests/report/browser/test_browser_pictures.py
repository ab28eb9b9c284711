"""The states of the report as pictures: light and dark, desk and telephone, paper, a figure enlarged, a value shown."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from browsing import DESKTOP, HEIGHT, PAPER, PHONE, visit
from layout import seen_texts, sideways
from pictures import drawn, taken, unlike_figures, unlike_inks, unseen_texts
from playwright.sync_api import Browser, Page

from inertialcal.files.binary.curves import read_curves

pytestmark = pytest.mark.slow
HIGH = 1200  # px of the page that are looked at: its head, the verdict, the requirements, figures
TOP = "#verdict"
FIGURE = "#verdict figure"
FIRST = f"{FIGURE} svg"
NAMES = ("applied", "raw", "compensated")


@pytest.fixture(scope="module")
def page(browser: Browser, published_report: Path) -> Iterator[Page]:
    with visit(browser, published_report, DESKTOP) as seen:
        yield seen.page


@pytest.fixture(autouse=True)
def as_opened(page: Page) -> Iterator[None]:
    """Give the page back as it was."""
    yield
    page.locator(".made-worse").evaluate_all("all => all.forEach(one => one.remove())")
    page.locator(".zoom input").evaluate_all("all => all.forEach(one => { one.checked = false; })")
    page.mouse.move(1, 1)
    look(page, DESKTOP)


def look(page: Page, width: int, scheme: str = "light", media: str = "screen", high: int = HIGH) -> None:
    page.emulate_media(color_scheme=scheme, media=media)  # type: ignore[arg-type]
    page.set_viewport_size({"width": width, "height": high})
    page.evaluate("scrollTo(0, 0)")


def worsen(page: Page, style: str) -> None:
    """Let a rule hold for the page that makes one thing of it wrong."""
    page.evaluate(
        "text => { const one = document.createElement('style'); one.className = 'made-worse';"
        " one.textContent = text; document.head.append(one); }",
        style,
    )


def in_both(page: Page, width: int) -> list[str]:
    look(page, width, "dark")
    dark = taken(page)
    faults = unseen_texts(dark, seen_texts(page, TOP))
    look(page, width)
    light = taken(page)
    return faults + unseen_texts(light, seen_texts(page, TOP)) + unlike_inks(light, dark)


@pytest.mark.parametrize("width", [DESKTOP, PHONE])
def test_light_and_dark_show_the_same(page: Page, width: int) -> None:
    assert in_both(page, width) == []


@pytest.mark.parametrize(
    "style",
    [
        "@media (prefers-color-scheme: dark) { .box { background: white !important } }",
        "@media (prefers-color-scheme: dark) { #verdict .glance th { color: var(--paper) } }",
        "@media (prefers-color-scheme: dark) { :root { --fig-ink: #16191d !important } }",
        ".glance .verdict { color: transparent }",
        "@media (prefers-color-scheme: dark) { .glance { margin-top: 3em } }",
    ],
)
def test_a_state_that_loses_something_is_noticed(page: Page, style: str) -> None:
    worsen(page, style)
    assert in_both(page, DESKTOP)


def printed(page: Page) -> list[str]:
    """Return what paper shows otherwise than the screen."""
    look(page, DESKTOP)
    screen = drawn(page, page.locator(FIRST).first)
    look(page, PAPER, "dark", "print")
    faults = unseen_texts(taken(page), seen_texts(page, TOP))
    return faults + unlike_figures(screen, drawn(page, page.locator(FIRST).first))


def test_paper_shows_what_the_screen_does(page: Page) -> None:
    assert printed(page) == []


@pytest.mark.parametrize(
    "style", ["@media print { svg text { fill: white !important } }", "@media print { svg g { display: none } }"]
)
def test_paper_that_loses_something_is_noticed(page: Page, style: str) -> None:
    worsen(page, style)
    assert printed(page)


@pytest.mark.parametrize("width", [DESKTOP, PHONE])
def test_a_figure_is_enlarged_and_comes_back(page: Page, width: int) -> None:
    look(page, width, high=HEIGHT[width])
    figure, box = page.locator(FIRST).first, page.locator(f"{FIGURE} .zoom input").first
    small, size, whole = drawn(page, figure), figure.bounding_box(), taken(page)
    box.focus()
    page.keyboard.press("Space")
    large = figure.bounding_box()
    assert size is not None
    assert large is not None
    assert large["width"] > 1.3 * size["width"]
    assert box.is_visible()
    assert sideways(page) == []
    if width > PHONE:  # on a telephone a part is seen, and the rest by scrolling
        assert unlike_figures(small, drawn(page, figure)) == []
    page.keyboard.press("Space")
    box.blur()
    page.evaluate("scrollTo(0, 0)")
    np.testing.assert_array_equal(taken(page), whole)


def test_a_mark_shows_its_values_and_nothing_else_changes(page: Page, published_report: Path) -> None:
    look(page, DESKTOP)
    without = taken(page)
    group = page.locator(f"{FIRST} .v g").first
    text, box, frame = group.locator("text"), group.locator("path").bounding_box(), page.locator(FIGURE).first
    around = frame.bounding_box()
    assert box is not None
    assert around is not None
    assert not text.is_visible()
    page.mouse.move(box["x"] + box["width"] / 2.0, box["y"] + min(box["width"], box["height"]) / 2.0)
    assert text.is_visible()
    shown = taken(page)
    changed = np.argwhere(shown != without)
    assert len(changed)
    assert around["y"] <= changed[:, 0].min()
    assert changed[:, 0].max() <= around["y"] + around["height"]
    assert unseen_texts(shown, seen_texts(page, TOP)) == []
    page.mouse.move(1, 1)
    np.testing.assert_array_equal(taken(page), without)


def test_values_are_those_of_the_dwells(page: Page, published_report: Path) -> None:
    """Each text of the first panel has four digits of the curve that the figure is drawn from."""
    curves = read_curves(published_report.with_name("curves.parquet").read_bytes())
    columns = next(one["columns"] for one in curves if one["name"] == "compensated" and one["axis"] == "x")
    dwells = zip(*(columns[name]["values"] for name in ("applied", "raw_error", "compensated_error")), strict=True)
    known = {", ".join(f"{a} {b:.4g}" for a, b in zip(NAMES, one, strict=True)) for one in dwells}
    shown = page.locator(FIRST).first.locator(".v text").all_text_contents()
    assert shown
    assert set(shown) <= known
