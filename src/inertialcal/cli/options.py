"""Options that commands share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

Json = Annotated[bool, typer.Option("--json", help="Print one JSON object, alone on standard output.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but what is asked for.")]
Folder = Annotated[Path, typer.Argument(help="Folder with campaign.toml.", show_default=False)]
Units = Annotated[
    list[str],
    typer.Option("--unit", help="Unit of a column or group: gyro=deg/s, acc=g, wx=rad/s. May be repeated."),
]
Start = Annotated[
    str | None,
    typer.Option(
        "--from",
        help="Only from this time on: UTC, GMT day of year (2014/295/09:36:36), mission elapsed time, seconds.",
    ),
]
Stop = Annotated[str | None, typer.Option("--to", help="Only before this time, written like --from.")]
MissionStart = Annotated[
    str | None, typer.Option("--mission-start", help="When mission elapsed time (DDD/HH:MM:SS) is zero, in UTC.")
]
Frame = Annotated[
    str | None, typer.Option("--frame", help="Axes of a PAD recording: data (as they are) or sensor (turned to them).")
]
