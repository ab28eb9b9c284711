"""What a campaign says of a recording of positions: how the unit lay."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Protocol

from pydantic import AfterValidator, Field

from ...core.schema.quantities import Angle
from ...core.schema.words import Text
from ..entries import Entry, EntryKey
from .orientations.text import FACES, LIKE, direction_of


def _orientation(text: str) -> str:
    if text != FACES and direction_of(text) is None:
        raise ValueError(f"{text!r} is no position; there are: {LIKE}; or {FACES} alone")
    return text


Orientation = Annotated[str, AfterValidator(_orientation)]


class PositionsEntry(Entry, Protocol):
    """A recording of a unit that was laid by hand."""

    @property
    def orientations(self) -> Sequence[str] | None:
        """How it lay, position by position."""
        ...

    @property
    def sections(self) -> str | None:
        """A file, or a column, of its labelled parts."""
        ...

    @property
    def turn(self) -> float | None:
        """Angle of a turn [rad]."""
        ...


def _alone(orientations: Sequence[str]) -> str:
    both = FACES in orientations and list(orientations) != [FACES]
    return f'orientations: "{FACES}" stands alone, for all positions' if both else ""


KEYS = (
    EntryKey("orientations", Annotated[list[Orientation], Field(min_length=1)], wrong=_alone),
    EntryKey("sections", Text),
    EntryKey("turn", Angle),
)
