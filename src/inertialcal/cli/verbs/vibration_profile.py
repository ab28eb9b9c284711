"""vibration profile: slopes, overall level and bands of a profile of random vibration, and what contradicts itself."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from .. import figures
from ..options import Json, Quiet
from ..shown.output import json_out


def vibration_profile(
    profile: Annotated[Path, typer.Argument(help="Nodes of the profile: CSV or TOML.", show_default=False)],
    band: Annotated[
        list[str], typer.Option("--band", help="Level of a further band, in hertz: 20..100. May be repeated.")
    ] = [],  # noqa: B006 - typer copies it
    output: figures.FigureFile = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Levels, slopes and overall level of a profile of random vibration, and where they contradict each other."""
    from ...core.show.tables import text
    from ...procedures.vibration.profile_table import vibration_profile as table_of
    from ..shown.summary import remarks_text

    figures.check_figure(output)
    found = table_of(profile, bands=band)
    written = "" if output is None else figures.write(output, found, list(found.inputs), {"figure": None})
    remarks = [one.to_dict() for one in found.remarks]
    if as_json:
        inputs = [{"path": path, "sha256": digest} for path, digest in found.inputs.items()]
        content = {"inputs": inputs, "remarks": remarks, **found.results}
        json_out("vibration profile", content | ({"written": [str(output)]} if written else {}))
    elif not quiet:
        print(text(found.parts()))
        for line in (*remarks_text(remarks), *([written] if written else [])):
            print(line)
    return 0
