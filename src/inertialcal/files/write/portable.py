"""Names of files that every system can hold: a folder made here may be opened on Windows or macOS."""

from __future__ import annotations

import re

# Microsoft, "Naming Files, Paths, and Namespaces": signs, devices, and dots or spaces at the end.
SIGNS = re.compile(r'[\x00-\x1f<>:"/\\|?*]')
DEVICES = re.compile(r"(?:CON|PRN|AUX|NUL|CONIN\$|CONOUT\$|(?:COM|LPT)[0-9¹²³]) *(?:\..*)?", re.IGNORECASE | re.DOTALL)


def portable_name(name: str) -> str:
    """Return a name of a file, changed where Windows has no such file."""
    found = SIGNS.sub("_", name).rstrip(". ") or "_"
    return f"_{found}" if DEVICES.fullmatch(found) else found
