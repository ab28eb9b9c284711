"""init, check, run, demo: commands that work on a campaign."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ...core.errors import UsageError
from ..options import Folder, Json, Quiet
from ..shown.output import clean, found, json_out, wrapped
from ..shown.progress import progress

if TYPE_CHECKING:
    from ...campaign.engine.run import Outcome


def run(
    folder: Folder,
    open_report: Annotated[bool, typer.Option("--open", help="Open the report in the browser.")] = False,
    pdf: Annotated[
        bool, typer.Option("--pdf", help="Write the report as out/report.pdf too: two pages, and one a test.")
    ] = False,
    appendices: Annotated[
        bool, typer.Option("--appendices", help="With --pdf: every quantity, verdict and input at the end.")
    ] = False,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Run a campaign: every test, every requirement, results and report into DIR/out/."""
    from ...campaign.engine.run import run as run_campaign
    from ..opening import open_page

    if appendices and not pdf:
        raise UsageError("--appendices: they stand in the PDF", do="Add --pdf", code="wrong_value")
    with progress(quiet or as_json) as tell:
        outcome = run_campaign(folder, tell, pdf=pdf, appendices=appendices)
    found(outcome.exit_status)
    if as_json:
        json_out("run", outcome_content(outcome), outcome.exit_status)
    elif not quiet:
        print_outcome(outcome)
    if open_report:
        open_page(report_path(outcome))
    return outcome.exit_status


def where_text(outcome: Outcome) -> str:
    """Return where the results of a run are, and which of them to read."""
    return clean(f"results in {outcome.folder / 'out'}; to read: {report_path(outcome)}")


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
    from ..shown.summary import closed_loop_text, remarks_text, requirement_table, results_text, verdicts_text

    results = outcome.results
    print(results_text(results))
    if results["remarks"]:
        print("\nremarks")
        for text in remarks_text(results["remarks"]):
            print(f"  {text}")
    print(f"\n{closed_loop_text(results)}")
    if results["verdicts"]:
        print(f"\nrequirements ({clean(results['decision_rule'])})")
        print(verdicts_text(results))
    if outcome.changed:
        print(f"\nchanged since the last run: {len(outcome.changed)}")
        for line in outcome.changed[:20]:
            print(f"  {clean(line)}")
    if outcome.notes:
        print()
    for note in outcome.notes:
        print(wrapped(str(note)))
    if shown := requirement_table(results):
        print(f"\n{shown}")
    print(f"\n{where_text(outcome)}")


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
        print(budgets_text(found_budgets))
    return 0


def check(folder: Folder, as_json: Json = False, quiet: Quiet = False) -> int:
    """Judge the inputs of a campaign: the campaign file and every recording it names."""
    from ...campaign.engine.whole import check as check_campaign

    checked = check_campaign(folder)
    campaign, inputs, remarks = checked
    if as_json:
        listed = [{"path": path, "sha256": digest} for path, digest in sorted(inputs.items())]
        content = {"inputs": listed, "remarks": [remark.to_dict() for remark in remarks]}
        json_out("check", content, checked.exit_status)
    elif not quiet:
        for remark in remarks:
            print(wrapped(str(remark), "    "))
        tests, recordings = len(campaign.file.tests), len(campaign.file.recordings)
        said = f"{tests} test{'s' * (tests != 1)}, {recordings} recording{'s' * (recordings != 1)}"
        state = "recordings disagree, no model is made" if checked.exit_status else "ok"
        print(clean(f"{state}: {said}. Next: inertialcal run {shlex.quote(str(folder))}"))
    return checked.exit_status
