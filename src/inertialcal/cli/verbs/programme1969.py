"""programme-1969: a deck of cards, reduced as in 1969."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ..options import Json, Quiet
from ..shown.output import json_out


def programme_1969(
    deck: Annotated[Path, typer.Argument(help="Card images, a line a card.", show_default=False)],
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Reduce a deck of card images as the programme of 1969 does, next to the same reductions done right."""
    from ...procedures.mass_attraction.deck import programme_1969 as reduce_deck

    found = reduce_deck(deck)
    if as_json:
        json_out("programme-1969", found.content())
    elif not quiet:
        print(found)
    return 0
