"""campaign.toml of a flip that was reduced from files alone: ``run`` then gives its figures again, and the report."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path

from ....core.campaign_text import FILE, SCHEMA, Noted, toml_text
from ....core.errors import PlanError, StoreError, UsageError
from ...suggestions import RELATIVE, sensor_table
from ..plan import Plan
from ..suggest import REQUIREMENT, STANDARDS, flip_test
from .source import FlipSource, entry_table

TEST = "flip"


def write_flip_campaign(sources: Mapping[str, FlipSource], plan: Plan, unit: str) -> Path:
    """Write campaign.toml beside the files of a flip; return its path.

    Parameters
    ----------
    sources : mapping of str to FlipSource
        By the path that was given.
    plan : Plan
        As used.
    unit : str
        Of the figures.

    Raises
    ------
    UsageError
        If the files lie in different folders.
    PlanError
        If there is a campaign already.
    StoreError
        If it cannot be written.
    """
    path = new_campaign([Path(one) for one in sources])
    try:
        with path.open("x", encoding="utf-8") as handle:
            handle.write(campaign_text(path.parent, sources, plan, unit))
    except OSError as error:
        raise StoreError(f"cannot write {path}: {error.strerror}", code="not_writable") from None
    return path


def new_campaign(paths: Sequence[Path]) -> Path:
    """Return the path of a campaign file for these files: in their folder, or the one given.

    Raises
    ------
    UsageError
        If they lie in different folders.
    PlanError
        If there is a campaign already.
    """
    folder = paths[0] if len(paths) == 1 and paths[0].is_dir() else _common([one.parent for one in paths])
    path = folder / FILE
    if path.exists():
        do = f"Run it: inertialcal run {shlex.quote(str(folder))}"
        raise PlanError(f"{path} exists already", do=do, code="exists")
    return path


def _common(parents: Sequence[Path]) -> Path:
    folders = set(parents)
    if len(folders) > 1:
        what = f"files in {len(folders)} folders: {', '.join(sorted(str(one) for one in folders))[:160]}"
        raise UsageError(what, why="a campaign is one folder", do="Put the files into one folder", code="outside")
    return folders.pop()


def campaign_text(folder: Path, sources: Mapping[str, FlipSource], plan: Plan, unit: str) -> str:
    """Return the text: one test, whose recordings are the files."""
    recordings = {
        f"rec{number}": entry_table(Path(path).relative_to(folder).as_posix(), one)
        for number, (path, one) in enumerate(sources.items(), 1)
    }
    label = "".join(c if c.isascii() and (c.isalnum() or c in "_-") else "-" for c in folder.resolve().name)
    why = "Without a requirement every figure is reported, and none is judged."
    return toml_text(
        {
            "schema": SCHEMA,
            "campaign": {"id": label.strip("-_")[:64] or TEST},
            "standards": Noted(STANDARDS, above=RELATIVE),
            "sensors": {"head": sensor_table("accelerometer", [unit])},
            "recordings": recordings,
            "tests": [flip_test(TEST, list(recordings), plan, known=True)],
            "requirements": [Noted({"id": "R1"} | REQUIREMENT, above=why, example=True)],
        }
    )
