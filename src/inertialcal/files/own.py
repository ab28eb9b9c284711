"""Files and folders of our own, which are no recordings: what they are, and what to type for them."""

from __future__ import annotations

import shlex
import tomllib
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path

from ..core.campaign_text import FILE, LOT

LOT_DONE = "lot.json"  # of what a lot wrote


@dataclass(frozen=True)
class Own:
    """What a path names, by which file, and what to do with it."""

    what: str
    file: str
    do: str


def own(path: Path) -> Own | None:
    """Return what a folder or a file is that we know by its name; None for any other."""
    folder, names = (path, (LOT, LOT_DONE, FILE)) if path.is_dir() else (path.parent, (path.name,))
    found = next((name for name in names if (folder / name).is_file()), "")
    if found == LOT:
        return _lot(path)
    if found == LOT_DONE:
        return Own("what a lot gave", found, f"open {folder / 'report.html'} in a browser")
    if found == FILE:
        return Own(
            "a campaign" if path.is_dir() else "the file of a campaign",
            found,
            f"inertialcal run {shlex.quote(str(folder))}",
        )
    return None


def around(recording: Path) -> Own | None:
    """Return the lot or the campaign that a recording lies in, at most two folders up; None where there is none."""
    near = (recording, *recording.parents[:2])
    home = next((one for one in near if (one / FILE).is_file() or (one / LOT).is_file()), None)
    found = None if home is None else own(home)
    if home is None or found is None or found.file != FILE:
        return found
    unit, *rest = recording.relative_to(home).parts or ("",)
    named, file = _recordings_of(home / FILE), "/".join(rest)
    of_unit = file in named and f"{unit}/{file}" not in named and not (home / file).exists()
    return _lot(home) if of_unit else found


def _recordings_of(campaign: Path) -> frozenset[str]:
    """Return the files that a campaign names; none of one that cannot be read, which is judged elsewhere."""
    try:
        entries = tomllib.loads(campaign.read_text(encoding="utf-8-sig")).get("recordings")
    except (OSError, ValueError):
        return frozenset()
    every = entries.values() if isinstance(entries, dict) else ()
    return frozenset(file for one in every if isinstance(one, dict) and isinstance(file := one.get("file"), str))


def lot_in(folder: Path, files: Collection[str]) -> Own | None:
    """Return the lot whose template is the campaign of a folder without its files; None where there is none.

    Parameters
    ----------
    folder : Path
        That holds LOT.toml, or a folder for each unit.
    files : collection of str
        Recordings that the campaign names.
    """
    if (folder / LOT).is_file():
        return _lot(folder)
    units = (one for one in folder.glob("[!.]*") if one.is_dir())
    return _lot(folder) if any((one / file).exists() for one in units for file in files) else None


def _lot(path: Path) -> Own:
    folder = path if path.is_dir() else path.parent
    made = folder.parent / f"{folder.resolve().name}-out"
    return Own("a lot of units", LOT, f"inertialcal lot {shlex.quote(str(path))} -o {shlex.quote(str(made))}")
