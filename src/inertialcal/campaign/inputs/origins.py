"""Origin: a recording that a test draws on, and how much of it the campaign chose."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class Origin:
    """One recording of a test.

    Parameters
    ----------
    name, file, sha256 : str
        In the campaign; path in its folder; hash of the file.
    kind : {"table", "recording"}
        Rows are dwells, or samples.
    rows : int
        In the file.
    chosen : int
        Of them, inside the groups and windows of the test.
    without_rate : int
        Rows of a table without an applied rate: no dwells, whatever is chosen; not among ``chosen``.
    """

    name: str
    file: str
    sha256: str
    kind: Literal["table", "recording"]
    rows: int
    chosen: int
    without_rate: int = 0

    @property
    def not_chosen(self) -> int:
        """Rows with a rate, or samples, outside the groups and windows of the test."""
        return self.rows - self.chosen - self.without_rate

    @property
    def counts(self) -> str:
        """What a row is: ``"row"`` or ``"sample"``."""
        return "row" if self.kind == "table" else "sample"
