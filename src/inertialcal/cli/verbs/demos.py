"""demo: an example built, run and, where its truth is known, scored; offline."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ...core.results import case_of
from ...rigs import DEMONSTRATED, RIGS
from ..options import Json, Quiet, rigs_beginning
from ..shown.output import json_out, wrapped
from ..shown.progress import progress
from .campaigns import outcome_content, print_outcome, where_text

if TYPE_CHECKING:
    from ...campaign.twins.score import Score


def demo(
    rig: Annotated[
        str,
        typer.Argument(
            help=f"A rig, simulated: {', '.join(dict.fromkeys([DEMONSTRATED, *RIGS]))}; "
            "or published: npsat2011, sams1996, reinel1969.",
            autocompletion=rigs_beginning,
            show_default=DEMONSTRATED,
        ),
    ] = "",
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Folder for it; inertialcal-demo-NAME if not given.")
    ] = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Build an example, run it, and set what was found beside the truth that was simulated."""
    from ...campaign.file.example import demonstration

    content = _one(*demonstration(rig, output), as_json, quiet)
    if as_json:
        json_out("demo", content)
    return 0


def _one(name: str, folder: Path, as_json: bool, quiet: bool) -> dict[str, Any]:
    """Build, run and score one example; return what ``--json`` says of it."""
    from ...campaign.engine.run import run as run_campaign
    from ...campaign.file.example import build, has_truth, title
    from ...campaign.models.flight_replay import replay_flight_c
    from ...campaign.twins.score import score
    from ..shown.model_text import flight_text

    built = build(name, folder)
    if not as_json and not quiet:
        print(wrapped(title(name)), file=sys.stderr)
    with progress(quiet or as_json) as tell:
        outcome = run_campaign(built, tell)
    found = score(built) if has_truth(built) else None
    flown = replay_flight_c(built)
    if not as_json and not quiet:
        print_outcome(outcome) if found is None else _print_scored(outcome, found)
        print("" if flown is None else f"\n{flight_text(flown)}", end="\n" if flown else "")
    scored = {} if found is None else _counted(found)
    flight = {} if flown is None else {"flight_c": flown.to_dict()}
    return {"example": name} | outcome_content(outcome) | scored | flight


def _counted(found: Score) -> dict[str, Any]:
    expected = {"lo": found.expected[0], "hi": found.expected[1], "p": 0.95}
    return {"score": {"inside": found.inside, "estimated": found.estimated, "expected": expected}}


WITH_MODEL = ("vacuum_offset", "angle_random_walk")  # shown with the model, which has no such terms


def _of_others(row: Any) -> bool:
    return row["quantity"] in WITH_MODEL and case_of(row).at is None


def _print_scored(outcome: Any, found: Any) -> None:
    """Print the model beside the truth, not every figure of every test; those where no model is made."""
    from ..shown.screen import ROWS, folded, say
    from ..shown.summary import closed_loop_text, requirement_table
    from .twins import held_text, truth_table

    model = [row for row in found.rows if row["test"] == "model" or _of_others(row)]
    model = model if any(row["test"] == "model" for row in model) else []
    what = "the model" if model else "the results"
    print("\n" + wrapped(f"{outcome.results['campaign']['title']}: {what} and the simulated truth"))
    print(folded(truth_table(model or found.rows), ROWS // 2))
    print(f"\n{held_text(found)}")
    say(f"\n{closed_loop_text(outcome.results)}")
    shown = requirement_table(outcome.results)
    say("\n".join([*([f"\n{shown}"] if shown else []), f"\n{where_text(outcome)}"]))
