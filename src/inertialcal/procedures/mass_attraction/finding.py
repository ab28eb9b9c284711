"""What a moved mass found, in one sentence."""

from __future__ import annotations

from collections.abc import Sequence

from ...core.results import WrittenRow, case_of
from ...core.show.sentence import Cited, Sentence, estimated, largest
from ...core.show.wording import counted


def finding(rows: Sequence[WrittenRow]) -> Sentence:
    """Say the scale factor, of how many runs, what it is off, and whether null runs are zero."""
    runs = {case_of(row): row for row in rows if row["quantity"] == "response_amplitude"}
    found = largest(estimated(rows, "scale_factor"))
    if found is None:
        return (f"The response of {counted(len(runs), 'run')} is not told from noise",)
    said: Sentence = ("Scale factor ", Cited(found), " from ", counted(len(runs), "run"), " with the mass moved")
    off = largest(estimated(rows, "high_g_difference"))
    if off is not None:
        said = (*said, "; ", Cited(off), " off that at high g")
    null = largest([row for row in rows if row["quantity"] == "null_response" and row["value"] is not None])
    return said if null is None else (*said, "; with the mass at rest at most ", Cited(null))
