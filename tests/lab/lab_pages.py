"""A page of the lab in a browser: what it asks for of others, and what goes wrong in it, is kept."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from browsing import PATIENCE
from playwright.sync_api import Browser, ConsoleMessage, Dialog, Page, Request

READ_BACK = "Multiple readback operations"  # what chromium says of a canvas that is read several times


@contextmanager
def opened(
    browser: Browser, address: str, width: int = 1280, scheme: str = "light"
) -> Iterator[tuple[Page, list[str]]]:
    """Open the page, and keep what it asks for of others and what goes wrong in it."""
    context = browser.new_context(viewport={"width": width, "height": 900}, color_scheme=scheme)  # type: ignore[arg-type]
    try:
        context.set_default_timeout(PATIENCE)
        page, odd = context.new_page(), list[str]()
        place = address.partition("?")[0]

        def asked(one: Request) -> None:
            if not one.url.startswith(place):
                odd.append(f"asked: {one.url}")

        def said(one: ConsoleMessage) -> None:
            if READ_BACK not in one.text:  # by the tests, where the machine is slow; the page reads none
                odd.append(f"console: {one.text}")

        def dialog(one: Dialog) -> None:
            odd.append(f"dialog: {one.message}")
            one.dismiss()

        page.on("request", asked)
        page.on("dialog", dialog)
        page.on("pageerror", lambda one: odd.append(f"error: {one}"))
        page.on("console", said)
        page.goto(address)
        yield page, odd
    finally:
        context.close()


def until(page: Page, holds: Callable[[], object], seconds: float = 60.0) -> bool:
    """Wait until something holds; return whether it does."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if holds():
            return True
        page.wait_for_timeout(50)
    return False
