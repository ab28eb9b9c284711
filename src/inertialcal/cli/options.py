"""Options that commands share."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

from ..core.errors import UsageError
from ..rigs import RIGS, titles

Json = Annotated[bool, typer.Option("--json", help="Print one JSON object, alone on standard output.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but what is asked for.")]
Folder = Annotated[Path, typer.Argument(help="Folder with campaign.toml.", show_default=False)]


def pairs(given: Sequence[str], option: str, example: str) -> dict[str, str]:
    """Return the pairs of an option that may be repeated.

    Raises
    ------
    UsageError
        If one is not of that form, or a name stands twice.
    """
    found: dict[str, str] = {}
    for text in given:
        name, equals, what = (part.strip() for part in text.partition("="))
        if not equals or not name or not what:
            raise UsageError(f"{option} {text!r}: need NAME=SOMETHING", do=f"Write it like {option} {example}")
        if name in found:
            raise UsageError(f"{option}: {name!r} stands twice", do="Give it once")
        found[name] = what
    return found


def rigs_beginning(incomplete: str) -> list[tuple[str, str]]:
    """Return the rigs whose name begins so, each with a line on it; none is loaded."""
    return [(name, title) for name, title in titles().items() if name.startswith(incomplete)]


def faults_beginning(ctx: typer.Context, incomplete: str) -> list[tuple[str, str]]:
    """Return the mistakes of the rig that was typed whose name begins so, each with what is wrong in it."""
    words = (str(ctx.params.get("rig", "")), *ctx.args)  # an option that lacks its value ends the parsing of arguments
    rig = next((word for word in words if word in RIGS), None)
    faults = {} if rig is None else RIGS[rig].every_fault
    return [(name, fault.what) for name, fault in faults.items() if name.startswith(incomplete)]


def with_options(command: Callable[..., int], parameters: dict[str, tuple[Any, Any]]) -> Callable[..., int]:
    """Return a function that takes anything with the signature that the parser makes options of."""
    keyword = inspect.Parameter.KEYWORD_ONLY
    command.__signature__ = inspect.Signature(  # type: ignore[attr-defined]
        [
            inspect.Parameter(name, keyword, default=default, annotation=kind)
            for name, (kind, default) in parameters.items()
        ]
    )
    command.__annotations__ = {name: kind for name, (kind, _) in parameters.items()}
    return command
