"""allan, psd: noise of a sensor at rest."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from .. import figures
from ..options import Frame, Json, MissionStart, Quiet, Start, Stop, Units
from ..shown.output import clean, json_out

if TYPE_CHECKING:
    from ...procedures.static_noise.files.allan import NoiseFile
    from ...procedures.static_noise.files.psd import SpectrumFile

Records = Annotated[
    list[Path],
    typer.Argument(help="Recordings of one sensor at rest: several are fitted together.", show_default=False),
]
Record = Annotated[Path, typer.Argument(help="Recording of a sensor at rest.", show_default=False)]
SampleRate = Annotated[
    float | None, typer.Option("--sample-rate", help="Samples per second, where the file has no time; or in its place.")
]
TimeColumn = Annotated[
    str | None, typer.Option("--time-column", help="Name, or number from 1, of the column with the time.")
]
Column = Annotated[
    list[str] | None, typer.Option(help="Channel to take; may be repeated. Else all of gyros and accelerometers.")
]
Quantity = Annotated[
    str | None,
    typer.Option(help="What a sample is, where the unit does not say it: rate, increment, angle (integrated), counts."),
]
Averaging = Annotated[
    str | None,
    typer.Option(help='What each sample is the mean of, where that is less than the sample interval: "1 s".'),
]
ScaleFactor = Annotated[
    list[str] | None, typer.Option(help='Of a column or group in counts: gyro="131 count/(deg/s)". May be repeated.')
]
Terms = Annotated[
    str | None,
    typer.Option(help="Terms to fit, with commas between: random_walk,bias_instability. Else those the record shows."),
]
WarmUp = Annotated[str, typer.Option(help='Leave out so much at the start of each record: "10 min".')]
KeepDisturbed = Annotated[
    bool, typer.Option("--keep-disturbed", help="Keep samples in disturbances; else they are left out and counted.")
]
Segment = Annotated[str | None, typer.Option(help='Length of the segments of the spectrum: "60 s".')]
Output = Annotated[
    Path | None,
    typer.Option(
        "--output", "-o",
        help="A folder for figures, curves (CSV) and terms (JSON); or one figure: .png, .svg or .pdf.",
        show_default=False,
    ),
]  # fmt: skip
Deviation = Annotated[
    str, typer.Option(help="Shown: overlapping, non_overlapping, modified, hadamard, overlapping_hadamard.")
]
Taus = Annotated[str, typer.Option(help="Averaging times shown: octave, decade, all, or seconds with commas between.")]
NoLines = Annotated[bool, typer.Option("--no-lines", help="Leave lines of the spectrum out of the fit.")]
Error = Annotated[str, typer.Option(help="Relative error for which the length of a record is worked out.")]
Target = Annotated[
    list[str] | None, typer.Option("--for", help="Settings of a filter: kalibr, px4, gtsam, kf-gins. May be repeated.")
]
Gravity = Annotated[str | None, typer.Option(help='Of the site, for gtsam: "9.81 m/s2".')]
Horizon = Annotated[
    str | None,
    typer.Option(help='With --for: a walk stands in for all that wanders, right at this averaging time: "100 s".'),
]


def allan(
    files: Records,
    unit: Units = [],  # noqa: B006 - typer copies it
    sample_rate: SampleRate = None,
    time_column: TimeColumn = None,
    column: Column = None,
    quantity: Quantity = None,
    averaging: Averaging = None,
    scale_factor: ScaleFactor = None,
    deviation: Deviation = "overlapping",
    taus: Taus = "octave",
    terms: Terms = None,
    no_lines: NoLines = False,
    warm_up: WarmUp = "0 s",
    keep_disturbed: KeepDisturbed = False,
    error: Error = "10 %",
    target: Target = None,
    gravity: Gravity = None,
    horizon: Horizon = None,
    start: Start = None,
    stop: Stop = None,
    mission_start: MissionStart = None,
    frame: Frame = None,
    output: Output = None,
    figure: figures.FigureName = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Run the command; its help stands in the declaration of the procedure."""
    from ...procedures.static_noise.files.allan import allan as reduce_files
    from ...procedures.static_noise.files.settings import quantity as said
    from ..shown.noise_text import blocks_text, noise_text

    _check_output(output, figure)
    site = None if gravity is None else said(gravity, "m/s^2", "--gravity", "9.81 m/s2")
    over = None if horizon is None else said(horizon, "s", "--horizon", "100 s")
    with _named(files):
        found = reduce_files(
            list(files), columns=column or (), quantity=quantity, scale_factors=_scale_factors(scale_factor),  # type: ignore[arg-type]
            deviation=deviation, taus=taus, terms=_listed(terms), lines=not no_lines, warm_up=warm_up,
            keep_disturbed=keep_disturbed, relative_error=error,
            **_recorded(unit, sample_rate, averaging, time_column, start, stop, mission_start, frame),
        )  # fmt: skip
        blocks = {one: found.for_filter(one, site, over) for one in target or ()}
    written = _write(output, found, blocks, files, figure)
    if as_json:
        filters = {one: {"text": block.text, "cannot_hold": list(block.cannot_hold), "missing": list(block.missing)}
                   for one, block in blocks.items()}  # fmt: skip
        _json("allan", found, written, {"filters": filters} if filters else {})
    elif not quiet:
        print(noise_text(found))
        print("".join(f"\n{text}\n" for text in blocks_text(blocks)), end="")
        _print_written(written)
    return 0


def psd(
    file: Record,
    unit: Units = [],  # noqa: B006 - typer copies it
    sample_rate: SampleRate = None,
    time_column: TimeColumn = None,
    column: Column = None,
    quantity: Quantity = None,
    averaging: Averaging = None,
    scale_factor: ScaleFactor = None,
    method: Annotated[str, typer.Option(help="welch or multitaper.")] = "welch",
    segment: Segment = None,
    terms: Terms = None,
    warm_up: WarmUp = "0 s",
    keep_disturbed: KeepDisturbed = False,
    start: Start = None,
    stop: Stop = None,
    mission_start: MissionStart = None,
    frame: Frame = None,
    output: Output = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Run the command; its help stands in the declaration of the procedure."""
    from ...procedures.static_noise.files.psd import psd as reduce_file
    from ..shown.noise_text import spectrum_text

    _check_output(output, None)
    with _named([file]):
        found = reduce_file(
            file, method=method, segment=segment, columns=column or (), quantity=quantity,  # type: ignore[arg-type]
            scale_factors=_scale_factors(scale_factor), terms=_listed(terms), warm_up=warm_up,
            keep_disturbed=keep_disturbed,
            **_recorded(unit, sample_rate, averaging, time_column, start, stop, mission_start, frame),
        )  # fmt: skip
    written = _write(output, found, {}, [file], None)
    if as_json:
        _json("psd", found, written, {})
    elif not quiet:
        print(spectrum_text(found))
        _print_written(written)
    return 0


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


def _scale_factors(given: list[str] | None) -> dict[str, str]:
    from ..pairs import pairs

    return pairs(given or [], "--scale-factor", 'gyro="131 count/(deg/s)"')


def _listed(given: str | None) -> list[str] | None:
    return None if given is None or given == "auto" else [part.strip() for part in given.split(",") if part.strip()]


def _check_output(output: Path | None, figure: str | None) -> None:
    """Refuse, before anything is computed, what cannot be written.

    Raises
    ------
    UsageError
        If a figure is chosen and no file for it is named, or a figure's ending is none.
    """
    if output is None or output.suffix:
        figures.check_figure(output, {"--figure": figure})
    elif figure is not None:
        from ...core.errors import UsageError

        raise UsageError(f"--figure {figure}: a folder takes all figures", do="Name a file: -o figure.png")


def _write(
    output: Path | None, found: NoiseFile | SpectrumFile, blocks: dict[str, Any], files: list[Path], figure: str | None
) -> list[str]:
    """Write the folder or the figure; return a line a file."""
    if output is None:
        return []
    if output.suffix:
        return [figures.write(output, found, files, {"figure": figure}, most=3)]
    from .static_noise_folder import write_folder

    return [clean(f"written: {path}") for path in write_folder(output, found, blocks)]


def _print_written(lines: list[str]) -> None:
    for line in lines:
        print(line)


def _json(command: str, found: NoiseFile | SpectrumFile, written: list[str], more: dict[str, Any]) -> None:
    content = found.content()
    inputs = [{"path": path, "sha256": digest} for path, digest in found.inputs.items()]
    said = {"inputs": inputs, "remarks": [remark.to_dict() for remark in found.remarks]}
    files = [line.removeprefix("written: ") for line in written]
    json_out(command, content | said | more | ({"written": files} if files else {}))
