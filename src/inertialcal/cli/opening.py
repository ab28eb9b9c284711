"""Show a page in the browser of the one who typed."""

from __future__ import annotations

import os
import sys
import webbrowser
from pathlib import Path

from .shown.output import clean

SCREENS = ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER")


def open_page(path: Path) -> bool:
    """Open a file in the default browser; say on standard error where there is none.

    Returns
    -------
    bool
        Whether a browser took it.
    """
    opened = False
    if _has_screen():
        try:
            opened = webbrowser.open(path.resolve().as_uri())
        except webbrowser.Error:
            opened = False
    if not opened:
        print(f"no browser here: open {clean(str(path))} in one", file=sys.stderr)
    return opened


def _has_screen() -> bool:
    """Tell whether a browser could show itself: without a screen, one for text would take the terminal."""
    return sys.platform in {"darwin", "win32"} or any(os.environ.get(name) for name in SCREENS)
