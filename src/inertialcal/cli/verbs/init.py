"""init: a first campaign.toml for the recordings of a folder; on a terminal it asks for what the files do not say."""

from __future__ import annotations

import inspect
import shlex
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ...procedures.given import READING
from ..nouns.factory import said_of, said_options
from ..options import Json, Quiet, with_options
from ..shown.output import clean, json_out, wrapped

if TYPE_CHECKING:
    from ...campaign.start.starter import Told
    from ...procedures.suggestions import Question

# What the files of a folder share: how they are read, their chain and site.
INIT = (*READING, "chain", "lsb", "counts", "reference", "scale_factor", "gain", "latitude", "gravity", "height")


def _init(**given: Any) -> int:
    """Write a campaign.toml for the recordings found in a folder; on a terminal, ask for what the files do not say."""
    from ...campaign.start.starter import Told, start

    folder, sensor, as_json, quiet, yes = (given.pop(name) for name in ("folder", "sensor", "as_json", "quiet", "yes"))
    item = {name: text for name in ("maker", "part", "serial") if (text := given.pop(name)) is not None}
    axis = given.pop("axis")
    told = Told(said_of(given, INIT), axis, item)
    if yes or (not as_json and not quiet and sys.stdin.isatty() and sys.stdout.isatty()):
        told = _asked(folder, told, yes, silent=as_json or quiet)
    path, marked, remarks = start(folder, sensor, told)
    if as_json:
        content = {"results": [], "written": str(path), "to_fill": marked, "remarks": [r.to_dict() for r in remarks]}
        json_out("init", content)
    elif not quiet:
        for remark in remarks:
            print(wrapped(str(remark), "    "))
        print(clean(f"written: {path}"))
        next_step = f"inertialcal {'check' if marked else 'run'} {shlex.quote(str(folder))}"
        lines = (
            f"the line marked FILL IN (line {marked[0]})"
            if len(marked) == 1
            else f"the {len(marked)} lines marked FILL IN"
        )
        print(clean(f"fill in {lines}, then: {next_step}" if marked else f"complete. Next: {next_step}"))
    return 0


def _asked(folder: Path, told: Told, yes: bool, silent: bool) -> Told:
    """Ask what the files leave open, one question after the other; Enter takes the suggestion, and so does ``yes``."""
    from ...campaign.start.starter import first_question

    shown = ""
    while (question := first_question(folder, told)) is not None:
        answer = question.suggestion
        if yes and not silent and question.name == "topics":
            print(wrapped(clean(f"{question.seen}. Taken: {answer}"), "    "))
        if not yes:
            if question.seen not in ("", shown):
                print(wrapped(clean(question.seen), "    "))
            shown, answer = question.seen, _answer(question)
        told = told.answered(question, answer)
    return told


def _answer(question: Question) -> str:
    """Return what was typed, or the suggestion; what cannot be is asked for again."""
    prompt = f"  {question.ask}{f' [{question.suggestion}]' if question.suggestion else ''} "
    while True:
        try:
            text = input(prompt).strip() or question.suggestion
        except EOFError:
            raise KeyboardInterrupt from None
        if not text or not (wrong := question.wrong(text)):
            return text
        print(wrapped(clean(f"{text}: {wrong}"), "    "))


def _with_options() -> Callable[..., int]:
    """Return the command with its options: its own, and the settings that nouns have too."""
    option = typer.Option
    parameters: dict[str, tuple[Any, Any]] = {
        "folder": (Annotated[Path, typer.Argument(help="Folder with recordings.", show_default=False)],
                   inspect.Parameter.empty),
        "sensor": (Annotated[str, option("--sensor", metavar="NAME",
                   help="Published sensor: its data sheet becomes requirements.")], ""),
        "yes": (Annotated[bool, option("--yes", "-y", help="Ask nothing: take each suggestion.")], False),
        "axis": (Annotated[str | None, option(help="Axis that was turned: x, y or z.", show_default=False)], None),
        **{name: (Annotated[str | None, option(help=f"{text} of the sensor.", show_default=False)], None)
           for name, text in (("maker", "Maker"), ("part", "Part number"), ("serial", "Serial number"))},
    }  # fmt: skip
    parameters |= said_options(INIT)
    return with_options(_init, parameters | {"as_json": (Json, False), "quiet": (Quiet, False)})


init = _with_options()
init.__doc__ = _init.__doc__
