"""What a part found: tables of cells, kept as data with their date. The page is made of it, and a test compares it."""

from __future__ import annotations

import json
import os
from dataclasses import asdict, dataclass, field
from datetime import date
from importlib.metadata import version
from pathlib import Path

KEPT = Path(__file__).resolve().parents[1] / "found.json"
ROOT = KEPT.parents[2]

Cell = str | int | float | None


class AbsentError(Exception):
    """A recording, a peer or a run that a part needs is not there."""


@dataclass(frozen=True)
class Line:
    """Cells of one line, and whether it holds what is asked of it; a line of which nothing is asked holds."""

    cells: tuple[Cell, ...]
    holds: bool = True
    judged: bool = True


@dataclass(frozen=True)
class Table:
    """A table of the page.

    ``digits`` are the significant digits of each column's numbers; where 0, a number is printed as it is.
    """

    title: str
    text: str
    heads: tuple[str, ...]
    digits: tuple[int, ...]
    lines: tuple[Line, ...] = field(default=())

    @property
    def counted(self) -> tuple[int, int]:
        """Lines that hold, of those of which something is asked."""
        judged = [one for one in self.lines if one.judged]
        return sum(one.holds for one in judged), len(judged)


@dataclass(frozen=True)
class Part:
    """Tables of a part, with the day and the version of the tool that found them."""

    day: str
    version: str
    tables: tuple[Table, ...]


def shared() -> Path:
    """Return the folder of recordings that others made.

    Raises
    ------
    AbsentError
        If it is not there.
    """
    folder = Path(os.environ.get("INERTIALCAL_SHARED", ROOT.parent / "shared")) / "data"
    if not folder.is_dir():
        raise AbsentError("the recordings of others are absent: name their folder in INERTIALCAL_SHARED")
    return folder


def load(path: Path = KEPT) -> dict[str, Part]:
    """Return what was found, part by part."""
    if not path.exists():
        return {}
    kept = json.loads(path.read_text(encoding="utf-8"))
    return {name: _part(one) for name, one in kept.items()}


def _part(kept: dict[str, object]) -> Part:
    tables = []
    for one in kept.pop("tables"):  # type: ignore[attr-defined]
        lines = tuple(Line(tuple(line["cells"]), line["holds"], line["judged"]) for line in one.pop("lines"))
        tables.append(Table(**{k: tuple(v) if isinstance(v, list) else v for k, v in one.items()}, lines=lines))
    return Part(**kept, tables=tuple(tables))  # type: ignore[arg-type]


def store(name: str, tables: list[Table], path: Path = KEPT) -> None:
    """Keep what a part found today."""
    found = load(path) | {name: Part(date.today().isoformat(), version("inertialcal"), tuple(tables))}
    text = json.dumps(
        {one: asdict(part) for one, part in sorted(found.items())},
        indent=1,
        ensure_ascii=False,
        default=lambda value: value.item(),
    )
    path.write_text(text + "\n", encoding="utf-8")
