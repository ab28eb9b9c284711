"""Card images of the 1969 analysis programme (``.cards``): a line a card, read as a recording.

Values that the deck declares wrong are missing samples. A deck of several cases, its requests and the programme itself
are for ``inertialcal programme-1969``.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...core.errors import DataError
from ...core.remarks import Remark
from ...core.show.rounding import items
from ...signals.programme1969.cards import MeasuredCase, read_cards, series_with_gaps
from ..columns import Column, Content
from ..reader import Reader
from ..source import Loaded
from .layout import text_of

ENDING = ".cards"


def read_card_images(loaded: Loaded, variables: Sequence[str] | None = None) -> Content:
    """Return the two series of a deck of one case: accelerometer [count] and tilt meter.

    Raises
    ------
    DataError
        ``bad_card`` as ``read_cards``; ``several_cases``.
    """
    text, remarks = text_of(loaded)
    deck = read_cards(text, loaded.path)
    if len(deck) != 1:
        what, do = f"{len(deck)} cases in one deck", "Split it, or use: inertialcal programme-1969 FILE"
        raise DataError(what, loaded.path, do=do, code="several_cases")
    (case,) = deck
    x, tilt = series_with_gaps(case)
    wrong = int(np.count_nonzero(np.isnan(x)))
    if wrong and isinstance(case, MeasuredCase):
        what = f"{items(wrong, 'value')} marked as wrong in the deck: treated as missing"
        remarks += (Remark("wrong_values", "info", what, loaded.path, count=wrong),)
    columns = (Column("accelerometer", x, "count"), Column("tilt", tilt))
    return Content(columns, "card images", sample_rate=1.0 / case.NH if case.NH > 0 else None, remarks=remarks)


READER = Reader(
    "cards",
    "card images of 1969",
    (ENDING,),
    lambda data, path: path.lower().removesuffix(".gz").endswith(ENDING),
    read_card_images,
)
