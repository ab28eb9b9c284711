"""show of a ``results.json``: the table of its figures, or one figure of it as a picture."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from .. import figures
from .output import json_out

if TYPE_CHECKING:
    from ...campaign.outcome.results_file import ResultsFile


def show_results(
    found: ResultsFile, output: Path | None, chosen: dict[str, str | None], as_json: bool, quiet: bool
) -> int:
    """Print the results, or draw one figure of them.

    Raises
    ------
    DataError
        If the file does not hold what a run writes, or has no data for the figure.
    """
    from ...campaign.outcome.results_file import as_results

    with as_results(found.path):
        line = "" if output is None else figures.write(output, found.content, [found.path], chosen)
        if as_json:
            _json(found, output)
        elif not quiet:
            print(line or _text(found))
    return 0


def _json(found: ResultsFile, output: Path | None) -> None:
    content = {"inputs": [{"path": found.path, "sha256": found.sha256}]} | found.content
    json_out("show", content if output is None else content | {"written": str(output)})


def _text(found: ResultsFile) -> str:
    from .summary import closed_loop_text, results_text, verdicts_text

    content = found.content
    parts = [results_text(content)]
    if content.get("closed_loop"):
        parts.append(closed_loop_text(content))
    if content.get("verdicts"):
        parts.append(f"requirements ({content['decision_rule']})\n{verdicts_text(content)}")
    return "\n\n".join(parts)
