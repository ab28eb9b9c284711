"""JSON as files hold it: full digits, a level a blank, no NaN.

``json.dumps`` leaves its compiled encoder where it indents, and much of its time goes into digits. For files with
many numbers and a checksum over their canonical form, `json_texts` makes both in one pass, byte for byte the same. What
stands in several places is written once, and numbers of a frame that are zero in all units are part of its text: most
of a model file is covariances, and most of these zeros.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Iterator, Sequence, Set
from functools import lru_cache
from json.encoder import encode_basestring
from operator import itemgetter
from typing import TYPE_CHECKING, Any, TypeGuard

if TYPE_CHECKING:
    from ..estimate import Array


def _number(given: float) -> str:
    text = float.__repr__(given)
    _check_finite(text)
    return text


def _check_finite(text: str) -> None:
    if "n" in text:  # of nan and inf alone
        raise ValueError("JSON has no NaN and no infinity")


Texts = tuple[str, str]  # As files hold it; canonical
LISTS = (list, tuple)
FIXED = {None: "null", True: "true", False: "false"}
NULL = FIXED[None], FIXED[None]
PLAIN: dict[type, Callable[[Any], str]] = {
    str: encode_basestring, float: _number, type(None): FIXED.__getitem__, bool: FIXED.__getitem__, int: int.__repr__,
}  # fmt: skip


class _Encoded(dict[str, Texts]):
    """Text in both forms, which are the same, each made once."""

    def __missing__(self, given: str) -> Texts:
        text = encode_basestring(given)
        self[given] = found = text, text
        return found


class Hole:
    """Where a value comes into a frame, at the first depth or inside a dict of it."""

    def __init__(self, name: str) -> None:
        self.name = name


class Frame:
    """A dict with holes; what several of them have alike is written once.

    Parameters
    ----------
    content : dict
        That does not change any more.
    endless : set of str
        Names of holes for arrays, shape (k,), in which an infinite number is written as null.
    """

    def __init__(self, content: dict[str, Any], endless: Set[str] = frozenset()) -> None:
        self.content, self.endless = content, endless


class Filled:
    """A frame with the values of its holes; it is written as the dict that it makes.

    Parameters
    ----------
    frame : Frame
        Shared by all that differ in these values alone.
    values : dict
        By the names of the holes, in one order for all of a frame: arrays of float64, and whatever else JSON has,
        filled frames too.
    """

    def __init__(self, frame: Frame, values: dict[str, Any]) -> None:
        self.frame, self.values = frame, values

    @property
    def content(self) -> dict[str, Any]:
        """The dict."""
        lists: dict[str, Any] = {name: part.tolist() for name, part in self.values.items() if _is_array(part)}
        for name in self.frame.endless & lists.keys():
            lists[name] = [None if one == math.inf else one for one in lists[name]]
        return _fill(self.frame.content, self.values | lists)


def _fill(content: dict[str, Any], values: dict[str, Any]) -> dict[str, Any]:
    return {
        name: values[part.name] if isinstance(part, Hole) else _fill(part, values) if isinstance(part, dict) else part
        for name, part in content.items()
    }


Piece = str | tuple[object, str]


class _Known:
    """What was written: lists and dicts by identity and line, as long as these are held; and text."""

    def __init__(self) -> None:
        self.texts: dict[tuple[int, str], Texts] = {}
        # Of frames that hold others: text, and in place of each hole for these its value and its line
        self.pieces: dict[tuple[int, str], tuple[list[Piece], list[Piece]]] = {}
        self.plain: set[int] = set()  # Lists and dicts without frames, by identity
        self.encoded = _Encoded()

    def holds_frames(self, given: object) -> bool:
        """Whether a frame is in a value that was looked through for them, or is that value."""
        if type(given) is Filled:
            return True
        return (type(given) is dict or type(given) in LISTS) and bool(given) and id(given) not in self.plain


def json_text(content: object) -> str:
    """Return JSON with one newline at its end.

    Raises
    ------
    ValueError
        If a number is not finite.
    """
    return json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def json_texts(content: object) -> Texts:
    """Return a content as `json_text` without its newline, and in canonical form: keys sorted, no blanks.

    An array is written as the lists of its numbers.

    Raises
    ------
    ValueError
        If a number is not finite.
    TypeError
        For a key that is no text, and for what JSON has not.
    """
    return json_texts_many([content])[0]


def json_texts_many(contents: Sequence[object], last: Callable[[str], str] | None = None) -> list[Texts]:
    """Return the same of many contents; raises as `json_texts` where that refuses one of them.

    Parameters
    ----------
    contents : sequence
        Of any kind; dicts that are not empty where there is a ``last``.
    last : callable, optional
        Text that stands behind the last value of a content as it is laid out, by its canonical form.
    """
    known = _Known()
    levels: list[list[Place]] = [[]]
    for one in contents:
        _find_frames(one, "\n", known, levels[0])
    while levels[-1]:
        inner: list[Place] = []
        for filled, line in levels[-1]:
            lines = _lines_of(filled.frame)
            for name, part in filled.values.items():
                _find_frames(part, line + lines[name], known, inner)
        levels.append(inner)
    for level in reversed(levels):
        _write_frames(level, known)
    found = []
    for one in contents:
        laid, canonical = list[str](), list[str]()
        _gather(one, "\n", known, 0, laid)
        _gather(one, "\n", known, 1, canonical)
        whole = "".join(canonical)
        if last is not None:
            laid[-1] = laid[-1].removesuffix("\n}") + last(whole) + "\n}"
        found.append(("".join(laid), whole))
    return found


def _gather(given: object, line: str, known: _Known, form: int, pieces: list[str]) -> None:
    """Add a value in one form in pieces, so that what is long is joined once; frames in it are written already."""
    place = id(given), line
    if place in known.pieces:
        for piece in known.pieces[place][form]:
            if isinstance(piece, str):
                pieces.append(piece)
            else:
                _gather(piece[0], piece[1], known, form, pieces)
    elif place not in known.texts and known.holds_frames(given):
        inner = line + " "
        start, between, stop, colon = (inner, "," + inner, line, ": ") if form == 0 else ("", ",", "", ":")
        if isinstance(given, dict):
            names = [*given] if form == 0 else sorted(given)
            for i, name in enumerate(names):
                pieces.append(f"{between if i else '{' + start}{known.encoded[name][0]}{colon}")
                _gather(given[name], inner, known, form, pieces)
            pieces.append(stop + "}")
        else:
            for i, part in enumerate(given):  # type: ignore[var-annotated, arg-type]
                pieces.append(between if i else "[" + start)
                _gather(part, inner, known, form, pieces)
            pieces.append(stop + "]")
    else:
        pieces.append(_texts(given, line, known)[form])


Place = tuple["Filled", str]  # A frame, and the line that it stands in


def _find_frames(part: object, line: str, known: _Known, found: list[Place]) -> bool:
    """Add the filled frames in a value, but those within these; tell whether there are any."""
    if type(part) is Filled:
        found.append((part, line))
        return True
    if not known.holds_frames(part):
        return False
    inner, before = line + " ", len(found)
    for one in part.values() if isinstance(part, dict) else part:  # type: ignore[attr-defined]
        if type(one) not in PLAIN:
            _find_frames(one, inner, known, found)
    if len(found) == before:
        known.plain.add(id(part))
    return len(found) > before


@lru_cache(maxsize=256)
def _lines_of(frame: Frame) -> dict[str, str]:
    """Return how much deeper than the frame each of its holes stands, as blanks."""

    def within(content: dict[str, Any], blanks: str) -> Iterator[tuple[str, str]]:
        for part in content.values():
            if isinstance(part, Hole):
                yield part.name, blanks
            elif isinstance(part, dict):
                yield from within(part, blanks + " ")

    return dict(within(frame.content, " "))


def _texts(given: object, line: str, known: _Known) -> Texts:
    """Return a value in both forms; line is a newline, and the blanks before the value that it is in."""
    kind = type(given)
    if kind in PLAIN:
        text = PLAIN[kind](given)
        return text, text
    place = id(given), line
    if place in known.texts:
        return known.texts[place]
    if isinstance(given, LISTS):
        found = _texts_of_list(given, line, known) if given else ("[]", "[]")
    elif isinstance(given, dict):
        found = _texts_of_dict(given, line, known) if given else ("{}", "{}")
    elif isinstance(given, Filled):
        found = _texts(given.content, line, _Known())
    elif _is_array(given):
        found = _texts(given.tolist(), line, _Known())
    elif isinstance(given, Hole):
        found = f"\0{given.name}\0", f"\0{given.name}\0"  # as no text has
    else:
        write = next((PLAIN[one] for one in PLAIN if isinstance(given, one)), None)
        if write is None:
            raise TypeError(f"JSON has no {kind.__name__}")
        text = write(given)
        return text, text
    known.texts[place] = found
    return found


def _texts_of_dict(given: dict[str, object], line: str, known: _Known) -> Texts:
    laid, canonical, order = _frame(tuple(given), line)
    inner, encoded = line + " ", known.encoded
    parts = [
        encoded[part] if type(part) is str else NULL if part is None else _texts(part, inner, known)
        for part in given.values()
    ]
    return laid % tuple([text for text, _ in parts]), canonical % tuple([parts[i][1] for i in order])


@lru_cache(maxsize=256)
def _frame(names: tuple[str, ...], line: str) -> tuple[str, str, list[int]]:
    """Return a dict in both forms with room for its values, and the order of these in the canonical one."""
    keys = [encode_basestring(name).replace("%", "%%") for name in names]
    order = sorted(range(len(names)), key=names.__getitem__)
    laid = f",{line} ".join([f"{key}: %s" for key in keys])
    return f"{{{line} {laid}{line}}}", f"{{{','.join([f'{keys[i]}:%s' for i in order])}}}", order


_MARK = re.compile("\0([0-9]+)\0")  # of a hole
Shape = tuple[int, ...] | None  # of the array that comes into a hole; None for text
Pick = Callable[[list["Piece"]], Sequence["Piece"]]
Fixed = tuple[list[str], Pick]  # pieces of text with room for what comes between them; which of many texts that is
MANY = 1000  # numbers that are worth a call of Arrow


def _write_frames(every: Sequence[Place], known: _Known) -> None:
    """Write filled frames; numbers that are zero in all that are alike stand in the text of the frame."""
    alike: dict[tuple[Frame, str, tuple[Shape, ...]], list[Filled]] = {}
    for one, line in every:
        shapes = tuple([part.shape if _is_array(part) else () if type(part) is float else None
                        for part in one.values.values()])  # fmt: skip
        alike.setdefault((one.frame, line, shapes), []).append(one)
    groups = [(frame, line, shapes, filled, *_numbers_of(frame, shapes, filled))
              for (frame, line, shapes), filled in alike.items()]  # fmt: skip
    texts, start = number_texts([numbers for *_, numbers, _ in groups]), 0
    for frame, line, shapes, filled, changing, numbers, endless in groups:
        fixed = _frame_pieces(frame, line, tuple(filled[0].values), shapes, changing)
        for at in endless:
            texts[start + at] = NULL[0]
        each = len(numbers) // len(filled)
        for one in filled:
            _write_frame(one, line, shapes, fixed, texts[start : start + each], known)
            start += each


def _write_frame(
    one: Filled, line: str, shapes: tuple[Shape, ...], fixed: Sequence[Fixed], numbers: list[str], known: _Known
) -> None:
    """Put the text of its values and numbers between the fixed pieces of a frame, in both forms."""
    lines, deep, said = _lines_of(one.frame), False, list[tuple[Piece, Piece]]()
    for (name, part), shape in zip(one.values.items(), shapes, strict=True):
        if shape is None:
            inner = line + lines[name]
            if known.holds_frames(part):
                deep = True
                said.append(((part, inner), (part, inner)))
            else:
                said.append(_texts(part, inner, known))
    forms: list[list[Piece]] = []
    for form, (between, pick) in enumerate(fixed):
        pieces: list[Piece] = [*between]
        pieces[1::2] = pick([*[text[form] for text in said], *numbers])
        forms.append(pieces)
    if deep:
        known.pieces[id(one), line] = _joined(forms[0]), _joined(forms[1])
    else:
        known.texts[id(one), line] = "".join(forms[0]), "".join(forms[1])  # type: ignore[arg-type]


def _joined(pieces: Sequence[Piece]) -> list[Piece]:
    """Return pieces with text that stands together as one."""
    found: list[Piece] = []
    start = 0
    for at in [i for i, one in enumerate(pieces) if type(one) is not str]:
        found += "".join(pieces[start:at]), pieces[at]  # type: ignore[arg-type]
        start = at + 1
    return [*found, "".join(pieces[start:])]  # type: ignore[arg-type]


def _numbers_of(frame: Frame, shapes: tuple[Shape, ...], filled: Sequence[Filled]) -> tuple[bytes, Array, list[int]]:
    """Return which numbers of a frame change, a bit each; these, frame by frame; which of them are null."""
    import numpy as np  # noqa: PLC0415 - see `_is_array`

    own = [(name, shape) for name, shape in zip(filled[0].values, shapes, strict=True) if shape is not None]
    if not own:
        return b"", np.zeros(0), []
    every = np.concatenate([one.values[name] for one in filled for name, _ in own], axis=None)
    every = every.reshape(len(filled), -1)
    changing = (every.view("i8") != 0).any(axis=0)  # -0.0 is no zero
    found = every[:, changing]
    endless: list[int] = []
    if frame.endless:
        ends = np.repeat([name in frame.endless and shape != () for name, shape in own],
                         [math.prod(shape) for _, shape in own])  # fmt: skip
        null = (found == math.inf) & ends[changing]
        found[null] = 0.0
        endless = np.flatnonzero(null).tolist()
    if not np.isfinite(found).all():
        raise ValueError("JSON has no NaN and no infinity")
    return np.packbits(changing).tobytes(), found.reshape(-1), endless


def number_texts(parts: Sequence[Array]) -> list[str]:
    """Return the shortest text of each number that reads back to the same, as ``repr`` gives it.

    Parameters
    ----------
    parts : sequence of ndarray, shape (n,)
        Of numbers that are finite.
    """
    if sum(map(len, parts)) < MANY:
        return [float.__repr__(one) for part in parts for one in part.tolist()]
    import numpy as np  # noqa: PLC0415 - see `_is_array`
    import pyarrow as pa  # noqa: PLC0415 - the same

    numbers = np.concatenate(parts)
    # Arrow writes the same digits, but 1 in place of 1.0, 0.00001 and 1e-8 in place of 1e-05 and 1e-08
    found: list[str] = pa.array(numbers).cast(pa.string()).to_pylist()
    size = np.abs(numbers)
    whole = (size < 1e9) & (numbers == np.rint(numbers))
    for place in np.flatnonzero(whole).tolist():
        found[place] += ".0"
    alike = whole | ((size > 1e-99) & (size < 1e-9)) | ((size >= 1e-4) & (size < 1e9))
    other = np.flatnonzero(~alike)
    for place, one in zip(other.tolist(), numbers[other].tolist(), strict=True):
        found[place] = float.__repr__(one)
    return found


@lru_cache(maxsize=1024)
def _frame_pieces(
    frame: Frame, line: str, names: tuple[str, ...], shapes: tuple[Shape, ...], changing: bytes
) -> Sequence[Fixed]:
    """Return a frame in both forms, in pieces with gaps for its holes, and which text, or number, comes into each."""
    import numpy as np  # noqa: PLC0415 - see `_is_array`

    texts = sum(shape is None for shape in shapes)
    there = np.unpackbits(np.frombuffer(changing, dtype=np.uint8)).tolist()
    place, count = [*range(texts)], texts  # -1: a zero
    for one in there:
        place.append(count if one else -1)
        count += one
    found: list[Fixed] = []
    for between, order in _every_piece(frame, line, names, shapes):
        pieces, holes, start = list[str](), list[int](), 0
        for i, at in enumerate(order):
            if place[at] >= 0:
                pieces += "0.0".join(between[start : i + 1]), ""
                holes.append(place[at])
                start = i + 1
        found.append(([*pieces, "0.0".join(between[start:])], _picked(holes)))
    return found


def _picked(places: Sequence[int]) -> Pick:
    if len(places) > 1:
        return itemgetter(*places)
    return lambda every: [every[i] for i in places]


@lru_cache(maxsize=128)
def _every_piece(
    frame: Frame, line: str, names: tuple[str, ...], shapes: tuple[Shape, ...]
) -> Sequence[tuple[list[str], list[int]]]:
    """Return the same where all numbers change."""
    import numpy as np  # noqa: PLC0415 - see `_is_array`

    values: dict[str, object] = {}
    texts, count = 0, sum(shape is None for shape in shapes)
    for name, shape in zip(names, shapes, strict=True):
        if shape is None:
            values[name], texts = Hole(str(texts)), texts + 1
            continue
        cells = np.empty(math.prod(shape), dtype=object)
        cells[:] = [Hole(str(k)) for k in range(count, count + len(cells))]
        count += len(cells)
        values[name] = cells.reshape(shape).tolist()
    laid, canonical = _texts(_fill(frame.content, values), line, _Known())
    return [(_MARK.split(text)[::2], [*map(int, _MARK.findall(text))]) for text in (laid, canonical)]


def _texts_of_list(given: list[object] | tuple[object, ...], line: str, known: _Known) -> Texts:
    inner, kinds = line + " ", {*map(type, given)}
    if kinds == {str}:
        texts = [known.encoded[part][0] for part in given]  # type: ignore[index]
    elif kinds == {float}:
        texts = [*map(float.__repr__, given)]
        _check_finite(",".join(texts))
    elif kinds <= PLAIN.keys():
        texts = [PLAIN[type(part)](part) for part in given]
    else:
        parts = [_texts(part, inner, known) for part in given]
        laid = f",{inner}".join([text for text, _ in parts])
        return f"[{inner}{laid}{line}]", f"[{','.join([text for _, text in parts])}]"
    return f"[{inner}{f',{inner}'.join(texts)}{line}]", f"[{','.join(texts)}]"


def _is_array(given: object) -> TypeGuard[Array]:
    return type(given).__name__ == "ndarray"  # numpy need not be there for files without arrays
