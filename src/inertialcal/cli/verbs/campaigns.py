"""init, check, run, demo: commands that work on a campaign."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ...core.errors import UsageError
from .. import figures
from ..options import Folder, Json, Quiet
from ..shown.output import followed, found, json_out, wrapped
from ..shown.progress import progress
from .archive import archived

if TYPE_CHECKING:
    from ...campaign.engine.run import Outcome


def run(
    folder: Folder,
    open_report: Annotated[bool, typer.Option("--open", "--show", help="Open the report in the browser.")] = False,
    plot: figures.Plot = False,
    figure: figures.FigureName = None,
    pdf: Annotated[
        bool, typer.Option("--pdf", help="Write the report as out/report.pdf too: two pages, and one a test.")
    ] = False,
    appendices: Annotated[
        bool, typer.Option("--appendices", help="With --pdf: every quantity, verdict and input at the end.")
    ] = False,
    archive: Annotated[
        str | None,
        typer.Option("--archive", metavar="URL", help="Add the results to this archive: lab.db.", show_default=False),
    ] = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Run a campaign: every test, every requirement, results and report into DIR/out/."""
    from ...campaign.engine.run import run as run_campaign
    from ..opening import open_file

    if appendices and not pdf:
        raise UsageError("--appendices: they stand in the PDF", do="Add --pdf", code="wrong_value")
    figures.check_figure(None, {"--figure": figure}, plot, plot and as_json)
    with progress(quiet or as_json) as tell:
        outcome = run_campaign(folder, tell, pdf=pdf, appendices=appendices)
    added = None if archive is None else archived(archive, folder)  # no verdict is told before it is kept
    found(outcome.exit_status)
    if as_json:
        kept = {} if added is None else {"archived": added.to_dict()}
        json_out("run", outcome_content(outcome) | kept, outcome.exit_status)
    elif not quiet:
        print_outcome(outcome)
        if added is not None:
            print(wrapped(str(added)))
    if plot:
        figures.print_plot(outcome, {"figure": figure})
    if open_report:
        open_file(report_path(outcome))
    return outcome.exit_status


def where_text(outcome: Outcome) -> str:
    """Return where the results of a run are, and which of them to read."""
    return wrapped(f"results are in {outcome.folder / 'out'}: open report.html there in a browser, or add --open")


def report_path(outcome: Outcome) -> Path:
    """Return the page that a run wrote."""
    return Path(outcome.folder) / "out" / "report.html"


def outcome_content(outcome: Outcome) -> dict[str, Any]:
    """Return what ``--json`` says of a run."""
    inputs = [{"path": path, "sha256": digest} for path, digest in sorted(outcome.inputs.items())]
    remarks = outcome.results["remarks"] + [one.to_dict() for one in outcome.notes]
    return {"inputs": inputs, **outcome.results, "remarks": remarks, "changed": outcome.changed}


def print_outcome(outcome: Outcome) -> None:
    """Print figures, remarks, closed loop and verdicts of a run."""
    from ..shown.screen import say, screen
    from ..shown.summary import closed_loop_text, remarks_part, requirement_table, results_parts, verdicts_part

    results = outcome.results
    parts = [*results_parts(results), remarks_part(results["remarks"]), closed_loop_text(results)]
    if results["verdicts"]:
        parts.append(verdicts_part(results))
    if outcome.changed:
        lines = [wrapped(f"  {line}", "    ") for line in outcome.changed[:20]]
        parts.append("\n".join([f"changed since the last run: {len(outcome.changed)}", *lines]))
    notes = "\n".join(wrapped(str(note)) for note in outcome.notes)
    parts += [notes, requirement_table(results), where_text(outcome)]
    say(screen(parts))


def budget(
    source: Annotated[Path, typer.Argument(help="Folder of a campaign, or its results.json.", show_default=False)],
    wanted: Annotated[
        list[str],
        typer.Option("--wanted", help='Standard uncertainty to reach: "scale_factor_error=0.02 %". May be repeated.'),
    ] = [],  # noqa: B006 - typer copies it
    test: Annotated[str | None, typer.Option(help="Of this test alone; model for the model.")] = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Where the uncertainty of each result comes from, and which standard must improve to reach a wanted one."""
    from ...campaign.outcome.budget import budget as budget_of
    from ..shown.screen import folded, say
    from ..shown.summary import budgets_text

    found_budgets = budget_of(source, wanted, test)
    if as_json:
        content = {
            "inputs": [{"path": found_budgets.path, "sha256": found_budgets.sha256}],
            "budgets": [one.to_dict() for one in found_budgets.figures],
            "undecided": list(found_budgets.undecided),
        }
        json_out("budget", content)
    elif not quiet:
        say(folded(budgets_text(found_budgets)))
    return 0


def check(folder: Folder, as_json: Json = False, quiet: Quiet = False) -> int:
    """Judge the inputs of a campaign: the campaign file and every recording it names."""
    from ...campaign.engine.whole import check as check_campaign
    from ...core.remarks import condensed
    from ..shown.screen import all_asked, folded, say
    from ..shown.summary import remarks_text

    checked = check_campaign(folder)
    campaign, inputs, remarks = checked
    if as_json:
        listed = [{"path": path, "sha256": digest} for path, digest in sorted(inputs.items())]
        content = {"inputs": listed, "remarks": [remark.to_dict() for remark in remarks]}
        json_out("check", content, checked.exit_status)
    elif not quiet:
        if remarks:
            few = remarks if all_asked() else condensed(remarks)
            lines = [*remarks_text([one.to_dict() for one in few])]
            rest = len(remarks) - len(few)
            lines += [f"  ... {rest} more like these: --all"] if rest else []
            say(folded("\n".join(lines)))
        tests, recordings = len(campaign.file.tests), len(campaign.file.recordings)
        said = f"{tests} test{'s' * (tests != 1)}, {recordings} recording{'s' * (recordings != 1)}"
        state = "recordings disagree, no model is made" if checked.exit_status else "ok"
        print(followed(f"{state}: {said}", f"inertialcal run {shlex.quote(str(folder))}"))
    return checked.exit_status
