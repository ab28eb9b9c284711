"""JSON as files hold it: full digits, a level a blank, no NaN.

``json.dumps`` leaves its compiled encoder where it indents, and much of its time goes into digits. For files with
many numbers and a checksum over their canonical form, `json_texts` makes both in one pass, byte for byte the same. What
stands in several places is written once, and of an array the numbers alone that are not zero, into the text of zeros of
its shape: most of a model file is covariances, and most of these zeros.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Sequence
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
ZERO = "0.0"
WIDTH = len(ZERO)


class _Encoded(dict[str, Texts]):
    """Text in both forms, which are the same, each made once."""

    def __missing__(self, given: str) -> Texts:
        text = encode_basestring(given)
        self[given] = found = text, text
        return found


class Hole:
    """Where a value comes into a frame; numbers at any depth, all else at the first."""

    def __init__(self, name: str) -> None:
        self.name = name


class Frame:
    """A dict with holes, written once for each line that it stands on.

    Parameters
    ----------
    content : dict
        That does not change any more.
    """

    def __init__(self, content: dict[str, Any]) -> None:
        self.content = content
        self._texts: dict[str, Texts] = {}

    def texts(self, line: str) -> Texts:
        """Return it in both forms, as patterns of the values by the names of the holes."""
        if line not in self._texts:
            laid, canonical = (
                re.sub("\0([^\0]*)\0", r"%(\1)s", text.replace("%", "%%"))
                for text in _texts_of_dict(self.content, line, _Known())
            )
            self._texts[line] = laid, canonical
        return self._texts[line]


class Filled:
    """A frame with the values of its holes; it is written as the dict that it makes.

    Parameters
    ----------
    frame : Frame
        Shared by all that differ in these values alone.
    values : dict
        By the names of the holes.
    """

    def __init__(self, frame: Frame, values: dict[str, Any]) -> None:
        self.frame, self.values = frame, values

    @property
    def content(self) -> dict[str, Any]:
        """The dict."""
        return _fill(self.frame.content, self.values)


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
        found = _texts_of_frame(given, line, known)
    elif _is_array(given):
        found = _texts_of_array(given, line)
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


def _texts_of_frame(given: Filled, line: str, known: _Known) -> Texts:
    laid, canonical = given.frame.texts(line)
    inner = line + " "
    values = {name: _texts(part, inner, known) for name, part in given.values.items()}
    return laid % {name: text for name, (text, _) in values.items()}, canonical % {
        name: text for name, (_, text) in values.items()
    }


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


def _texts_of_array(given: Array, line: str) -> Texts:
    if given.dtype != float or not given.size:
        return _texts(given.tolist(), line, _Known())
    flat = given.ravel()
    at = flat.view("i8").nonzero()[0]  # -0.0 is no zero
    texts = [*map(float.__repr__, flat[at].tolist())]
    _check_finite("".join(texts))
    (laid, places), (canonical, theirs) = _zeros(given.shape, line)
    return _filled(laid, places[at].tolist(), texts), _filled(canonical, theirs[at].tolist(), texts)


def _filled(zeros: str, places: Sequence[int], texts: Sequence[str]) -> str:
    """Return a text of zeros with numbers in their places."""
    pieces = [""] * (2 * len(places) + 1)
    starts = [0, *[place + WIDTH for place in places]]
    pieces[::2] = [zeros[start:end] for start, end in zip(starts, [*places, len(zeros)], strict=True)]
    pieces[1::2] = texts
    return "".join(pieces)


@lru_cache(maxsize=64)
def _zeros(shape: tuple[int, ...], line: str) -> tuple[tuple[str, Array], tuple[str, Array]]:
    """Return an array of zeros in both forms, and where in the text each zero stands."""
    import numpy as np  # noqa: PLC0415 - see `_is_array`

    laid, canonical = (
        (text, np.array([one.start() for one in re.finditer(re.escape(ZERO), text)]))
        for text in _texts(np.zeros(shape).tolist(), line, _Known())
    )
    return laid, canonical
