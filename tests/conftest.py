"""What all tests share: the folder of other people's recordings, which may be absent."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture(scope="session")
def shared() -> Path:
    """Folder with ``data/`` and ``reference/``; the test is skipped, and says so, where it is absent."""
    folder = Path(os.environ.get("INERTIALCAL_SHARED", ROOT.parent / "shared"))
    if not folder.is_dir():
        pytest.skip(f"no recordings of others: {folder} is absent (set INERTIALCAL_SHARED)")
    return folder
