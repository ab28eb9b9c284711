"""The command of a planner, ``plan TEST``, made of its settings."""

from __future__ import annotations

import shlex
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer

from ...core.errors import UsageError
from ...core.settings import settings_of
from ...procedures.protocol import Command, Planned, Procedure
from .. import figures
from ..options import Json, Quiet
from ..shown.output import clean, json_out
from .factory import option_of, with_options
from .run import pairs_of

OUTPUT = {
    "output": (Annotated[Path | None, typer.Option("--output", "-o", show_default=False,
                         help="Write a figure: .png, .svg or .pdf, by the ending.")], None),
    "lab": (Annotated[Path | None, typer.Option("--lab", show_default=False,
                      help="Write a rehearsal into this new folder: LAB.toml with a simulated unit, for `sequence`."
                      )], None),
    "seed": (Annotated[int | None, typer.Option(help="With --lab: of the unit; 1 if not given.", min=0)], None),
    "figure": (Annotated[str | None, typer.Option(help="Which figure; the first that has data if not given.")], None),
    "as_json": (Json, False),
    "quiet": (Quiet, False),
}  # fmt: skip


def planner_of(procedure: Procedure[Any, Any, Any], declared: Command) -> Callable[..., int]:
    """Return the command of a planner, for the parser."""
    kind = procedure.planner_type
    settings = {} if kind is None else {one.name: one for one in settings_of(kind)}

    rehearses = type(procedure).rehearsed is not Procedure.rehearsed
    more = {name: one for name, one in OUTPUT.items() if rehearses or name not in ("lab", "seed")}

    def command(**given: Any) -> int:
        from ...core.show.tables import text
        from ..shown.summary import remarks_text

        output, lab, seed, figure, as_json, quiet = (given.pop(name, None) for name in OUTPUT)
        figures.check_figure(output, {"--figure": figure})
        if seed is not None and lab is None:
            raise UsageError(
                "--seed: no simulated unit is wanted", do="Leave it out, or name a folder for one", code="contradiction"
            )
        said = pairs_of(settings, given)
        found = procedure.planned(said) if lab is None else _rehearsed(procedure, declared, said, lab, seed)
        written = "" if output is None else figures.write(output, found, [], {"figure": figure})
        remarks = [one.to_dict() for one in found.remarks]
        if as_json:
            content = {"remarks": remarks, **found.results} | ({} if lab is None else {"lab": str(lab / "LAB.toml")})
            json_out(f"plan {declared.word}", content | ({"written": [str(output)]} if written else {}))
        elif not quiet:
            print(text(found.parts()))
            for line in (*remarks_text(remarks), *([written] if written else [])):
                print(line)
            if lab is not None:
                made = shlex.quote(str(lab / "made"))
                print(clean(f"Next: inertialcal sequence {shlex.quote(str(lab / 'LAB.toml'))} -o {made} --yes"))
        return 0

    return with_options(command, {name: option_of(one) for name, one in settings.items()} | more)


def _rehearsed(procedure: Procedure[Any, Any, Any], declared: Command, said: dict[str, Any], lab: Path,
               seed: int | None) -> Planned:  # fmt: skip
    """Return a plan after its rehearsal was written."""
    from ...lab.sequence.rehearsal import write_planned

    schedule = said.pop("schedule", None)
    found = write_planned(declared.word, procedure, said, lab, 1 if seed is None else seed)
    if schedule is not None:
        shutil.copyfile(lab / "schedule.csv", schedule)
    return found
