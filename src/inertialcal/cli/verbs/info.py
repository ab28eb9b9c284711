"""info: what is in a file."""

from __future__ import annotations

import inspect
from pathlib import Path
from typing import Annotated, Any

import typer

from .. import figures
from ..nouns.factory import said_of, said_options
from ..options import Json, Quiet, with_options
from ..shown.output import json_out
from ..shown.screen import folded, say

Files = Annotated[list[Path], typer.Argument(help="Recordings or tables.", show_default=False)]


def _info(**given: Any) -> int:
    """Show what is in a file: channels, units, sample rate, gaps, stuck or clipped codes, what to type next."""
    from ...campaign.calls.given import read_as_said
    from ...campaign.start.info import surveys
    from ...core.errors import InertialcalError, UsageError
    from ..commands import words
    from ..shown.info_text import survey_text

    files: list[Path] = given["files"]
    output, as_json, said = given["output"], given["as_json"], said_of(given)
    figures.check_figure(output)
    if output is not None and len(files) != 1:
        raise UsageError(f"-o {output}: a figure of one file, {len(files)} were named", do="Name one file")
    found, errors = [], []
    for path in files:
        own, problems = surveys(path, said, words())
        found += own
        errors += problems
    line = ""
    if output is not None and not errors:
        line = figures.write(output, read_as_said(files[0], said), files, {})
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
    if not given["quiet"] and found:
        say("\n\n".join([*(folded(survey_text(one)) for one in found), *([line] if line else [])]))
    if errors:
        raise InertialcalError(errors)
    return 0


info = with_options(
    _info,
    {
        "files": (Files, inspect.Parameter.empty), **said_options(), "output": (figures.FigureFile, None),
        "as_json": (Json, False), "quiet": (Quiet, False),
    },
)  # fmt: skip
