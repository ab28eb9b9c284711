"""What a record at rest found, in one sentence."""

from __future__ import annotations

from collections.abc import Sequence

from ...core.results import WrittenRow
from ...core.show.rows import Cited, Quoted, Sentence, estimated, largest, reason_text
from ...core.show.wording import words

TERMS = ("angle_random_walk", "velocity_random_walk", "bias_instability", "gauss_markov_sigma", "rate_random_walk",
         "acceleration_random_walk")  # fmt: skip
TOLD = 2  # terms in a sentence


def finding(rows: Sequence[WrittenRow]) -> Sentence:
    """Say the largest of the first two terms that were found, white noise and bias instability before others."""
    shown = [row for quantity in TERMS if (row := largest(estimated(rows, quantity))) is not None][:TOLD]
    if not shown:
        return ("No noise term could be estimated",)
    said: Sentence = ()
    for row in shown:
        start = "; largest " if said else "Largest "
        said = (*said, start, words(row["quantity"]), " ", Cited(row), ", on ", Quoted(row["axis"]))
    doubt = next((reason for row in shown if (reason := reason_text(row))), "")
    if doubt:
        return (*said, "; ", Quoted(doubt))
    return said if estimated(rows, "bias_instability") else (*said, "; no bias instability found")
