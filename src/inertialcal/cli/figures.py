"""Options of the commands that write a figure, and what they have in common."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..core.errors import UsageError
from .shown.output import clean, terminal_width
from .shown.screen import encodes_braille

if TYPE_CHECKING:
    from ..report.figures.drawing.picture import Picture

WIDEST = 110  # columns of a plot in text

FigureFile = Annotated[
    Path | None,
    typer.Option("--output", "-o", help="Write a figure: .png, .svg or .pdf, by the ending.", show_default=False),
]
Show = Annotated[bool, typer.Option("--show", help="Open the figure in a viewer.")]
Plot = Annotated[bool, typer.Option("--plot", help="Draw the figure in text.")]
FigureName = Annotated[str | None, typer.Option("--figure", help="Which figure; the first that has data if not said.")]


def check_figure(
    output: Path | None, asked: dict[str, str | None] | None = None, drawn: bool = False, as_json: bool = False
) -> None:
    """Refuse, before anything is computed, an ending that cannot be written, or a choice of a figure that is not drawn.

    Raises
    ------
    UsageError
        With the endings there are, or the option that is missing.
    """
    if drawn and as_json:
        raise UsageError("--plot with --json: the JSON object stands alone", do="Leave one of them out")
    if output is not None:
        from ..report.figure_file import check_ending

        check_ending(output)
        return
    for option, value in (asked or {}).items():
        if value is not None and not drawn:
            do = "Say it: -o figure.png, or --plot to draw it in text"
            raise UsageError(f"{option} {value}: no file for the figure is named", do=do)


def write(
    output: Path, result: object, inputs: Sequence[Path | str], chosen: dict[str, str | None], most: int = 1
) -> str:
    """Write the figure of a result; return a line that says what was drawn and what else there is.

    Parameters
    ----------
    output : Path
        Where.
    result : object
        What ``inertialcal.plot`` takes.
    inputs : sequence of path
        Files that it may not replace.
    chosen : dict
        ``figure``, ``test``, ``axis`` as asked for.
    most : int
        Pictures drawn, one below the other, where several fit.
    """
    from ..report.figure_file import write_figure
    from ..report.plot import pictures

    found = pictures(result, **chosen)
    write_figure(output, found[:most], inputs)
    if "test" not in chosen:  # of a noun, which has one
        found = [replace(one, test="") for one in found]
    return clean(f"written: {output} ({', '.join(map(_name, found[:most]))}){_others(found[most:])}")


def print_plot(result: object, chosen: dict[str, str | None], most: int = 1) -> None:
    """Print the figure of a result in text, as wide as the terminal.

    Parameters
    ----------
    result, chosen, most
        As `write`.
    """
    from ..report.plot import pictures
    from ..report.text_plot import text_plot

    print(f"\n{text_plot(pictures(result, **chosen)[:most], min(terminal_width(), WIDEST), encodes_braille())}")


def show_figure(output: Path | None, result: object, chosen: dict[str, str | None], most: int = 1) -> None:
    """Open the figure of a result in a viewer: the file that was written, or one in the folder for temporary files."""
    import tempfile

    from .opening import open_file

    path = output
    if path is None:
        path = Path(tempfile.mkdtemp(prefix="inertialcal-")) / "figure.png"
        write(path, result, [], chosen, most)
    open_file(path)


def _name(picture: Picture) -> str:
    test = f"test {picture.test}" if picture.test else ""
    axis = f"axis {picture.axis}" if picture.axis else ""
    return " ".join(part for part in (picture.name, test, axis) if part)


def _others(rest: Sequence[Picture]) -> str:
    if not rest:
        return ""
    names = list(dict.fromkeys(_name(one) for one in rest))
    listed = "; ".join(names[:6]) + ("; ..." if len(names) > 6 else "")
    return f". {len(rest)} more with --test or --axis: {listed}"
