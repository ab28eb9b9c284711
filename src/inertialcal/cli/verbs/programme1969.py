"""programme-1969: a deck of cards or a recorded series, reduced as in 1969."""

from __future__ import annotations

import inspect
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ...core.errors import UsageError
from ...procedures.given import Said
from ..nouns.factory import said_of, said_options
from ..options import Json, Quiet, with_options
from ..shown.output import clean, json_out

if TYPE_CHECKING:
    from ...procedures.mass_attraction.deck import Deck1969


OWN: dict[str, tuple[Any, Any]] = {
    "tilt": (Annotated[str | None, typer.Option(help="Column of the tilt meter.")], None),
    "period": (
        Annotated[
            str | None, typer.Option(help="Of the drive, a whole number of samples, zero at the first. Example: 480 s.")
        ],
        None,
    ),
    "half_period": (
        Annotated[
            int | None, typer.Option("--half-period", help="The same in samples, as on the cards. 2 if not given.")
        ],
        None,
    ),
    "sample_time": (
        Annotated[
            str | None,
            typer.Option("--sample-time", help="From sample to sample, in place of the file's times. Example: 120 s."),
        ],
        None,
    ),
    "amplitude": (
        Annotated[
            str | None, typer.Option(help="Of the input, for the scale factor. Example: 23 ng.", show_default=False)
        ],
        None,
    ),
    "reductions": (
        Annotated[
            list[str],
            typer.Option(
                "--reduction",
                help='"none", "tilt trace", "straight line", "harmonics 10", "adjusted curve 3"; all if not given.'
                " May be repeated.",
            ),
        ],
        [],
    ),
    "samples": (
        Annotated[int | None, typer.Option(help="How many are used; all whole cycles if not given.")],
        None,
    ),
    "lags": (
        Annotated[int | None, typer.Option(help="Of the correlations; 0.6 of the samples if not given.")],
        None,
    ),
    "lines": (Annotated[int | None, typer.Option(help="Of the spectrum; half of the samples if not given.")], None),
    "wrong": (Annotated[list[int], typer.Option(help="Position of a wrong value, from 1. May be repeated.")], []),
}


def _programme_1969(**given: Any) -> int:
    """Reduce card images or a recorded series as the programme of 1969 does, next to the same reductions done right."""
    from ...campaign.calls.given import read_as_said
    from ...procedures.mass_attraction.recorded_series import programme_1969 as reduced

    file, output, said = given["file"], given["output"], said_of(given)
    own: dict[str, Any] = {name: None if given[name] == [] else given[name] for name in OWN}
    source: Any = file
    if said != Said() or any(one is not None for one in own.values()):
        source = read_as_said(file, said, whole=True)
        others = [name for what, name in said.columns.items() if what != "tilt"]
        if len(others) > 1:
            raise UsageError(f"columns {' and '.join(others)}", do="Give the one of the accelerometer: --column COLUMN")
        own |= {"column": next(iter(others), None), "tilt": own["tilt"] or said.columns.get("tilt")}
    found = reduced(source, **own | {"wrong": given["wrong"]})
    written = [] if output is None else _write(output, found, file)
    if given["as_json"]:
        json_out("programme-1969", found.content() | ({"written": written} if written else {}))
    elif not given["quiet"]:
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
            path.write_text(curve_csv(curve.to_dict()), encoding="utf-8", newline="\n")
        written.append(str(folder / f"{curve.name}.csv"))
    return written


programme_1969 = with_options(
    _programme_1969,
    {
        "file": (
            Annotated[
                Path,
                typer.Argument(
                    help="Card images, a line a card; or a recording, with options below.", show_default=False
                ),
            ],
            inspect.Parameter.empty,
        ),
        **OWN,
        **said_options(),
        "output": (
            Annotated[
                Path | None,
                typer.Option(
                    "--output",
                    "-o",
                    help="Write series, correlations, spectrum and Fourier lines as CSV into this folder.",
                    show_default=False,
                ),
            ],
            None,
        ),
        "as_json": (Json, False),
        "quiet": (Quiet, False),
    },
)
