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


class _Encoded(dict[str, str]):
    """Text as JSON has it, each once."""

    def __missing__(self, given: str) -> str:
        self[given] = found = encode_basestring(given)
        return found


LISTS = (list, tuple)
FIXED = {None: "null", True: "true", False: "false"}
PLAIN: dict[type, Callable[[Any], str]] = {
    str: encode_basestring, float: _number, type(None): FIXED.__getitem__, bool: FIXED.__getitem__, int: int.__repr__,
}  # fmt: skip
Texts = tuple[str, str]  # As files hold it; canonical
ZERO = "0.0"


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
    place = id(given), line
    if place in known.texts:
        return known.texts[place]
    if isinstance(given, LISTS):
        found = _texts_of_list(given, line, known) if given else ("[]", "[]")
    elif isinstance(given, dict):
        found = _texts_of_dict(given, line, known) if given else ("{}", "{}")
    elif _is_array(given):
        return _texts_of_array(given, line)
    else:
        write = PLAIN.get(type(given)) or next((PLAIN[one] for one in PLAIN if isinstance(given, one)), None)
        if write is None:
            raise TypeError(f"JSON has no {type(given).__name__}")
        text = write(given)
        return text, text
    known.texts[place] = found
    return found


def _texts_of_dict(given: dict[str, object], line: str, known: _Known) -> Texts:
    inner, laid, canonical, encoded = line + " ", [], {}, known.encoded
    for name, part in given.items():
        key, kind = encoded[name], type(part)
        if kind is str:
            text = plain = encoded[part]  # type: ignore[index]
        elif kind in PLAIN:
            text = plain = PLAIN[kind](part)
        else:
            text, plain = _texts(part, inner, known)
        laid.append(f"{key}: {text}")
        canonical[name] = f"{key}:{plain}"
    ordered = ",".join([canonical[name] for name in sorted(canonical)])
    return f"{{{inner}{f',{inner}'.join(laid)}{line}}}", f"{{{ordered}}}"


def _texts_of_list(given: list[object] | tuple[object, ...], line: str, known: _Known) -> Texts:
    inner = line + " "
    try:
        texts = [*map(float.__repr__, given)]
        _check_finite(",".join(texts))
    except TypeError:  # not floats alone
        writes = [*map(PLAIN.get, map(type, given))]
        if None in writes:
            parts = [_texts(part, inner, known) for part in given]
            laid = f",{inner}".join([text for text, _ in parts])
            return f"[{inner}{laid}{line}]", f"[{','.join([text for _, text in parts])}]"
        texts = [write(part) for write, part in zip(writes, given, strict=True) if write]
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
    starts = [0, *[place + len(ZERO) for place in places]]
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
