"""The table of speed as text, and the ratios that are kept beside it, which tell what has become slower."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable, Mapping
from pathlib import Path

from .comparison import Measured

KEPT = Path(__file__).with_name("ratios.csv")
SLOWER = 0.8  # of the stored ratio: a regression
HEADS = ("product", "peer", "own", "of peer", "ratio", "best", "limit", "goal", "")


def stored(path: Path = KEPT) -> dict[str, float]:
    """Return the stored ratio of each line by its name."""
    if not path.exists():
        return {}
    with path.open(encoding="utf-8", newline="") as file:
        return {row["product"]: float(row["ratio"]) for row in csv.DictReader(file)}


def store(done: Iterable[Measured], path: Path = KEPT) -> None:
    """Store the ratios of the lines measured; those of the other lines stay."""
    ratios = stored(path) | {one.line.name: one.ratio for one in done}
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(("product", "ratio"))
        writer.writerows((name, f"{ratio:.3g}") for name, ratio in sorted(ratios.items()))


def row(one: Measured) -> tuple[str, ...]:
    """Return a line of the table as text."""
    limit = "" if math.isinf(one.limit) else f"{one.limit:.3g}"
    if not one.line.goal:
        met = ""
    else:
        met = "met" if one.ratio >= one.line.goal else "met at best" if one.best >= one.line.goal else "not met"
    return (
        one.line.name, one.line.peer, amount(one.own, one.unit), amount(one.peer, one.unit), f"{one.ratio:.3g}",
        f"{one.best:.3g}", limit, f"{one.line.goal:g}" if one.line.goal else "none", met,
    )  # fmt: skip


def amount(value: float, unit: str) -> str:
    """Return a time or another amount as people read it."""
    if unit != "s":
        return f"{value:.4g} {unit}"
    return f"{value:.3g} s" if value >= 1.0 else f"{1e3 * value:.3g} ms"


def table(rows: Iterable[tuple[str, ...]]) -> str:
    """Return rows as text, the heads above."""
    every = [HEADS, *rows]
    widths = [max(len(one[i]) for one in every) for i in range(len(HEADS))]
    return "\n".join("  ".join(cell.ljust(w) for cell, w in zip(one, widths, strict=True)).rstrip() for one in every)


def regressions(done: Iterable[Measured], before: Mapping[str, float]) -> list[str]:
    """Return what has become slower by more than a fifth, at its median and at its best, one text a line."""
    return [
        f"{one.line.name}: ratio {one.ratio:.3g} (best {one.best:.3g}), stored {before[one.line.name]:.3g}"
        for one in done
        if one.line.name in before and max(one.ratio, one.best) < SLOWER * before[one.line.name]
    ]
