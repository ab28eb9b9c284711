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
