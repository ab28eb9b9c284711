"""Figures of a page kept by what they show: many tests run the same campaign, and drawing takes most of a run.

A figure is a function of the results and of its place on the page, so it is drawn once for all tests of a session,
whichever process they are in. What a test asks of drawing itself, as the same bytes every time, it asks of figures
that are drawn anew: fixture ``drawn_anew``.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from markupsafe import Markup

from inertialcal.report.drawings import Drawing, Results

NOT_DRAWN = ("sensors", "exclusions")  # told in words; figures do not get to see them here


def keeping(of_campaign: Callable[[Results], list[Drawing]], folder: Path) -> Callable[[Results], list[Drawing]]:
    """Return what gives the figures of a campaign, their markup kept in a folder."""

    def kept(results: Results) -> list[Drawing]:
        shown = {name: part for name, part in results.items() if name not in NOT_DRAWN}
        content = json.dumps(shown, sort_keys=True)
        found = of_campaign(shown)
        for one in found:
            path = folder / hashlib.sha256(f"{one.key}\n{content}".encode()).hexdigest()
            object.__setattr__(one, "svg", Kept(one.svg, path))  # it is frozen
        return found

    return kept


class Kept:
    """Markup that is drawn where nobody has drawn it yet."""

    def __init__(self, draw: Callable[[], Markup], path: Path) -> None:
        self.draw = draw
        self.path = path

    def __call__(self) -> Any:
        if self.path.exists():
            return Markup(self.path.read_text(encoding="utf-8", errors="surrogatepass"))
        drawn = self.draw()
        own = self.path.with_suffix(f".{os.getpid()}")
        own.write_text(drawn, encoding="utf-8", errors="surrogatepass")
        own.replace(self.path)  # whole or not at all: another process may look for it
        return drawn
