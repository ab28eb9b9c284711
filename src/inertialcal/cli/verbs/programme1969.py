"""programme-1969: a deck of cards or a recorded series, reduced as in 1969."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..options import Json, MissionStart, Quiet, Start, Stop, Units, pairs
from ..shown.output import clean, json_out

if TYPE_CHECKING:
    from ...procedures.mass_attraction.deck import Deck1969


def programme_1969(
    file: Annotated[
        Path,
        typer.Argument(help="Card images, a line a card; or a recording, with options below.", show_default=False),
    ],
    column: Annotated[
        str | None, typer.Option(help="Column of the accelerometer; by default the only one of numbers.")
    ] = None,
    tilt: Annotated[str | None, typer.Option(help="Column of the tilt meter.")] = None,
    period: Annotated[
        str | None, typer.Option(help="Of the drive, a whole number of samples, zero at the first. Example: 480 s.")
    ] = None,
    half_period: Annotated[
        int | None, typer.Option("--half-period", help="The same in samples, as on the cards. 2 if not given.")
    ] = None,
    sample_time: Annotated[
        str | None,
        typer.Option("--sample-time", help="From sample to sample, in place of the file's times. Example: 120 s."),
    ] = None,
    amplitude: Annotated[
        str | None, typer.Option(help="Of the input, for the scale factor. Example: 23 ng.", show_default=False)
    ] = None,
    reduction: Annotated[
        list[str],
        typer.Option(
            help='"none", "tilt trace", "straight line", "harmonics 10", "adjusted curve 3"; all if not given.'
            " May be repeated."
        ),
    ] = [],  # noqa: B006 - typer copies it
    samples: Annotated[int | None, typer.Option(help="How many are used; all whole cycles if not given.")] = None,
    lags: Annotated[int | None, typer.Option(help="Of the correlations; 0.6 of the samples if not given.")] = None,
    lines: Annotated[int | None, typer.Option(help="Of the spectrum; half of the samples if not given.")] = None,
    wrong: Annotated[list[int], typer.Option(help="Position of a wrong value, from 1. May be repeated.")] = [],  # noqa: B006 - typer copies it
    unit: Units = [],  # noqa: B006 - typer copies it
    time_column: Annotated[
        str | None, typer.Option("--time-column", help="Name, or number from 1, of the column with the time.")
    ] = None,
    start: Start = None,
    stop: Stop = None,
    mission_start: MissionStart = None,
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
    """Reduce card images or a recorded series as the programme of 1969 does, next to the same reductions done right."""
    from ...procedures.mass_attraction.recorded_series import programme_1969 as reduced

    said: dict[str, Any] = {
        "column": column, "tilt": tilt, "period": period, "half_period": half_period, "sample_time": sample_time,
        "amplitude": amplitude, "reductions": reduction or None, "samples": samples, "lags": lags, "lines": lines,
        "wrong": wrong, "units": pairs(unit, "--unit", "pulses=count") or None, "time_column": time_column,
        "start": start, "stop": stop, "mission_start": mission_start,
    }  # fmt: skip
    found = reduced(file, **said)
    written = [] if output is None else _write(output, found, file)
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
            path.write_text(curve_csv(curve.to_dict()), encoding="utf-8", newline="\n")
        written.append(str(folder / f"{curve.name}.csv"))
    return written
