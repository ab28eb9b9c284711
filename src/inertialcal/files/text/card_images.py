"""Card images of the 1969 analysis programme, from a text file: a line a card."""

from __future__ import annotations

from pathlib import Path

from ...signals.programme1969.cards import Deck, read_cards
from ..source import load
from .encoding import decode


def read_card_images(path: str | Path) -> Deck:
    """Return the cases of a file of card images.

    Parameters
    ----------
    path : path
        Text, or packed with gzip.

    Raises
    ------
    DataError
        As ``source.load`` and ``programme1969.read_cards``; the message names file and card.
    """
    loaded = load(path)
    return read_cards(decode(loaded.data, loaded.path)[0], loaded.path)
