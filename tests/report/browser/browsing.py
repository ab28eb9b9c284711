"""A page in Debian's Chromium with the network blocked; all that it asks for, says and opens is kept."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from playwright.sync_api import Browser, BrowserContext, Dialog, Page, Request, Route

FLAGS = (
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)
DESKTOP, PHONE, SMALL_PHONE = 1280, 390, 320  # px
HEIGHT = {DESKTOP: 900, PHONE: 844, SMALL_PHONE: 568}
PAPER = 718  # px: A4 less 10 mm on each side, at 96 to the inch
PAPER_HEIGHT = 1047  # px
PATIENCE = 120_000.0  # ms: a busy machine is no failure


@dataclass
class Visit:
    """An open page, and what happened in it."""

    page: Page
    path: Path = Path()
    url: str = ""
    requests: list[str] = field(default_factory=list)
    happened: list[str] = field(default_factory=list)

    @property
    def loaded(self) -> list[str]:
        """Addresses that were asked for beyond the page itself."""
        return self.requests[1:] if self.requests[:1] == [self.url] else self.requests

    def open(self, path: Path) -> None:
        """Open a file, and forget what happened before."""
        self.path, self.url = path, path.resolve().as_uri()
        self.requests.clear()
        self.happened.clear()
        self.page.goto(self.url, wait_until="load")

    def watch(self, context: BrowserContext) -> None:
        """Keep what happens from now on; nothing but the page itself is let through."""
        context.route("**/*", self._only_the_page)
        context.on("request", self._requested)
        context.on("dialog", self._dialog)
        context.on("page", lambda page: self.happened.append(f"opened: {page.url}"))
        context.on("weberror", lambda error: self.happened.append(f"error: {error.error}"))
        context.on("console", lambda said: self.happened.append(f"console: {said.type}: {said.text}"))
        self.page.on("download", lambda download: self.happened.append(f"downloaded: {download.url}"))
        self.page.on("websocket", lambda socket: self.requests.append(socket.url))

    def _only_the_page(self, route: Route) -> None:
        if route.request.url == self.url:
            route.continue_()
        elif route.request.is_navigation_request():
            route.fulfill(status=204)  # no content: what was to be left stays
        else:
            route.abort()

    def _requested(self, request: Request) -> None:
        self.requests.append(request.url)

    def _dialog(self, dialog: Dialog) -> None:
        self.happened.append(f"dialog: {dialog.message}")
        dialog.dismiss()


@contextmanager
def visit(browser: Browser, path: Path, width: int = DESKTOP, **options: Any) -> Iterator[Visit]:
    """Open a file at a width, without animations; ``options`` are those of a browser context (``permissions``, ...)."""
    size: Any = {"width": width, "height": HEIGHT.get(width, PAPER_HEIGHT)}
    context = browser.new_context(viewport=size, reduced_motion="reduce", **options)
    try:
        context.set_default_timeout(PATIENCE)
        found = Visit(context.new_page())
        found.watch(context)
        found.open(path)
        yield found
    finally:
        context.close()
