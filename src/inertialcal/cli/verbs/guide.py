"""guide: tell a person with an IMU in the hand what to do next, until it is calibrated well enough."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..nouns.factory import said_of, said_options, with_options
from ..options import Json, Quiet, pairs
from ..shown.output import clean, json_out, table

if TYPE_CHECKING:
    from ...lab.guide.session import Asked, Ended, Figure, Session, Shown

SAID = ("columns", "units", "sensor", "chain", "lsb", "counts", "scale_factor", "reference", "gain", "input_range",
        "latitude", "gravity", "height", "standards")  # fmt: skip
WORST = 3  # figures that a line on a terminal names


def _guide(given: dict[str, Any]) -> int:
    from ...core.errors import UsageError
    from ...core.interruption import interruption
    from ...lab.guide.session import Session
    from ...lab.guide.source import PHONE, lab_for

    source, output, phone = given.pop("source"), given.pop("output"), given.pop("phone")
    as_json, quiet, no_page, port = (given.pop(name) for name in ("as_json", "quiet", "no_page", "port"))
    opened = given.pop("open_page")
    if (source is None) != phone:
        raise UsageError("guide needs one source, or a phone", do="Try: inertialcal guide --help")
    if output is None:
        do = f"Say: inertialcal guide {'--phone' if phone else shlex.quote(str(source))} -o DIR"
        raise UsageError("guide needs a new folder", do=do)
    if phone and no_page:
        raise UsageError(
            "a phone sends over the page: --no-page leaves it none", do="Leave that option out", code="wrong_value"
        )
    lab = lab_for(PHONE if phone else str(source), given.pop("dialect") or "", given.pop("baud"))
    session = Session(lab, output, _asked(given))
    tell = _Told(quiet or as_json)
    with interruption.held(), _page(session, None if no_page else port) as page:
        session.start()
        if page:
            print(f"guide: {page}", file=sys.stderr, flush=True)
            if opened:
                _open(page)
        interruption.note(output, complete=False)
        try:
            while session.step() and not interruption.requested:
                tell.show(session.shown)
            tell.show(session.shown)
            ended = session.end()
            tell.show(session.shown)
        finally:
            session.acquisition.stop()
        interruption.accept()
    return _summary(session, ended, as_json, quiet)


def _asked(given: dict[str, Any]) -> Asked:
    """Return what the calibration is to give; the options are taken out of all that was given."""
    from dataclasses import asdict

    from ...core.errors import DataError, UsageError
    from ...core.key import AXES
    from ...core.units import parse_quantity
    from ...files.models.formats import FORMATS
    from ...lab.guide.session import Asked

    formats = given.pop("for_format") or []
    for one in formats:
        if one not in FORMATS:
            raise UsageError(f"--for {one!r}: no such format", do=f"Formats: {', '.join(FORMATS)}",
                             code="unsupported_format")  # fmt: skip
    target = pairs(given.pop("target") or [], "--target", 'bias="1 mg"')
    labels = pairs(given.pop("label") or [], "--label", "z+=label")
    sides = pairs(given.pop("side") or [], "--side", 'x="its long side"')
    for names, known, option in ((labels, [a + s for a in AXES for s in "+-"], "--label"), (sides, AXES, "--side")):
        wrong = next((name for name in names if name not in known), None)
        if wrong is not None:
            raise UsageError(f"{option} {wrong!r}", do=f"There are: {', '.join(known)}", code="unknown_name")
    try:
        rest = parse_quantity(given.pop("rest")).to("s")
    except DataError as error:
        raise UsageError(
            "--rest", why=error.problems[0].what, do='Write it like --rest "3 s"', code="no_unit"
        ) from None
    if not 0.5 <= rest <= 60.0:
        raise UsageError(f"--rest {rest:g} s", do="Say 0.5 to 60 s", code="wrong_value")
    said = said_of(given, SAID)
    settings = {name: value for name, value in asdict(said).items() if name in SAID and value}
    return Asked(target, settings, rest, labels, sides, formats)


def _page(session: Session, port: int | None) -> AbstractContextManager[str]:
    """Return what gives the page, and its address; an empty one without a port."""
    from ...core.errors import UsageError

    if port is None:
        return nullcontext("")
    try:
        from ...lab.guide.page import guide_page
    except ImportError as error:
        what = f"the page needs the package {error.name}, which is not installed"
        raise UsageError(what, do="Type: pip install 'inertialcal[web]'", code="missing_extra") from None
    return guide_page(session, port)


def _open(page: str) -> None:
    import webbrowser

    webbrowser.open(page)


class _Told:
    """What the page says, line by line on standard error."""

    def __init__(self, quiet: bool) -> None:
        self.quiet, self._said, self._positions = quiet, "", 0
        self._notices: list[str] = []

    def show(self, shown: Shown) -> None:
        """Print what is new."""
        if self.quiet:
            return
        for text in _new(self._notices, list(shown.notices)):
            print(f"  ! {clean(text)}", file=sys.stderr)
        self._notices = list(shown.notices)
        if shown.positions != self._positions:
            self._positions = shown.positions
            print(f"  {_known(shown)}", file=sys.stderr)
        if shown.said != self._said:
            self._said = shown.said
            print(f"{shown.word}: {clean(shown.said)}", file=sys.stderr, flush=True)


def _new(before: list[str], now: list[str]) -> list[str]:
    """Return what was added to a list whose first ones fall away."""
    for kept in range(min(len(before), len(now)), -1, -1):
        if before[len(before) - kept :] == now[:kept]:
            return now[kept:]
    return now


def _known(shown: Shown) -> str:
    """Return what is known in a line: how many positions, and the figures that are farthest from what is wanted."""
    count = f"{shown.positions} position{'s'[: shown.positions != 1]}"
    if shown.to_go:
        count += f", about {shown.to_go} to go"
    worst = sorted((one for one in shown.figures if one.asked), key=lambda one: -(one.ratio or float("inf")))
    parts = [f"{one.name} u = {one.u} {one.unit}" for one in worst[:WORST] if one.ratio is not None]
    return f"{count}: {', '.join(parts)}" if parts else f"{count}: no figure yet"


def _summary(session: Session, ended: Ended, as_json: bool, quiet: bool) -> int:
    status = 0 if ended.reached else 4
    if as_json:
        found = ended.found
        json_out("guide", {
            "target": session.target, "reached": ended.reached, "words": session.shown.text,
            "positions": 0 if found is None else len(found.result.readings),
            "results": [] if found is None else [row.to_dict() for row in found.rows],
            "remarks": [] if found is None else [one.to_dict() for one in found.remarks],
            "acquisition": ended.summary.to_dict(), "written": dict(ended.written),
        }, status)  # fmt: skip
        return status
    if quiet:
        return status
    from ..shown.screen import folded, say
    from ..shown.summary import remarks_text

    if ended.found is not None:
        rows = [[one.name, one.value, one.unit, _reached(one)] for one in ended.figures]
        say(table(rows, ["parameter", "value ± u", "unit", "asked for"]))
        say(folded("\n".join(remarks_text([one.to_dict() for one in ended.found.remarks]))))
    print(f"\n{clean(session.shown.text)}")
    for what, path in ended.written.items():
        print(clean(f"{what}: {path}"))
    return status


def _reached(one: Figure) -> str:
    if not one.asked:
        return ""
    return "reached" if one.reached else "not known" if one.ratio is None else f"{one.ratio:.2g} times as wide"


def _option(*names: str, **more: Any) -> Any:
    return typer.Option(*names, show_default=False, **more)


PARAMETERS: dict[str, tuple[Any, Any]] = {
    "source": (Annotated[str | None, typer.Argument(
        metavar="SOURCE", show_default=False,
        help="LAB.toml with one IMU; with --dialect a serial port or a file that grows; a recording, or a rig, that is "
             "played.")], None),
    "output": (Annotated[Path | None, _option("--output", "-o", help="New folder for all that comes out.")], None),
    "phone": (Annotated[bool, typer.Option("--phone", help="The sensors of a phone, over the page in its browser.")],
              False),
    "dialect": (Annotated[str | None, _option(help="What a port or file that grows says: a file as of LAB.toml.")],
                None),
    "baud": (Annotated[int | None, _option(help="Of a serial port; 115200 if not given.")], None),
    "target": (Annotated[list[str] | None, _option(
        help='Standard uncertainty wanted: bias="1 mg", misalignment_yx="0.1 deg", gyro.scale_factor_error="0.5 %". '
             "Repeatable. If none is given: 1 mg, 0.1 %, 0.1 deg; of a phone 10 mg, 0.5 %, 0.5 deg.")], None),
    "rest": (Annotated[str, typer.Option(help="Shortest rest that counts as a position.")], "3 s"),
    "label": (Annotated[list[str] | None, _option(
        help="What stands on a face, by what points up: z+=label, x+=plug. Repeatable.")], None),
    "side": (Annotated[list[str] | None, _option(
        help='How you call an axis: x="its long side". Repeatable.')], None),
    "for_format": (Annotated[list[str] | None, _option(
        "--for", help="Format of the models for others: px4, ardupilot, any of export. Repeatable.")], None),
    "no_page": (Annotated[bool, typer.Option("--no-page", help="Words on the terminal alone.")], False),
    "port": (Annotated[int, typer.Option(min=0, max=65535, help="Of the page, on this computer; 0: one that is free.")],
             8650),
    "open_page": (Annotated[bool, typer.Option("--open", help="Open the page in the browser.")], False),
    "as_json": (Json, False),
    "quiet": (Quiet, False),
}  # fmt: skip


def _command() -> Callable[..., int]:
    def guide(**given: Any) -> int:
        """Guide a person with an IMU in the hand, position by position, until it is calibrated well enough."""
        return _guide(given)

    return with_options(guide, {**PARAMETERS, **said_options(SAID)})


guide = _command()
