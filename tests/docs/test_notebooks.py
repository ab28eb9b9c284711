"""The notebooks of the gallery: made of their cells, executed, and as they print now."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[2]
GALLERY = ROOT / "docs" / "gallery"
NOTEBOOKS = sorted(GALLERY.glob("*.ipynb"))
PLACES = re.compile(r"/(home|root|tmp|usr|work)/|[A-Z]:\\|\d{4}-\d\d-\d\dT\d\d:")
LARGEST = 300_000  # bytes


def outputs(path: Path) -> list[dict[str, Any]]:
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    return [one for cell in cells for one in cell.get("outputs", [])]


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_is_executed_small_and_of_no_machine(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    kinds = {kind for one in outputs(path) for kind in one.get("data", {})}
    assert {"text/plain", "text/html", "image/png"} <= kinds
    assert not [one for one in outputs(path) if one["output_type"] == "error"]
    assert len(text.encode()) < LARGEST
    words = [str(part) for one in outputs(path) for kind, part in one.get("data", {}).items() if kind != "image/png"]
    assert not PLACES.search("\n".join(words))
    assert any("± u" in str(one.get("data", {}).get("text/plain", "")) for one in outputs(path))


@pytest.mark.slow
def test_notebooks_print_what_is_committed() -> None:
    command = [sys.executable, str(ROOT / "docs" / "notebooks.py"), "--check"]
    found = subprocess.run(command, capture_output=True, text=True, timeout=900, check=False)
    assert found.returncode == 0, found.stderr[-2000:]
