"""info, rate-table: commands that work on files."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from .. import figures
from ..options import Frame, Json, MissionStart, Quiet, Start, Stop, Units
from ..shown.output import json_out

Files = Annotated[list[Path], typer.Argument(help="Recordings or tables.", show_default=False)]


def info(
    files: Files,
    unit: Units = [],  # noqa: B006 - typer copies it
    sample_rate: Annotated[
        float | None, typer.Option("--sample-rate", help="Samples per second, where the file has no time.")
    ] = None,
    time_column: Annotated[
        str | None, typer.Option("--time-column", help="Name, or number from 1, of the column with the time.")
    ] = None,
    start: Start = None,
    stop: Stop = None,
    mission_start: MissionStart = None,
    frame: Frame = None,
    output: figures.FigureFile = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Show what is in a file: channels, units, sample rate, gaps, stuck or clipped codes, what to type next."""
    from ...core.errors import InertialcalError, UsageError
    from ...files.info.survey import survey
    from ..shown.info_text import survey_text

    figures.check_figure(output)
    if output is not None and len(files) != 1:
        raise UsageError(f"-o {output}: a figure of one file, {len(files)} were named", do="Name one file")
    said: dict[str, Any] = {
        "units": units_of(unit), "sample_rate": sample_rate, "time_column": time_column,
        "start": start, "stop": stop, "mission_start": mission_start, "frame": frame,
    }  # fmt: skip
    found, errors = [], []
    for path in files:
        try:
            found.append(survey(path, commands=_commands(), **said))
        except InertialcalError as error:
            errors += list(error.problems)
    line = ""
    if output is not None and not errors:
        from ...files import read

        recording = read(files[0], **said)
        line = figures.write(output, recording, files, {})
    if as_json:
        content = {
            "inputs": [{"path": one.path, "sha256": one.sha256} for one in found],
            "results": [one.to_dict() for one in found],
            "errors": [problem.to_dict() for problem in errors],
        } | ({"written": str(output)} if line else {})
        json_out("info", content, 3 if errors else 0)
        return 3 if errors else 0
    if not quiet and found:
        print("\n\n".join([*(survey_text(one) for one in found), *([line] if line else [])]))
    if errors:
        raise InertialcalError(errors)
    return 0


def units_of(given: list[str]) -> dict[str, str]:
    """Return the units by column or group, as ``--unit`` says them.

    Raises
    ------
    UsageError
        If a text does not have the form.
    """
    from ...core.errors import UsageError

    units = {}
    for text in given:
        name, equals, unit = text.partition("=")
        if not equals or not name or not unit:
            raise UsageError(f"--unit {text!r}: write NAME=UNIT, like gyro=deg/s")
        units[name.strip()] = unit.strip()
    return units


def _commands() -> tuple[str, ...]:
    from ..app import app

    return tuple(command.name or "" for command in app.registered_commands)


def rate_table(
    file: Annotated[
        Path, typer.Argument(help="Table, a row a dwell; or recording of a table turned in steps.", show_default=False)
    ],
    applied: Annotated[str | None, typer.Option(help="Column with the rate of the table.")] = None,
    reading: Annotated[
        list[str] | None, typer.Option(help="Column with the reading, or AXIS=COLUMN; may be repeated.")
    ] = None,
    axis: Annotated[str | None, typer.Option(help="Axis that was turned: x, y or z.")] = None,
    unit: Annotated[
        str | None, typer.Option(help="Unit of rate and reading, where the header does not say it.")
    ] = None,
    scatter: Annotated[str | None, typer.Option(help="Column with the scatter within the dwell.")] = None,
    run: Annotated[str | None, typer.Option(help="Column with the power-up run.")] = None,
    scale_factor: Annotated[str | None, typer.Option(help='Ideal scale factor: "0.5 V/(deg/s)".')] = None,
    input_range: Annotated[str | None, typer.Option("--range", help='Largest rate: "5 deg/s".')] = None,
    zero_reference: Annotated[bool, typer.Option(help="The reading at rest was subtracted.")] = False,
    output: figures.FigureFile = None,
    figure: figures.FigureName = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Scale factor, bias, asymmetry and misalignment from dwells at known rates: a table, or a recording of it."""
    from ...campaign.calls.rate_table import rate_table as reduce_file

    figures.check_figure(output, {"--figure": figure})
    found = reduce_file(
        file, applied=applied, reading=_readings(reading), axis=axis, unit=unit, scatter=scatter, run=run,
        scale_factor=scale_factor, input_range=input_range, zero_reference=zero_reference,
    )  # fmt: skip
    rows = [row.to_dict() for row in found.rows]
    remarks = [remark.to_dict() for remark in found.result.remarks]
    line = (
        "" if output is None else figures.write(output, found, [file], {"figure": figure}, most=len(found.result.lines))
    )
    if as_json:
        inputs = [{"path": str(file), "sha256": found.sha256}]
        content = {"inputs": inputs, "results": rows, "remarks": remarks, "columns": found.columns}
        json_out("rate-table", content | ({} if output is None else {"written": str(output)}))
    elif not quiet:
        _print(found.columns, rows, remarks)
        if line:
            print(line)
    return 0


def _readings(given: list[str] | None) -> str | dict[str, str] | None:
    if not given:
        return None
    if len(given) == 1 and given[0][1:2] != "=":
        return given[0]
    from ...core.errors import UsageError

    pairs = [text.partition("=") for text in given]
    if any(name not in {"x", "y", "z"} or not column for name, _, column in pairs):
        raise UsageError(f"--reading {' --reading '.join(given)}: write AXIS=COLUMN, like x=x_dps")
    return {name: column for name, _, column in pairs}


def _by_axis(value: Any) -> list[tuple[str, Any]]:
    """Return one column, or one an axis, each with its axis."""
    return list(value.items()) if isinstance(value, dict) else [("", value)]


def _print(columns: dict[str, Any], rows: list[dict[str, Any]], remarks: list[dict[str, Any]]) -> None:
    from ..shown.summary import print_reduced

    taken = {f"{what} {key}".strip(): str(name) for what, value in columns.items() for key, name in _by_axis(value)}
    print_reduced(taken, rows, remarks)
