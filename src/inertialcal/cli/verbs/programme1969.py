"""programme-1969: a deck of cards, reduced as in 1969."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..options import Json, Quiet
from ..shown.output import clean, json_out

if TYPE_CHECKING:
    from ...procedures.mass_attraction.deck import Deck1969


def programme_1969(
    deck: Annotated[Path, typer.Argument(help="Card images, a line a card.", show_default=False)],
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            help="Write series, correlations, spectrum and Fourier lines as CSV into this folder.",
            show_default=False,
        ),
    ] = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Reduce a deck of card images as the programme of 1969 does, next to the same reductions done right."""
    from ...procedures.mass_attraction.deck import programme_1969 as reduce_deck

    found = reduce_deck(deck)
    written = [] if output is None else _write(output, found, deck)
    if as_json:
        json_out("programme-1969", found.content() | ({"written": written} if written else {}))
    elif not quiet:
        print("\n".join([str(found), *(clean(f"written: {one}") for one in written)]))
    return 0


def _write(folder: Path, found: Deck1969, deck: Path) -> list[str]:
    """Write the curves, a file a kind; return their paths."""
    from ...core.errors import StoreError
    from ...files.write.atomic import atomic_write
    from ...report.drawings import curve_csv

    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise StoreError(
            f"cannot make the folder: {error.strerror or error}", str(folder), code="not_written"
        ) from None
    written = []
    for curve in found.curves():
        with atomic_write(folder / f"{curve.name}.csv", [deck]) as path:
            path.write_text(curve_csv(curve.to_dict()), encoding="utf-8")
        written.append(str(folder / f"{curve.name}.csv"))
    return written
