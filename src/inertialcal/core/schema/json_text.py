"""JSON as files hold it: full digits, a level a blank, no NaN.

``json.dumps`` leaves its compiled encoder where it indents, and much of its time goes into digits. For files with
many numbers and a checksum over their canonical form, `json_texts` makes both in one pass, byte for byte the same. What
stands in several places is written once, and of the arrays of a frame the numbers alone that are not zero: most of a
model file is covariances, most of these zeros, and in the same places in many units.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Sequence, Set
from functools import lru_cache
from json.encoder import encode_basestring
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
        By the names of the holes: numbers, None, and arrays of float64.
    """

    def __init__(self, frame: Frame, values: dict[str, Array | float | None]) -> None:
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


class _Known:
    """What was written: lists and dicts by identity and line, as long as these are held; and text."""

    def __init__(self) -> None:
        self.texts: dict[tuple[int, str], Texts] = {}
        self.encoded = _Encoded()


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
    return _texts(content, "\n", _Known())


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
        found = _texts_of_frame(given, line)
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
Pattern = tuple[tuple[str, tuple[int, ...] | None, bytes, bytes], ...]


def _texts_of_frame(given: Filled, line: str) -> Texts:
    """Write the numbers that are not zero into the text of all frames that have zeros in the same places."""
    numbers: list[float] = []
    pattern: list[tuple[str, tuple[int, ...] | None, bytes, bytes]] = []
    for name, part in given.values.items():
        if _is_array(part):
            flat = part.ravel()
            at = flat.view("i8").nonzero()[0]  # -0.0 is no zero
            own = flat[at]
            nulls = b""
            if name in given.frame.endless:
                endless = own == math.inf
                own, nulls = own[~endless], endless.tobytes()
            pattern.append((name, part.shape, at.tobytes(), nulls))
            numbers += own.tolist()
        elif part:
            pattern.append((name, (), b"", b""))
            numbers.append(float(part))
        else:
            pattern.append((name, None, repr(part).encode(), b""))
    every = [*dict.fromkeys(numbers)]  # a covariance has most of its numbers twice
    known = dict(zip(every, map(float.__repr__, every), strict=True))
    texts = [known[one] for one in numbers]
    _check_finite("".join(texts))
    forms = []
    for fixed, order in _pattern_texts(given.frame, line, tuple(pattern)):
        pieces = [""] * (2 * len(order) + 1)
        pieces[::2] = fixed
        pieces[1::2] = [texts[i] for i in order]
        forms.append("".join(pieces))
    return forms[0], forms[1]


@lru_cache(maxsize=1024)
def _pattern_texts(frame: Frame, line: str, pattern: Pattern) -> Sequence[tuple[list[str], list[int]]]:
    """Return a frame in both forms, in pieces between its numbers, and which number comes into each gap."""
    import numpy as np  # noqa: PLC0415 - see `_is_array`

    values: dict[str, object] = {}
    count = 0
    for name, shape, at, endless in pattern:
        if shape is None:
            values[name] = None if at == b"None" else float(at)
            continue
        cells: list[object] = [0.0] * math.prod(shape)
        nulls = np.frombuffer(endless, dtype=bool).tolist() if endless else []
        for k, place in enumerate(np.frombuffer(at, dtype=np.intp).tolist() if shape else [0]):
            if nulls and nulls[k]:
                cells[place] = None
            else:
                cells[place] = Hole(str(count))
                count += 1
        for size in reversed(shape[1:]):
            cells = [cells[i : i + size] for i in range(0, len(cells), size)]
        values[name] = cells if shape else cells[0]
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
