"""What a campaign says of a recording of positions: how the unit lay."""

from __future__ import annotations

from typing import Annotated

from pydantic import AfterValidator

from .orientations.text import FACES, LIKE, direction_of


def _orientation(text: str) -> str:
    if text != FACES and direction_of(text) is None:
        raise ValueError(f"{text!r} is no position; there are: {LIKE}; or {FACES} alone")
    return text


Orientation = Annotated[str, AfterValidator(_orientation)]
