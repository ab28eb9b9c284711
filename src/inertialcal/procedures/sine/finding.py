"""What a known drive found, in one sentence."""

from __future__ import annotations

from collections.abc import Sequence

from ...core.show.sentence import Sentence, WrittenRow, largest_of


def finding(rows: Sequence[WrittenRow]) -> Sentence:
    """Say the largest amplitude."""
    return largest_of(("amplitude",), rows) or ("No amplitude could be estimated",)
