"""The report as a picture: on a desk, on two phones, in light and dark, and on paper."""

from __future__ import annotations

import json
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
LARGEST_PAGE = 600_000  # bytes
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
    texts = seen_texts(page)
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


NEXT = 80.0  # px from the last line of the requirements to the figure


@pytest.mark.parametrize(("width", "height"), [(1440, 900), (PHONE, 844)])
def test_the_first_screen_shows_verdict_requirements_and_figure(
    browser: Browser, report: Path, width: int, height: int
) -> None:
    with visit(browser, report, width) as seen:
        seen.page.set_viewport_size({"width": width, "height": height})
        for scheme in SCHEMES:
            seen.page.emulate_media(color_scheme=scheme)
            box = seen.page.locator("#verdict .box").bounding_box()
            figure = seen.page.locator("#verdict figure svg").first.bounding_box()
            lines = seen.page.locator("#verdict .glance tbody tr, #verdict .highlights li").all()
            boxes = [one.bounding_box() for one in lines]
            assert box is not None
            assert figure is not None
            assert box["y"] + box["height"] <= height
            assert boxes
            assert all(one is not None and one["y"] >= box["y"] + box["height"] for one in boxes)
            below = max(one["y"] + one["height"] for one in boxes if one is not None)
            assert figure["y"] < max(
                height - (100 if width > PHONE else 0), below + NEXT
            )  # a long table is followed by it
            assert figure["width"] > 250
            assert seen.page.locator("#verdict").get_by_text("sha256").count() == 0
            assert sideways(seen.page) == []


def test_axes_stand_side_by_side_where_there_is_room(browser: Browser, report: Path) -> None:
    with visit(browser, report, 1440) as seen:
        panels = seen.page.locator("#verdict .panels svg")
        if panels.count() < 2:
            pytest.skip("one axis, or no closed loop")
        wide = [one.bounding_box() for one in panels.all()]
        seen.page.set_viewport_size({"width": PHONE, "height": 844})
        narrow = [one.bounding_box() for one in panels.all()]
    assert len({round(one["y"]) for one in wide if one}) == 1
    assert len({round(one["x"]) for one in narrow if one}) == 1


def test_prints_on_a4_what_is_open(browser: Browser, report: Path) -> None:
    with visit(browser, report) as seen:
        printed = seen.page.pdf(prefer_css_page_size=True)
        opened = seen.page.locator("main details[open]").count()
    tests = len(json.loads(report.with_name("results.json").read_text())["sequence"])
    assert opened == 0
    assert len(re.findall(rb"/Type\s*/Page\b", printed)) <= 5 + tests  # PDF by `run --pdf`: 2 and one a test
    sizes = {tuple(map(float, box.split()[2:])) for box in re.findall(rb"/MediaBox \[([^\]]+)\]", printed)}
    assert sizes
    assert all(abs(a - b) < 1.0 for size in sizes for a, b in zip(size, A4, strict=True))
    assert len(printed) < LARGEST_PDF


def test_the_file_is_not_too_large(report: Path) -> None:
    assert report.stat().st_size < LARGEST_PAGE
