"""What is audited: a figure, a section (a table of a document), a document."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from .printed import Printed, Recomputed, printed

Word = Literal["follows", "rounding", "misprint", "sign", "unit", "does not follow", "too coarse", "cannot be told"]
WORDS: tuple[Word, ...] = (
    "follows", "rounding", "misprint", "sign", "unit", "does not follow", "too coarse", "cannot be told",
)  # fmt: skip
STANDS: tuple[Word, ...] = ("follows", "rounding")
UNTOLD: tuple[Word, ...] = ("too coarse", "cannot be told")
Relation = Literal["equal", "at most", "at least"]


@dataclass(frozen=True)
class Variant:
    """Another reading of the same data: if it gives the printed figure, it says what went wrong."""

    reading: str
    recomputed: Recomputed
    word: Word = "does not follow"


@dataclass(frozen=True)
class Figure:
    """One printed figure against what the document's own data give.

    Parameters
    ----------
    key : str
        Names the figure inside its section.
    place : str
        Row and column, for people.
    printed : Printed
        As printed.
    recomputed : Recomputed or None
        From other figures; None where the document does not hold what is needed.
    relation : str
        What the document says of its figure: it equals, or it does not exceed, or it reaches the recomputed one.
    variants : tuple of Variant
        Tried in order where the figure does not follow.
    factors : mapping
        Unit slips beside powers of a thousand: printed over recomputed, by name.
    why : str
        Shown where the figure does not follow and no variant explains it.
    """

    key: str
    place: str
    printed: Printed
    recomputed: Recomputed | None
    unit: str = ""
    relation: Relation = "equal"
    variants: tuple[Variant, ...] = ()
    factors: Mapping[str, float] = field(default_factory=dict)
    why: str = ""


@dataclass(frozen=True)
class Text:
    """A printed word, heading or unit against the one that the data need; units are compared by dimension."""

    key: str
    place: str
    printed: str
    needed: str
    is_unit: bool = False
    why: str = ""


@dataclass(frozen=True)
class Section:
    """A table, or a group of statements: how it is recomputed, and its figures.

    ``identity`` marks figures that repeat another one, or are products and sums of their own line: that they hold says
    little about the document, so they are counted apart.
    """

    key: str
    title: str
    how: str
    figures: tuple[Figure | Text, ...]
    identity: bool = False


@dataclass(frozen=True)
class Effect:
    """What a finding means to somebody who uses the document."""

    finding: str
    effect: str


@dataclass(frozen=True)
class Document:
    """A document, its sections, and what matters most."""

    key: str
    title: str
    citation: str
    sections: tuple[Section, ...]
    effects: tuple[Effect, ...]


def figure(
    key: str,
    place: str,
    text: str | Printed,
    recomputed: Recomputed | None,
    unit: str = "",
    relation: Relation = "equal",
    variants: tuple[Variant, ...] = (),
    factors: Mapping[str, float] | None = None,
    why: str = "",
) -> Figure:
    """Return a figure from its text."""
    shown = printed(text) if isinstance(text, str) else text
    return Figure(key, place, shown, recomputed, unit, relation, variants, factors or {}, why)
