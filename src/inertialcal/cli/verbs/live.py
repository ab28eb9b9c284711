"""live: look at an acquisition that another process records, or has recorded."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..options import Json, Quiet
from ..shown.output import clean, json_out
from .acquire import page_of

if TYPE_CHECKING:
    from ...lab.acquisition.live import View

LOOKS = 200  # pauses of the clock between two looks at its state
SAID = {
    "reading": "what was recorded so far is read",
    "running": "the acquisition runs",
    "stopping": "the acquisition ends",
    "done": "the acquisition has ended",
    "failed": "the acquisition was ended by a fault",
    "stalled": "no sign of life",
    "died": "the acquisition was cut off",
}


def live(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="That acquire -o was given.", show_default=False)],
    port: Annotated[
        int, typer.Option("--port", min=0, max=65535, help="Of the page, on this computer; 0: one that is free.")
    ] = 8650,
    state: Annotated[bool, typer.Option("--state", help="Say what has become of it, and end: no page.")] = False,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Show an acquisition of another process until Ctrl-C: a page for a browser of this computer."""
    from ...core.interruption import interruption
    from ...lab.acquisition.followed import Followed
    from ...lab.clock import Clock

    machine, said = Clock(), ""
    if state:
        with Followed(folder) as followed:
            while (view := followed.view()).state == "reading":
                machine.pause()
        if as_json:
            json_out("live", _content(view))
        elif not quiet:
            rows = "".join(f"\n{clean(one.name)}: {one.rows:,} rows" for one in view.instruments)
            print(f"{SAID[view.state]}{_why(view)}{rows}")
        return 0
    with interruption.held(), Followed(folder) as followed, page_of(followed, port) as page:
        print(f"live: {page}", file=sys.stderr, flush=True)
        while True:
            view = followed.view()
            if view.state != said and not (quiet or as_json):
                print(f"{SAID.get(view.state, view.state)}{_why(view)}", file=sys.stderr, flush=True)
            said = view.state
            if interruption.requested:  # its last state was said
                break
            machine.pause(many=LOOKS)
        interruption.accept()
    if as_json:
        json_out("live", _content(followed.view()))
    return 0


def _why(view: View) -> str:
    return f": {clean(view.why)}" if view.why and view.state != "reading" else ""


def _content(view: View) -> dict[str, Any]:
    return {
        "state": view.state,
        "why": view.why,
        "title": view.title,
        "elapsed": view.elapsed,
        "status": view.status,
        "instruments": [
            {word: getattr(one, word) for word in ("name", "rows", "damaged", "doubled", "late", "lost")}
            for one in view.instruments
        ],
        "remarks": [told.remark.to_dict() for told in view.remarks],
    }
