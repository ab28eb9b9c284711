"""rate-table: scale factor, bias, asymmetry and misalignment from dwells at known rates."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from .. import figures
from ..options import Json, Quiet
from ..shown.output import json_out


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
    """Run the command; its help stands in the declaration of the procedure."""
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
