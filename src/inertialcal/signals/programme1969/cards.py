"""Card images of the 1969 programme: text of fixed columns -> cases.

A deck is one case after another until a case card with a negative number: a case card; then either a card that
describes a synthetic series, or a card that describes the data, the accelerometer's values (five to a card), the tilt
meter's, and a card for each wrong position; then requests until 6. Fields are whole numbers set against the right edge
of their columns: a blank behind a digit counts as a zero on the machine that the programme ran on, and is refused here.
An empty field is zero. Columns behind the last field are not read.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import accumulate

import numpy as np
from numpy.typing import NDArray

from ...core.errors import DataError
from ...core.estimate import Array

Counts = NDArray[np.int64]

TEST = (("N", 4), ("NH", 4), ("MAXL", 4), ("MAXK", 4), ("LXS", 8), ("KXS", 4), ("LXC", 8), ("KXC", 4), ("LY", 8),
        ("KY", 4), ("KO", 4))  # fmt: skip
DATA = tuple((name, 4) for name in ("N", "NH", "ML", "NA", "MN", "MAXL", "MAXK", "KO", "MON", "MD"))
VALUES = {
    "AX": tuple((10 * i + 3, 10 * i + 9) for i in range(5)),  # 5(3X,I6,1X)
    "AY": tuple((11 * i + 2, 11 * i + 10) for i in range(5)),
}  # 5(2X,I8,1X)
MOST = {"N": 100, "ML": 600, "MN": 20}
ANALYSE, TILT, LINE, HARMONICS, CURVE, LEAVE = range(1, 7)  # requests
NUMBERED = {HARMONICS: "MA", CURVE: "JA"}  # a card with a number follows


@dataclass(frozen=True)
class Request:
    """What to do next."""

    what: int  # 1 analyse; 2 tilt trace, 3 straight line, 4 harmonics, 5 adjusted curve, each with an analysis after it
    number: int = 0  # MA or JA, where one belongs to it


@dataclass(frozen=True)
class SyntheticCase:
    """A series of sine and cosine, for a test of the programme itself; names as on the card."""

    # N, NH, MAXL, MAXK, LXS, KXS, LXC, KXC, LY, KY, KO: samples; sample time [s]; lags; lines; amplitude and half
    # period (in samples) of the sine, of the cosine, and of the cosine of the tilt meter; samples per cycle
    N: int
    NH: int
    MAXL: int
    MAXK: int
    LXS: int
    KXS: int
    LXC: int
    KXC: int
    LY: int
    KY: int
    KO: int
    requests: tuple[Request, ...] = ()  # in their order


@dataclass(frozen=True, eq=False)
class MeasuredCase:
    """Measured series; names as on the card."""

    # N, NH, ML, NA, MN, MAXL, MAXK, KO, MON, MD: samples used; sample time [s]; values on the cards; input amplitude
    # [ng]; wrong values; lags; lines; samples per cycle; month; day
    N: int
    NH: int
    ML: int
    NA: int
    MN: int
    MAXL: int
    MAXK: int
    KO: int
    MON: int
    MD: int
    # AX, AY: impulses of the accelerometer; readings of the tilt meter, shape (ML,)
    AX: Counts
    AY: Counts
    wrong: tuple[int, ...] = ()  # positions from 1, each in the series as shortened by those before it
    requests: tuple[Request, ...] = ()  # in their order


@dataclass(frozen=True, eq=False)
class RecordedCase:
    """Series of a recording, in its own unit; names as on the card."""

    # N, NH, MAXL, MAXK, KO: samples used; sample time [s]; lags; lines; samples per cycle
    N: int
    NH: float
    MAXL: int
    MAXK: int
    KO: int
    AX: Array  # reading at each sample time, NaN where there is none, shape (n,)
    AY: Array | None  # tilt meter, where there is one, shape (n,)
    NA: float | None = None  # input amplitude [unit said]
    requests: tuple[Request, ...] = ()  # in their order


Case = SyntheticCase | MeasuredCase | RecordedCase
Deck = tuple[SyntheticCase | MeasuredCase, ...]


def read_cards(text: str, where: str = "") -> Deck:
    """Return the cases of a deck.

    Parameters
    ----------
    text : str
        A line a card.
    where : str
        File, for messages.

    Raises
    ------
    DataError
        ``bad_card``: a field that is no whole number or not set to the right, a number out of its range, or a deck
        that ends early. The message names card and columns.
    """
    cards = _Cards(text.splitlines(), where)
    found: list[SyntheticCase | MeasuredCase] = []
    while cards.more or not found:
        kind = cards.fields((("KT", 4),))["KT"]
        if kind < 0:
            break
        found.append(_measured(cards) if kind == 0 else _synthetic(cards))
    if not found:
        raise cards.refused("the deck has no cases")
    return tuple(found)


class _Cards:
    """Cards taken one after another."""

    def __init__(self, lines: Sequence[str], where: str):
        self._lines, self._where, self._next = lines, where, 0

    @property
    def more(self) -> bool:
        """Whether a card that is not blank is left."""
        return any(line.strip() for line in self._lines[self._next :])

    def refused(self, what: str, do: str = "") -> DataError:
        place = f"{self._where}:{self._next}" if self._where else f"card {self._next}"
        return DataError(what, where=place, do=do, code="bad_card")

    def take(self, meaning: str) -> str:
        if self._next >= len(self._lines):
            raise self.refused(f"the deck ends where a card with {meaning} is needed", "Add the card")
        self._next += 1
        return self._lines[self._next - 1]

    def fields(self, layout: Sequence[tuple[str, int]]) -> dict[str, int]:
        """Return the numbers of a card by name; those with a range are checked."""
        card = self.take(", ".join(name for name, _ in layout))
        stops = accumulate(width for _, width in layout)
        found = {
            name: self._number(card, stop - width, stop, name)
            for (name, width), stop in zip(layout, stops, strict=True)
        }
        for name, most in MOST.items():
            if not 0 <= found.get(name, 0) <= most:
                raise self.refused(f"{name} = {found[name]}", f"The programme takes 0 to {most}")
        return found

    def series(self, name: str, count: int) -> Counts:
        """Return so many values, five to a card."""
        values: list[int] = []
        while len(values) < count:
            card = self.take(f"values of {name}")
            places = VALUES[name][: count - len(values)]
            values += [self._number(card, start, stop, name) for start, stop in places]
        return np.array(values, dtype=np.int64)

    def _number(self, card: str, start: int, stop: int, name: str) -> int:
        text = card[start:stop]
        try:
            if text.strip() and len(text.rstrip()) < stop - start:
                raise ValueError
            return int(text) if text.strip() else 0
        except ValueError:
            do = "Set whole numbers against the right edge: a blank after a digit counted as a zero"
            raise self.refused(f"columns {start + 1}-{stop}, {name}: cannot read {text!r}", do) from None


def _synthetic(cards: _Cards) -> SyntheticCase:
    head = cards.fields(TEST)
    for name in ("KXS", "KXC", "KY"):
        amplitude = {"KXS": "LXS", "KXC": "LXC", "KY": "LY"}[name]
        if head[amplitude] and head[name] < 1:
            raise cards.refused(f"{name} = {head[name]}: half period shorter than a sample", "Give 1 or more")
    return SyntheticCase(**head, requests=tuple(_requests(cards)))


def _measured(cards: _Cards) -> MeasuredCase:
    head = cards.fields(DATA)
    if head["ML"] - head["MN"] < head["N"]:
        what = f"{head['ML']} values less {head['MN']} wrong ones are fewer than the {head['N']} used"
        raise cards.refused(what, "Give a smaller N, or more values")
    AX, AY = cards.series("AX", head["ML"]), cards.series("AY", head["ML"])
    wrong = []
    for taken in range(head["MN"]):
        at = cards.fields((("KM", 4),))["KM"]
        if not 1 <= at <= head["ML"] - taken:
            raise cards.refused(f"wrong position {at}", f"The series has 1 to {head['ML'] - taken} by then")
        wrong.append(at)
    return MeasuredCase(**head, AX=AX, AY=AY, wrong=tuple(wrong), requests=tuple(_requests(cards)))


def _requests(cards: _Cards) -> Iterator[Request]:
    while (what := cards.fields((("IC", 4),))["IC"]) != LEAVE:
        if not ANALYSE <= what < LEAVE:
            raise cards.refused(f"request {what}", "There are 1 to 6")
        name = NUMBERED.get(what)
        yield Request(what, cards.fields(((name, 4),))[name] if name else 0)


def series_with_gaps(case: Case) -> tuple[Array, Array]:
    """Return the accelerometer and tilt series of a case with NaN where a value is wrong, up to the N-th good one.

    The parts of a synthetic case run as ``pi i / K`` with the half period K on the card, as the code has it (the
    printed heading says 2 pi). They are taken as real numbers: whether the machine cut them to whole ones the text does
    not say.
    """
    if isinstance(case, SyntheticCase):
        i = np.arange(case.N)
        parts = ((case.LXS, case.KXS, np.sin), (case.LXC, case.KXC, np.cos), (case.LY, case.KY, np.cos))
        sine, cosine, tilt = (size * wave(np.pi / max(K, 1) * (i % (2 * max(K, 1)))) for size, K, wave in parts)
        return sine + cosine, tilt
    if isinstance(case, RecordedCase):
        tilt = np.zeros(len(case.AX)) if case.AY is None else case.AY
        good = np.flatnonzero(np.isfinite(case.AX) & np.isfinite(tilt))[: case.N]
        x, both = np.full((2, good.max(initial=-1) + 1), np.nan)
        x[good], both[good] = case.AX[good], tilt[good]
        return x, both
    kept = np.arange(case.ML)
    for position in case.wrong:
        kept = np.delete(kept, position - 1)
    kept = kept[: case.N]
    x, tilt = np.full((2, kept.max(initial=-1) + 1), np.nan)
    x[kept], tilt[kept] = case.AX[kept], case.AY[kept]
    return x, tilt


def closed_up_series(case: Case) -> tuple[Array, Array]:
    """Return both series with wrong values taken out by shifting what follows to the left, shape (N,) each.

    All that follows comes earlier by a sample, so that a drive of known phase is out of step from there on: never do
    this with data.
    """
    x, tilt = series_with_gaps(case)
    good = np.isfinite(x)
    return x[good], tilt[good]
