"""Show a page or a picture to the one who typed."""

from __future__ import annotations

import os
import sys
import webbrowser
from pathlib import Path

from .shown.output import clean

SCREENS = ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER")


def open_file(path: Path) -> bool:
    """Open a file in the viewer of its kind, or the browser; say on standard error where there is none.

    Returns
    -------
    bool
        Whether a program took it.
    """
    opened = False
    if _has_screen():
        try:
            opened = webbrowser.open(path.resolve().as_uri())
        except webbrowser.Error:
            opened = False
    if not opened:
        print(f"nothing here can show it: open {clean(str(path))} yourself", file=sys.stderr)
    return opened


def _has_screen() -> bool:
    """Tell whether a browser could show itself: without a screen, one for text would take the terminal."""
    return sys.platform in {"darwin", "win32"} or any(os.environ.get(name) for name in SCREENS)
