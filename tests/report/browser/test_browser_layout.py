"""The report as a picture: on a desk, on two phones, in light and dark, and on paper."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Literal

import pytest
from accessibility import UNFOLD, serious_faults
from browsing import DESKTOP, HEIGHT, PAPER, PAPER_HEIGHT, PHONE, SMALL_PHONE, visit
from figure_checks import blank, cut_on_paper, empty_figures, faint_texts, small_texts
from layout import cut_texts, overlapping_texts, seen_texts, sideways
from playwright.sync_api import Browser, Page

Scheme = Literal["light", "dark"]
SCHEMES: tuple[Scheme, ...] = ("light", "dark")
A4 = (595.3, 841.9)  # pt
LARGEST_PAGE = 2_000_000  # bytes
LARGEST_PDF = 5_000_000  # bytes


RECORDED = [pytest.param(name, marks=pytest.mark.slow) for name in ("simulated", "still")]  # each takes half a minute


@pytest.fixture(scope="module", params=["published", *RECORDED])
def report(request: pytest.FixtureRequest, reports: dict[str, Path]) -> Path:
    return reports[request.param]


@pytest.fixture(scope="module")
def page(browser: Browser, report: Path) -> Iterator[Page]:
    with visit(browser, report) as seen:
        yield seen.page


def look(page: Page, width: int, scheme: Scheme = "light", media: Literal["screen", "print"] = "screen") -> None:
    page.emulate_media(color_scheme=scheme, media=media)
    page.set_viewport_size({"width": width, "height": HEIGHT.get(width, PAPER_HEIGHT)})


def test_neither_page_nor_figure_is_blank(page: Page) -> None:
    assert page.locator("figure svg").count() > 3
    for scheme in SCHEMES:
        look(page, PHONE, scheme)
        assert blank(page) == []


def test_on_paper_all_is_seen_and_nothing_is_cut(page: Page) -> None:
    look(page, PAPER, "dark", "print")
    page.evaluate("window.dispatchEvent(new Event('beforeprint'))")
    texts = seen_texts(page)
    page.evaluate("window.dispatchEvent(new Event('afterprint'))")
    assert sideways(page) + overlapping_texts(texts) + cut_texts(texts, paper=True) == []
    assert cut_on_paper(page, PAPER_HEIGHT) + faint_texts(page) == []
    assert page.evaluate("getComputedStyle(document.body).backgroundColor") in (
        "rgb(255, 255, 255)",
        "rgba(0, 0, 0, 0)",
    )


@pytest.mark.parametrize("width", [DESKTOP, PHONE, SMALL_PHONE])
def test_nothing_scrolls_sideways_overlaps_or_is_cut(page: Page, width: int) -> None:
    page.evaluate(UNFOLD)
    for scheme in SCHEMES:
        look(page, width, scheme)
        assert sideways(page) + empty_figures(page) + faint_texts(page) == []
    texts = seen_texts(page)
    assert overlapping_texts(texts) + cut_texts(texts) + small_texts(texts) == []


@pytest.mark.parametrize(
    ("width", "scheme"), [(DESKTOP, "light"), (PHONE, "dark"), pytest.param(DESKTOP, "dark", marks=pytest.mark.slow)]
)
def test_no_serious_fault_of_accessibility(page: Page, width: int, scheme: Scheme) -> None:
    look(page, width, scheme)
    assert serious_faults(page) == []  # the last test on this page: it is pruned


def test_prints_on_a4(browser: Browser, report: Path) -> None:
    with visit(browser, report) as seen:
        printed = seen.page.pdf(prefer_css_page_size=True)
    sizes = {tuple(map(float, box.split()[2:])) for box in re.findall(rb"/MediaBox \[([^\]]+)\]", printed)}
    assert sizes
    assert all(abs(a - b) < 1.0 for size in sizes for a, b in zip(size, A4, strict=True))
    assert len(printed) < LARGEST_PDF


def test_the_file_is_not_too_large(report: Path) -> None:
    assert report.stat().st_size < LARGEST_PAGE
