"""A reader at work on the report: finds the verdict, follows the contents, copies a coefficient, uses the keyboard."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from browsing import DESKTOP, PHONE, Visit, visit
from playwright.sync_api import Browser, Locator, Page

NAMES = ("published", pytest.param("simulated", marks=pytest.mark.slow))
COPY = ".coefficients button.copy[data-copy]"

# Whether the top of an element is to be seen: inside the window, and not under what sticks to its edge.
IN_SIGHT = """e => {
  const r = e.getBoundingClientRect();
  if (r.top < -1 || r.top > innerHeight - 1) return false;
  const at = document.elementFromPoint(r.left + Math.min(r.width, 40) / 2, Math.max(r.top, 0) + 2);
  return at !== null && (e === at || e.contains(at) || at.contains(e));
}"""

TEXTS = """() => {
  const copy = document.querySelector('main').cloneNode(true);
  copy.querySelectorAll('button').forEach(one => one.remove());  // they say what they did
  return copy.textContent;
}"""


def soon(page: Page, holds: Callable[[], Any]) -> bool:
    """Return whether something comes to hold within two seconds; the policy of the page lets the page not be asked."""
    for _ in range(40):
        if holds():
            return True
        page.wait_for_timeout(50)
    return False


@pytest.fixture(scope="module", params=NAMES)
def seen(browser: Browser, reports: dict[str, Path], request: pytest.FixtureRequest) -> Iterator[Visit]:
    with visit(browser, reports[request.param], permissions=["clipboard-read", "clipboard-write"]) as opened:
        yield opened


def beside(report: Path, name: str) -> Any:
    path = report.with_name(name)
    return json.loads(path.read_text(encoding="utf-8")) if path.is_file() else None


@pytest.fixture
def results(seen: Visit) -> Any:
    return beside(seen.path, "results.json")


def test_it_asks_for_nothing_and_says_nothing(seen: Visit) -> None:
    assert seen.loaded == []
    assert seen.happened == []


def test_the_verdict_is_on_the_first_screen(seen: Visit, results: Any) -> None:
    verdict = seen.page.locator("#verdict")
    assert results["verdict"] in verdict.inner_text()
    assert verdict.evaluate(IN_SIGHT)


@pytest.mark.parametrize("width", [DESKTOP, PHONE])
def test_every_link_of_the_contents_leads_into_sight(seen: Visit, width: int) -> None:
    page = seen.page
    page.set_viewport_size({"width": width, "height": 844})
    links = page.locator("#contents a[href]")
    assert links.count() > 5
    if not links.first.is_visible():
        page.locator("#contents summary").click()
    assert links.first.is_visible()
    for number in range(links.count()):
        link = links.nth(number)
        target = (link.get_attribute("href") or "").removeprefix("#")
        assert page.locator(f'[id="{target}"]').count() == 1, target
        link.evaluate("one => one.click()")
        assert soon(page, partial(page.locator(f'[id="{target}"]').evaluate, IN_SIGHT)), f"{target} is out of sight"
    assert seen.page.url.startswith(f"{seen.url}#")


def pointed_at(seen: Visit, pointer: str) -> Any:
    """Return what a pointer of the page points at (RFC 6901)."""
    prefix, _, path = pointer.rpartition(":")
    found = beside(seen.path, f"{prefix or 'results'}.json")
    for token in path.split("/")[1:]:
        key = token.replace("~1", "/").replace("~0", "~")
        found = found[int(key)] if isinstance(found, list) else found[key]
    return found


def number_beside(button: Locator) -> str:
    """Return the pointer of the number that a button copies."""
    pointer = button.evaluate(
        "b => [...b.closest('tr, li, dd, p').querySelectorAll('data')].find(d => d.value === b.dataset.copy).dataset.at"
    )
    return str(pointer)


def test_each_copy_button_carries_the_number_of_the_file(seen: Visit) -> None:
    buttons = seen.page.locator(COPY)
    assert buttons.count() > 2
    for number in range(buttons.count()):
        button = buttons.nth(number)
        assert float(button.get_attribute("data-copy") or "") == pointed_at(seen, number_beside(button))


@pytest.mark.parametrize("way", ["mouse", "keyboard"])
def test_a_coefficient_is_copied(seen: Visit, way: str) -> None:
    button = seen.page.locator(COPY).nth(1)
    seen.page.evaluate("navigator.clipboard.writeText('nothing yet')")
    if way == "mouse":
        button.click()
    else:
        _tab_to(button)
        seen.page.keyboard.press("Enter")
    assert soon(seen.page, lambda: (seen.page.locator("#said").text_content() or "").startswith("copied"))
    text = seen.page.evaluate("navigator.clipboard.readText()")
    assert text == repr(pointed_at(seen, number_beside(button)))


def _tab_to(button: Locator) -> None:
    """Go to the button with the Tab key from what stands before it."""
    page = button.page
    page.locator(COPY).nth(0).focus()
    for _ in range(5):
        page.keyboard.press("Tab")
        if button.evaluate("b => b === document.activeElement"):
            return
    pytest.fail("five times Tab did not lead from one copy button to the next")


def test_everything_is_there_without_scripts(browser: Browser, seen: Visit) -> None:
    with visit(browser, seen.path, java_script_enabled=False) as plain:
        page = plain.page
        assert page.evaluate("document.documentElement.classList.contains('script')") is False
        assert page.locator("#verdict").is_visible()
        assert page.locator("#contents a[href]").first.is_visible()
        assert page.evaluate(TEXTS) == seen.page.evaluate(TEXTS)
        assert page.locator("figure svg").count() == seen.page.locator("figure svg").count()
        unreached = (
            "() => [...document.querySelectorAll('main section, main figure')].filter(e => !e.checkVisibility())"
        )
        assert page.evaluate(f"({unreached})().filter(e => !e.closest('details')).length") == 0
        assert [one.inner_text() for one in page.locator("button").all() if one.is_visible()] == []
        assert plain.happened == []


@pytest.mark.parametrize("width", [DESKTOP, PHONE])
def test_the_tab_key_reaches_all_that_can_be_used(seen: Visit, width: int) -> None:
    page = seen.page
    page.set_viewport_size({"width": width, "height": 844})
    unreached = page.evaluate(
        "() => [...document.querySelectorAll('a[href], button, summary')].filter(e => e.checkVisibility()"
        " && e.tabIndex < 0).length"
    )
    assert unreached == 0
    scrolled = page.evaluate(
        "() => [...document.querySelectorAll('main *')].filter(e => e.checkVisibility()"
        " && e.scrollWidth > e.clientWidth + 1 && /auto|scroll/.test(getComputedStyle(e).overflowX)"
        " && e.tabIndex < 0).length"
    )
    assert scrolled == 0
