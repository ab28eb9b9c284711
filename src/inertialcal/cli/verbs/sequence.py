"""sequence: a whole test programme by one command: steps, records, report."""

from __future__ import annotations

import shlex
import sys
import threading
from contextlib import nullcontext, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..options import Json, Quiet
from ..shown.output import clean, found, json_out, table, wrapped
from ..shown.screen import folded, say
from .acquire import LOOK, Progress, page_of
from .archive import archived

if TYPE_CHECKING:
    from ...lab.acquisition.lab_file import Lab
    from ...lab.sequence.operator import Operator, Word
    from ...lab.sequence.sequence import Sequence

KEYS: dict[str, Word] = {"": "done", "d": "done", "p": "pause", "g": "go", "s": "stop"}
HELP = "Enter: done; p: pause; g: go on; s: stop"


def sequence(
    lab: Annotated[Path, typer.Argument(metavar="LAB.toml", help="With [sequence].", show_default=False)],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="New folder for all that is made.", show_default=False)
    ] = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="Go on with the sequence in that folder, which was cut off or has failed.")
    ] = False,
    check: Annotated[
        bool, typer.Option("--check", help="Say what would be done, and for how long; connect to nothing.")
    ] = False,
    yes: Annotated[
        bool, typer.Option("--yes", help="Take each prompt as done: for rehearsals, where nobody is there.")
    ] = False,
    archive: Annotated[
        str | None,
        typer.Option("--archive", metavar="URL", help="Add the results to this archive: lab.db.", show_default=False),
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
    """Run a test programme: set, wait until it is steady, record, step by step; then run its campaign."""
    from ...core.errors import PlanError, UsageError
    from ...lab.acquisition.lab_file import load_lab

    read = load_lab(str(lab))
    if not read.sequence:
        what = "no [sequence]: there are no steps to do"
        raise PlanError(what, lab.name, do="Write [sequence] with its steps", code="missing_key")
    if check:
        return _plan(read, as_json, quiet)
    if output is None:
        do = f"Say: inertialcal sequence {shlex.quote(str(lab))} -o DIR"
        raise UsageError("sequence needs a folder", do=do)
    begun = output.is_dir() and any(output.iterdir())
    if begun and not resume:
        do = "Name a new folder, or add --resume to go on with what is there"
        raise UsageError(f"{output} is not empty", do=do, code="not_empty")
    entry = read.file.sequence
    if archive is not None and (entry is None or not entry.campaign):
        what = "--archive: the sequence has no campaign, whose results could be kept"
        raise UsageError(what, do="Name it in LAB.toml: campaign", code="wrong_value")
    return _run(read, output, yes, port if live else None, archive, as_json, quiet)


def _run(lab: Lab, output: Path, yes: bool, port: int | None, archive: str | None, as_json: bool, quiet: bool) -> int:
    from ...campaign.engine.run import run as run_campaign
    from ...lab.sequence.operator import Operator
    from ...lab.sequence.sequence import Sequence
    from ...lab.sequence.store import build_campaign
    from .campaigns import outcome_content, print_outcome

    operator = Operator(yes)
    made = Sequence(lab, output, operator)
    entry = lab.file.sequence
    if not made.complete:
        _conduct(lab, made, operator, port, quiet or as_json)
    done = {"written": str(output), "steps": len(lab.sequence), "passed": len(made.passed)}
    if entry is None or not entry.campaign:
        if as_json:
            json_out("sequence", done)
        elif not quiet:
            print(wrapped(f"all {len(lab.sequence)} steps are PASS: {made.log.path}"))
        return 0
    folder = build_campaign(lab.folder / entry.campaign, output, lab.sequence, made.records)
    outcome = run_campaign(folder)
    added = None if archive is None else archived(archive, folder)  # no verdict is told before it is kept
    found(outcome.exit_status)
    if as_json:
        kept = {} if added is None else {"archived": added.to_dict()}
        json_out("sequence", {**done, **outcome_content(outcome), **kept}, outcome.exit_status)
    elif not quiet:
        print(wrapped(f"all {len(lab.sequence)} steps are PASS: {made.log.path}"))
        print_outcome(outcome)
        if added is not None:
            print(wrapped(str(added)))
    return outcome.exit_status


def _conduct(lab: Lab, made: Sequence, operator: Operator, port: int | None, quiet: bool) -> None:
    """Go through the steps until all are PASS, one has failed, or it is interrupted."""
    from ...core.interruption import interruption
    from ...lab.acquisition.acquisition import Acquisition
    from ...lab.clock import Clock

    acquisition = Acquisition(lab, made.acquired(), conductor=made)
    machine = Clock()
    with interruption.held(), nullcontext("") if port is None else page_of(acquisition, port, operator) as page:
        acquisition.start()
        if page:
            print(f"live: {page}", file=sys.stderr, flush=True)
        if not operator.answers:
            threading.Thread(target=_listen, args=(operator,), name="lab operator", daemon=True).start()
        interruption.note(made.folder, complete=False)
        shown, asked = Progress(quiet), ""
        while not acquisition.wait(LOOK * acquisition.clock.speed):
            if interruption.requested:
                acquisition.stop()
            if operator.asked != asked:
                asked = operator.asked
                if asked:
                    shown.end()
                    print(f"DO: {clean(asked)}\n    ({HELP})", file=sys.stderr, flush=True)
            shown.show(acquisition, machine.seconds())
        shown.end()


def _listen(operator: Operator) -> None:
    """Take what the operator types, a line each."""
    with suppress(OSError, ValueError):  # there is no terminal
        for line in sys.stdin:
            word = KEYS.get(line.strip().lower()[:1])
            if word is None:
                print(HELP, file=sys.stderr)
            else:
                operator.say(word)


def _plan(lab: Lab, as_json: bool, quiet: bool) -> int:
    """Print the steps, the time that they take, and the limits."""
    least, most = (sum(getattr(one, name) for one in lab.sequence) for name in ("least", "most"))
    if as_json:
        steps = [
            {"step": one.number, "name": one.name, "recording": one.recording if one.record else None,
             "prompt": one.prompt, "set": [[f"{name}.{quantity}", value] for name, quantity, value in one.values],
             "least": one.least, "most": one.most}
            for one in lab.sequence
        ]  # fmt: skip
        limits = {f"{name}.{key}": list(ends) for name, own in lab.limits.items() for key, ends in own.items()}
        json_out("sequence", {"steps": steps, "least": least, "most": most, "limits": limits})
        return 0
    if quiet:
        return 0
    rows = []
    for one in lab.sequence:
        told = ", ".join(
            f"{name}.{quantity} = {value:g} {lab.dialects[name].settings[quantity].unit}".rstrip()
            for name, quantity, value in one.values
        )
        span = f"{one.least:g}" if one.least == one.most else f"{one.least:g} to {one.most:g}"
        rows.append([str(one.number), clean(one.name), clean(told), clean(one.prompt), span])
    say(folded(table(rows, ["step", "name", "sets", "asks for", "takes [s]"])))
    for name, own in lab.limits.items():
        for key, (low, high) in own.items():
            unit = lab.dialects[name].settings[key].unit
            print(wrapped(f"limits of {name}.{key}: {low:g} to {high:g} {unit}".rstrip()))
    asks = sum(bool(one.prompt) for one in lab.sequence)
    said = f"{len(lab.sequence)} steps: {_long(least)} at least, {_long(most)} at most"
    print(wrapped(said + (f", and {asks} prompts" if asks else "")))
    return 0


def _long(seconds: float) -> str:
    hours, rest = divmod(round(seconds), 3600)
    return f"{hours} h {rest // 60} min" if hours else f"{rest // 60} min {rest % 60} s"
