"""acquire: record instruments, watch them, move what moves."""

from __future__ import annotations

import shlex
import sys
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..options import Json, Quiet
from ..shown.output import clean, followed, json_out, table, wrapped
from ..shown.screen import folded, say

if TYPE_CHECKING:
    from ...lab.acquisition.acquisition import Acquisition
    from ...lab.acquisition.live import Shown, View
    from ...lab.acquisition.seal import Summary
    from ...lab.sequence.operator import Operator

LOOK = 0.2  # [s] between two looks at it
BETWEEN = 60.0  # [s] between two lines of progress where there is no terminal


def acquire(
    lab: Annotated[Path | None, typer.Argument(metavar="LAB.toml", help="What to record.", show_default=False)] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="New folder for what is recorded.", show_default=False)
    ] = None,
    unsealed: Annotated[
        Path | None,
        typer.Option(
            "--seal", help="Folder of a recording that was cut off: seal it, and record nothing.", show_default=False
        ),
    ] = None,
    live: Annotated[
        bool, typer.Option("--live", help="Show it while it runs: a page for a browser of this computer.")
    ] = False,
    port: Annotated[
        int, typer.Option("--port", min=0, max=65535, help="Of the live page, on this computer; 0: one that is free.")
    ] = 8650,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Record instruments until Ctrl-C, the end of the steps or a stated duration; then seal it as Parquet."""
    from ...core.errors import UsageError
    from ...lab.acquisition.seal import seal

    if (unsealed is None) == (lab is None):
        raise UsageError("acquire needs LAB.toml, or --seal and a folder", do="Try: inertialcal acquire --help")
    if unsealed is not None:
        if live:
            raise UsageError("--seal records nothing that --live could show", do="Leave out --live")
        return _summary(seal(unsealed), unsealed, as_json, quiet)
    if output is None:
        do = f"Say: inertialcal acquire {shlex.quote(str(lab))} -o DIR"
        raise UsageError("acquire needs a new folder", do=do)
    _record(lab, output, port if live else None, quiet or as_json)
    return _summary(seal(output), output, as_json, quiet)


def _record(lab: Path | None, output: Path, port: int | None, quiet: bool) -> None:
    """Record until it ends; an interruption is a way to end, and what moves is safe then."""
    from ...core.interruption import interruption
    from ...lab.acquisition.acquisition import Acquisition
    from ...lab.acquisition.lab_file import load_lab
    from ...lab.clock import Clock

    acquisition = Acquisition(load_lab(str(lab)), output)
    machine = Clock()
    with interruption.held(), nullcontext("") if port is None else page_of(acquisition, port) as page:
        acquisition.start()
        if page:
            print(f"live: {page}", file=sys.stderr, flush=True)
        interruption.note(output, complete=False)
        shown = Progress(quiet)
        while not acquisition.wait(LOOK * acquisition.clock.speed):
            if interruption.requested:
                acquisition.stop()
            shown.show(acquisition, machine.seconds())
        shown.end()
        interruption.accept()


def page_of(shown: Shown, port: int, operator: Operator | None = None) -> AbstractContextManager[str]:
    """Return what gives the live page of an acquisition, with what an operator is asked, and its address."""
    from ...core.errors import UsageError

    try:
        from ...lab.live.server import live_page, served
    except ImportError as error:
        what = f"the live page needs the package {error.name}, which is not installed"
        raise UsageError(what, do="Type: pip install 'inertialcal[web]'", code="missing_extra") from None
    if operator is None:
        return live_page(shown, port)
    from ...lab.sequence.page import OperatorContent

    return served(OperatorContent(shown, operator), port)


class Progress:
    """Progress on standard error: a line that is renewed on a terminal, lines elsewhere; remarks as they come."""

    def __init__(self, quiet: bool) -> None:
        self.quiet, self.terminal = quiet, sys.stderr.isatty()
        self._told: set[tuple[str, str, str]] = set()
        self._last = -BETWEEN

    def show(self, acquisition: Acquisition, now: float) -> None:
        """Show how far it is."""
        from ...lab.acquisition.live import RENEWED

        if self.quiet:
            return
        view = acquisition.view()
        for told in view.remarks:
            code, where = told.remark.code, told.remark.where
            key = (code, where, told.remark.subject if code in RENEWED else told.remark.what)
            if key not in self._told:
                self._told.add(key)
                print(f"{self._renewed()}{clean(str(told.remark))}", file=sys.stderr)
        if self.terminal:
            print(f"{self._renewed()}{_line(view)}", end="", file=sys.stderr, flush=True)
        elif now - self._last >= BETWEEN:
            self._last = now
            print(_line(view), file=sys.stderr)

    def _renewed(self) -> str:
        return "\r\x1b[K" if self.terminal else ""

    def end(self) -> None:
        """End the line."""
        if self.terminal and not self.quiet:
            print(self._renewed(), end="", file=sys.stderr, flush=True)


def _line(view: View) -> str:
    parts = [f"{view.elapsed:.0f} s"]
    if view.step is not None and view.step.number:
        parts.append(
            f"step {view.step.number} of {view.step.count}, {clean(view.step.name)}, {view.step.left:.0f} s left"
        )
    for one in view.instruments:
        if one.channels:
            state = "" if one.connected else ", not connected"
            state += f", saves {one.intervals}" if one.intervals else ""
            parts.append(f"{clean(one.name)} {one.acknowledged:,} of {one.rows:,} rows on disk{state}")
    return "; ".join(parts)


def _summary(summary: Summary, folder: Path, as_json: bool, quiet: bool) -> int:
    from ...core.remarks import condensed
    from ..shown.summary import remarks_text

    content: dict[str, Any] = summary.to_dict()
    if as_json:
        json_out("acquire", {"written": str(folder), **content})
        return 0
    if quiet:
        return 0
    rows = [
        [clean(one["name"]), f"{one['rows']:,}", _drift(one["clocks"]), _odd(one["save_intervals"]), one["file"]]
        for one in content["instruments"]
    ]
    heads = ["instrument", "rows", "drift of its clock", "odd save intervals", "file"]
    say(table(rows, heads))
    if summary.remarks:
        say(folded("\n".join(remarks_text([one.to_dict() for one in condensed(summary.remarks)]))))
    if not summary.whole:
        print(wrapped("the recording was cut off: all that is whole was sealed"))
    first = f" {shlex.quote(str(folder / rows[0][-1]))}" if rows else ""
    print(followed(f"sealed: {folder}", f"inertialcal info{first}") if rows else f"sealed: {clean(str(folder))}")
    return 0


def _drift(clocks: dict[str, Any]) -> str:
    from ...core.show.rounding import with_uncertainty

    if clocks["status"] != "estimated":
        return "not estimated"
    return with_uncertainty(1e6 * clocks["drift"]["value"], 1e6 * clocks["drift"]["u"]) + (
        " ppm" if clocks["rate"]["corrected"] else " ppm, not used"
    )


def _odd(intervals: dict[str, Any] | None) -> str:
    if intervals is None:
        return "not looked at"
    return ", ".join(f"{one['length']:g} s x{one['count']}" for one in intervals["odd"]) or "none"
