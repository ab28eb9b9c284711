"""Provenance of a run: what went in, what worked on it, when, and how to do it again."""

from __future__ import annotations

import platform
import shlex
from collections.abc import Mapping
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from typing import Any

PACKAGES = ("inertialcal", "numpy", "scipy", "numba", "pyarrow", "h5py", "pydantic")


def versions() -> dict[str, str]:
    """Return the versions of Python and of the packages that figures depend on."""
    found = {"python": platform.python_version()}
    for name in PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "unknown"
    return found


def provenance(inputs: Mapping[str, str], folder: str, options: Mapping[str, Any]) -> dict[str, Any]:
    """Return the content of ``provenance.json``.

    Parameters
    ----------
    inputs : mapping of str to str
        SHA-256 of each input, by its path in the campaign folder.
    folder : str
        Of the campaign, as the user gave it.
    options : mapping
        Of the run.
    """
    return {
        "schema": 1,
        "made": datetime.now(UTC).isoformat(timespec="seconds"),
        "machine": {"system": platform.system(), "machine": platform.machine()},
        "versions": versions(),
        "inputs": [{"path": path, "sha256": digest} for path, digest in sorted(inputs.items())],
        "options": dict(options),
        "rerun": f"inertialcal run {shlex.quote(folder)}",
    }
