"""What a flip found, in one sentence."""

from __future__ import annotations

from collections.abc import Sequence

from ...core.show.sentence import Cited, Quoted, Sentence, WrittenRow, error_sentence, estimated, largest, largest_of

BIASES = ("bias", "model_bias_error")


def finding(rows: Sequence[WrittenRow]) -> Sentence:
    """Say the largest bias, and the error of the control axis."""
    said = largest_of(BIASES, rows)
    if not said:
        return error_sentence(rows)
    control = largest(estimated(rows, "control_error"))
    if control is None:
        return said
    axis, of_turn = Quoted(control["axis"]), " of the turn, where zero is right"
    return (*said, "; control axis ", axis, " reads ", Cited(control), of_turn)
