"""The command of a procedure, made of its settings: one factory for all nouns."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from ...core.settings import Setting, grouped_settings, settings_of
from ...procedures.given import READING, Said
from ...procedures.protocol import Command, Procedure
from .. import figures
from ..options import Json, Quiet, with_options

Files = Annotated[list[Path], typer.Argument(help="Recordings, or tables of readings.", show_default=False)]
OUTPUT = {
    "output": (Annotated[Path | None, typer.Option("--output", "-o", show_default=False,
                         help="Write a figure (.png, .svg, .pdf), the models (.json), or all into a folder.")], None),
    "figure": (Annotated[str | None, typer.Option(help="Which figure; the first that has data if not given.")], None),
    "show": (figures.Show, False),
    "plot": (figures.Plot, False),
    "figure_axis": (Annotated[str | None, typer.Option(help="Axis of the figure: x, y or z.")], None),
    "campaign": (Annotated[Path | None, typer.Option(show_default=False,
                           help="Write what was used as a campaign into this folder.")], None),
    "as_json": (Json, False),
    "quiet": (Quiet, False),
}  # fmt: skip
HOLD_OUT = Annotated[
    list[Path] | None, typer.Option("--hold-out", help="File that the model is judged on; repeatable.")
]
FORMAT = Annotated[
    str | None,
    typer.Option("--for", help="Format of the models, printed or written with -o: px4, ardupilot, any of export.",
                 show_default=False),
]  # fmt: skip


def command_of(procedure: Procedure[Any, Any, Any], declared: Command) -> Callable[..., int]:
    """Return the command of a procedure, for the parser: options are its settings."""
    groups = {"plan": procedure.plan_type, "own": procedure.said_type, "said": Said, "shown": procedure.shown_type}
    ordered = {one.name: one for group in grouped_settings(groups).values() for one in group}

    def command(**given: Any) -> int:
        from .run import run_noun

        return run_noun(procedure, declared, ordered, given)

    parameters: dict[str, tuple[Any, Any]] = {"files": (Files, inspect.Parameter.empty)}
    parameters |= {name: option_of(one) for name, one in ordered.items()} | OUTPUT
    if "hold_out" in procedure.uses:
        parameters["hold_out"] = (HOLD_OUT, None)
    if procedure.makes_model:
        parameters["for_format"] = (FORMAT, None)
    return with_options(command, parameters)


def option_of(one: Setting) -> tuple[Any, Any]:
    """Return annotation and default of an option: quantities are text with a unit, nothing given is None."""
    described = f"{one.described}{' May be repeated.' if one.many or one.pairs else ''}"
    name = f"--{one.option}"
    if one.flag:
        return Annotated[
            bool | None, typer.Option(f"{name}/--no-{one.option}", help=described, show_default=False)
        ], None
    kind: Any = Literal[one.choices] if one.choices else one.number or str
    if one.many or one.pairs:  # the parser takes no list of words: they are checked with the settings
        inner: Any = str if one.choices or one.pairs else kind
        kind = list[inner]
    option = typer.Option(name, help=described, show_default=False, autocompletion=_completion(one))
    return Annotated[kind | None, option], None


def said_options(names: Sequence[str] = READING) -> dict[str, tuple[object, object]]:
    """Return the options of a command that has no plan: by default what says how a file is read, as nouns have it."""
    known = {one.name: one for one in settings_of(Said)}
    return {name: option_of(known[name]) for name in names}


def said_of(given: dict[str, Any], names: Sequence[str] = READING) -> Said:
    """Return what those options say, taken out of all that was given."""
    from .run import pairs_of

    known = {one.name: one for one in settings_of(Said)}
    return Said(**pairs_of(known, {name: given.pop(name) for name in names}))


def _completion(one: Setting) -> Callable[[str], Sequence[str]] | None:
    if not (one.many and one.choices):
        return None

    def words(incomplete: str) -> list[str]:
        return [word for word in one.choices if word.startswith(incomplete)]

    return words


__all__ = ["command_of", "option_of", "said_of", "said_options", "with_options"]
