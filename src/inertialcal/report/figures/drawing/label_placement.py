"""Words beside marks: on which side of its mark a word lies on nothing else."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

WIDE, HIGH = 0.78, 0.95  # of a character, as shares of the size of the type
SIDES = ((1, -1), (1, 1), (-1, -1), (-1, 1), (1, 0), (-1, 0), (0, 1), (0, -1))  # of the mark, the best first
GAPS = (1.2, 4.2, 7.2)  # between a mark and its word [pt], the best first


@dataclass(frozen=True)
class Box:
    """What is taken: its middle and half its sides [pt]."""

    x: float
    y: float
    across: float
    high: float

    def on(self, other: Box) -> float:
        """Return the area that both share [pt^2]."""
        wide = self.across + other.across - abs(self.x - other.x)
        high = self.high + other.high - abs(self.y - other.y)
        return max(wide, 0.0) * max(high, 0.0)


def placed(x: float, y: float, radius: float, text: str, size: float, taken: Sequence[Box]) -> Box:
    """Return the place of a word beside a mark: the first side on which it covers nothing, else the least.

    Parameters
    ----------
    x, y, radius : float
        Of the mark [pt].
    text : str
        The word.
    size : float
        Of the type [pt].
    taken : sequence of Box
        Marks and words that are there; the mark itself may be among them.
    """
    across, high = 0.5 * WIDE * size * len(text), 0.5 * HIGH * size
    tried = []
    for gap, (side, up) in product(GAPS, SIDES):
        away = gap + (radius if not (side and up) else 0.75 * radius)  # at a corner a word is nearer to a round mark
        tried.append(Box(x + side * (away + across), y + up * (away + high), across, high))
    return min(tried, key=lambda box: sum(box.on(one) for one in taken))
