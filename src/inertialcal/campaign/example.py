"""The examples that ship with the package."""

from __future__ import annotations

import shutil
from importlib.resources import as_file, files
from pathlib import Path

from ..core.errors import StoreError, UsageError
from .load import FILE
from .publish import OUT


def examples() -> list[str]:
    """Return the names of the examples."""
    root = files("inertialcal") / "examples"
    return sorted(entry.name for entry in root.iterdir() if (entry / FILE).is_file())


def copy_example(name: str, target: Path) -> Path:
    """Copy an example into a folder of the user's, and return that folder.

    A folder that already holds the same campaign is used as it is, with its changes.

    Raises
    ------
    UsageError
        If there is no example of that name, or something else stands where it should go.
    StoreError
        If the folder cannot be written.
    """
    if name not in examples():
        raise UsageError(f"no example {name!r}", do=f"There are: {', '.join(examples())}")
    if (target / FILE).is_file():
        return target
    if target.exists() and (not target.is_dir() or any(target.iterdir())):
        raise UsageError(f"{target} exists and is no campaign", do="Name another folder: inertialcal demo FOLDER")
    try:
        with as_file(files("inertialcal") / "examples" / name) as source:
            shutil.copytree(source, target, ignore=shutil.ignore_patterns(OUT, ".out*"), dirs_exist_ok=True)
    except OSError as error:
        raise StoreError(f"cannot write {target}: {error.strerror}", code="not_writable") from None
    return target
