"""info: what is in a file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from .. import figures
from ..options import Dates, Decimal, Frame, Json, MissionStart, Quiet, Skip, Start, Stop, Topics, Units, pairs
from ..shown.output import json_out
from ..shown.screen import folded, say

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
    decimal: Decimal = None,
    skip: Skip = None,
    dates: Dates = None,
    topic: Topics = [],  # noqa: B006 - typer copies it
    output: figures.FigureFile = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Show what is in a file: channels, units, sample rate, gaps, stuck or clipped codes, what to type next."""
    from ...campaign.start.info import surveys
    from ...core.errors import InertialcalError, UsageError
    from ..commands import words
    from ..shown.info_text import survey_text

    figures.check_figure(output)
    if output is not None and len(files) != 1:
        raise UsageError(f"-o {output}: a figure of one file, {len(files)} were named", do="Name one file")
    said: dict[str, Any] = {
        "units": pairs(unit, "--unit", "gyro=deg/s"), "sample_rate": sample_rate, "time_column": time_column,
        "start": start, "stop": stop, "mission_start": mission_start, "frame": frame,
        "decimal": decimal, "skip": skip, "dates": dates, "topics": topic,
    }  # fmt: skip
    found, errors = [], []
    for path in files:
        own, problems = surveys(path, commands=words(), **said)
        found += own
        errors += problems
    line = ""
    if output is not None and not errors:
        from ...files import read

        recording = read(files[0], **said)
        line = figures.write(output, recording, files, {})
    if as_json:
        content = {
            "inputs": [
                {"path": path, "sha256": digest}
                for path, digest in dict.fromkeys((one.path, one.sha256) for one in found)
            ],
            "results": [one.to_dict() for one in found],
            "errors": [problem.to_dict() for problem in errors],
        } | ({"written": str(output)} if line else {})
        json_out("info", content, 3 if errors else 0)
        return 3 if errors else 0
    if not quiet and found:
        say("\n\n".join([*(folded(survey_text(one)) for one in found), *([line] if line else [])]))
    if errors:
        raise InertialcalError(errors)
    return 0
