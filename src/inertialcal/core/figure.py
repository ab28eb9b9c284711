"""FigureSpec: what a figure is drawn from, which module draws it, where it stands in a report, what its caption is.

Plain data: a procedure declares its figures, the report those of a whole campaign, and nothing is loaded before one
is drawn.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Literal

Place = Literal["test", "top", "model", "budgets", ""]
LAST = 850  # of what is drawn from curves of tests


@dataclass(frozen=True)
class FigureSpec:
    """One kind of figure."""

    name: str  # As ``plot`` and ``--figure`` call it
    # That draws it: ``pictures(results)`` returns each picture that the content of ``results.json`` has data for
    module: str
    # In a report. ``{axis}`` is the axis of the picture; ``{note}`` what the picture says of these data.
    caption: str = ""
    # Names of the curves that it is drawn from, each with the title of its table in a report, in which
    # ``{axis}``, ``{of}`` and ``{record}`` (which of several, in words) are filled in. Without any of them in the
    # results the module is not asked; empty for a figure of rows.
    curves: Mapping[str, str] = field(default_factory=dict[str, str])
    order: int = LAST  # Among all figures, lowest first: a result is drawn as the first that it has data for
    # Where it stands in a report: with its test; at the top only; with the model; with budgets; nowhere
    place: Place = "test"
    top: int | None = None  # The lowest of those that there are stands at the top of the report; None for never
    rank: int = 0  # With its test: after those of lower rank
    first: bool = False  # Where there is room for some figures only: before all others but the one at the top
    partner: str = ""  # Where it stands at the top: the figure of the same test and axis that stands with it
    most: int | None = None  # How many of a test and axis are shown; None for all


_markup: list[Callable[[object], str]] = []


def draw_with(markup: Callable[[object], str]) -> None:
    """Say what draws the first figure of a result for a notebook: the package does, which knows how."""
    _markup[:] = [markup]


def markup_of(result: object) -> str:
    """Return the first figure of a result for a notebook, as markup; nothing where none can be drawn."""
    return _markup[0](result) if _markup else ""
