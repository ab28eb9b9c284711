"""Sizes of texts in the font of the figures, from the advances of their letters, and free places for them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from io import BytesIO
from itertools import product
from pathlib import Path

from matplotlib.font_manager import FontProperties, findfont
from matplotlib.ft2font import FT2Font, LoadFlags

FONT = "DejaVu Sans"  # wider than the fonts of browsers: what has room in it has room in them
WIDE, HIGH = 0.78, 0.95  # of a character, relative to the size of the font
LEADING = 1.2  # height of a line, relative to the size of the font
SIZE = 100.0  # at which letters are measured [pt]
SIDES = ((1, -1), (1, 1), (-1, -1), (-1, 1), (1, 0), (-1, 0), (0, 1), (0, -1))  # of the mark, the best first
GAPS = (1.2, 4.2, 7.2)  # between a mark and its word [pt], the best first


def width(text: str, size: float) -> float:
    """Return how wide the widest line of a text is at a size of the font, in points."""
    return max(sum(map(_advance, line)) for line in text.split("\n")) * size


def height(text: str, size: float) -> float:
    """Return how high a text is, all its lines, in points; 0 for none."""
    return (text.count("\n") + 1) * LEADING * size if text else 0.0


def folded(text: str, size: float, widest: float) -> str:
    """Return a text folded into lines that are not wider than that [pt], between words where it has any."""
    lines = [""]
    for word in text.split(" "):
        whole = f"{lines[-1]} {word}" if lines[-1] else word
        if width(whole, size) <= widest:
            lines[-1] = whole
            continue
        lines += [""] if lines[-1] else []
        for letter in word:
            lines += [""] if lines[-1] and width(lines[-1] + letter, size) > widest else []
            lines[-1] += letter
    return "\n".join(lines)


def shortened(text: str, size: float, widest: float) -> str:
    """Return a text that is not wider than that [pt]: its end gives way to an ellipsis."""
    if width(text, size) <= widest:
        return text
    while text and width(text + "…", size) > widest:
        text = text[:-1]
    return text + "…"


@cache
def _font() -> FT2Font:
    # Our own: of shared ones the size changes. From memory: two processes would share the place in an open file.
    font = FT2Font(BytesIO(Path(findfont(FontProperties(family=[FONT]))).read_bytes()))
    font.set_size(SIZE, 72)
    return font


@cache
def _advance(letter: str) -> float:
    """Advance of a letter, relative to the size of the font; a whole size for one that the font has not."""
    if not _font().get_char_index(ord(letter)):
        return 1.0
    return float(_font().load_char(ord(letter), flags=LoadFlags.NO_HINTING).linearHoriAdvance) / 65536.0 / SIZE


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
