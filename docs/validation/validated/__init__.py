"""Parts of the validation: each sets figures of the tool beside those of others, and gives tables."""

from collections.abc import Callable

from . import coverage, least_squares, noise, peers, recordings, slower
from .found import AbsentError, Table

PARTS: dict[str, Callable[[], list[Table]]] = {
    "recordings": recordings.tables,
    "noise": noise.tables,
    "least_squares": least_squares.tables,
    "peers": peers.tables,
    "coverage": coverage.tables,
    "slower": slower.tables,
}

__all__ = ["PARTS", "AbsentError", "Table"]
