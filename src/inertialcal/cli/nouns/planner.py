"""The command of a planner, ``plan TEST``, made of its settings."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer

from ...core.settings import settings_of
from ...procedures.protocol import Command, Procedure
from .. import figures
from ..options import Json, Quiet
from ..shown.output import json_out
from .factory import option_of, with_options
from .run import pairs_of

OUTPUT = {
    "output": (Annotated[Path | None, typer.Option("--output", "-o", show_default=False,
                         help="Write a figure: .png, .svg or .pdf, by the ending.")], None),
    "figure": (Annotated[str | None, typer.Option(help="Which figure; the first that has data if not given.")], None),
    "as_json": (Json, False),
    "quiet": (Quiet, False),
}  # fmt: skip


def planner_of(procedure: Procedure[Any, Any, Any], declared: Command) -> Callable[..., int]:
    """Return the command of a planner, for the parser."""
    kind = procedure.planner_type
    settings = {} if kind is None else {one.name: one for one in settings_of(kind)}

    def command(**given: Any) -> int:
        from ...core.show.tables import text
        from ..shown.summary import remarks_text

        output, figure, as_json, quiet = (given.pop(name) for name in OUTPUT)
        figures.check_figure(output, {"--figure": figure})
        found = procedure.planned(pairs_of(settings, given))
        written = "" if output is None else figures.write(output, found, [], {"figure": figure})
        remarks = [one.to_dict() for one in found.remarks]
        if as_json:
            content = {"remarks": remarks, **found.results}
            json_out(f"plan {declared.word}", content | ({"written": [str(output)]} if written else {}))
        elif not quiet:
            print(text(found.parts()))
            for line in (*remarks_text(remarks), *([written] if written else [])):
                print(line)
        return 0

    return with_options(command, {name: option_of(one) for name, one in settings.items()} | OUTPUT)
