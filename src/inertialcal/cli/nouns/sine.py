"""sine: a known drive in drift."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from .. import figures
from ..options import Frame, Json, MissionStart, Quiet, Start, Stop, Units
from ..shown.output import json_out

if TYPE_CHECKING:
    from ...procedures.sine.files import SineFile


SampleRate = Annotated[
    float | None, typer.Option("--sample-rate", help="Samples per second, where the file has no time; or in its place.")
]
TimeColumn = Annotated[
    str | None, typer.Option("--time-column", help="Name, or number from 1, of the column with the time.")
]
Averaging = Annotated[
    str | None,
    typer.Option(help='What each sample is the mean of, where that is less than the sample interval: "1 s".'),
]


def sine(
    file: Annotated[Path, typer.Argument(help="Recording of a sensor under the drive.", show_default=False)],
    period: Annotated[
        str | None, typer.Option(help='Of a sine, pauses between samples included: "480 s".', show_default=False)
    ] = None,
    phase: Annotated[
        str | None, typer.Option(help='Of the sine at the first sample: "90 deg"; free if not said.')
    ] = None,
    schedule: Annotated[
        Path | None, typer.Option(help="CSV of dwells and what is applied in each, in place of --period.")
    ] = None,
    column: Annotated[str | None, typer.Option(help="Channel; the only one if not named.")] = None,
    drift: Annotated[str, typer.Option(help="dct (a line and the lowest cosines) or polynomial.")] = "dct",
    order: Annotated[int | None, typer.Option(help="Highest cosine, or degree of the polynomial.")] = None,
    side_bands: Annotated[
        int | None, typer.Option("--side-bands", help="Lines on each side from which the noise is told.")
    ] = None,
    unit: Units = [],  # noqa: B006 - typer copies it
    sample_rate: SampleRate = None,
    time_column: TimeColumn = None,
    averaging: Averaging = None,
    start: Start = None,
    stop: Stop = None,
    mission_start: MissionStart = None,
    frame: Frame = None,
    output: figures.FigureFile = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Run the command; its help stands in the declaration of the procedure."""
    from ...procedures.sine.files import sine as reduce_file

    figures.check_figure(output)
    with _named([file] if schedule is None else [file, schedule]):
        found = reduce_file(
            file, period=period, phase=phase, schedule=schedule, column=column, drift=drift, order=order,
            side_bands=side_bands,
            **_recorded(unit, sample_rate, averaging, time_column, start, stop, mission_start, frame),
        )  # fmt: skip
    line = "" if output is None else figures.write(output, found, list(found.inputs), {"figure": "sine"})
    if as_json:
        inputs = [{"path": name, "sha256": digest} for name, digest in found.inputs.items()]
        content: dict[str, Any] = {"inputs": inputs, **found.content()}
        content |= {"remarks": [one.to_dict() for one in found.remarks]}
        json_out("sine", content | ({"written": str(output)} if line else {}))
    elif not quiet:
        _print(found, line)
    return 0


def _print(found: SineFile, line: str) -> None:
    """Print the figures, what was fitted, what there is to say, and what was written."""
    from ...core.show.tables import text
    from ..shown.summary import remarks_text

    print(text(found.tables()))
    for one in remarks_text([remark.to_dict() for remark in found.remarks]):
        print(one)
    if line:
        print(line)


@contextmanager
def _named(files: Sequence[Path]) -> Iterator[None]:
    """Let a refusal name the files that it is about, with their hashes, as far as they can be read."""
    from ...core.errors import InertialcalError

    try:
        yield
    except InertialcalError as error:
        from ...files.source import load

        for path in files:
            with suppress(InertialcalError):
                error.inputs = (*error.inputs, (str(path), load(path).sha256))
        raise


def _recorded(
    unit: list[str], sample_rate: float | None, averaging: str | None, time_column: str | None, start: str | None,
    stop: str | None, mission_start: str | None, frame: str | None,
) -> dict[str, Any]:  # fmt: skip
    """Return what was said of the recording itself."""
    from ..pairs import pairs

    return {
        "units": pairs(unit, "--unit", "gyro=deg/s"), "sample_rate": sample_rate, "averaging": averaging,
        "time_column": time_column, "start": start, "stop": stop, "mission_start": mission_start, "frame": frame,
    }  # fmt: skip
