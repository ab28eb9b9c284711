"""JSON as files hold it: full digits, a level a blank, no NaN.

``json.dumps`` leaves its compiled encoder where it indents, and much of its time goes into digits. For files with
many numbers and a checksum over their canonical form, `json_texts` makes both in one pass, byte for byte the same, and
a list of numbers that stands in several places is written once: model files take a third of the time.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from json.encoder import encode_basestring
from typing import Any


def _number(given: float) -> str:
    text = float.__repr__(given)
    _check_finite(text)
    return text


def _check_finite(text: str) -> None:
    if "n" in text:  # of nan and inf alone
        raise ValueError("JSON has no NaN and no infinity")


LISTS = (list, tuple)
FIXED = {None: "null", True: "true", False: "false"}
PLAIN: dict[type, Callable[[Any], str]] = {
    str: encode_basestring, float: _number, type(None): FIXED.__getitem__, bool: FIXED.__getitem__, int: int.__repr__,
}  # fmt: skip
Known = dict[tuple[int, str], tuple[str, str]]


def json_text(content: object) -> str:
    """Return JSON with one newline at its end.

    Raises
    ------
    ValueError
        If a number is not finite.
    """
    return json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def json_texts(content: object) -> tuple[str, str]:
    """Return a content as `json_text` without its newline, and in canonical form: keys sorted, no blanks.

    Raises
    ------
    ValueError
        If a number is not finite.
    TypeError
        For a key that is no text, and for what JSON has not.
    """
    return _texts(content, "\n", {})


def _texts(given: object, line: str, known: Known) -> tuple[str, str]:
    """Return a value in both forms.

    Parameters
    ----------
    line : str
        A newline, and the blanks before the value that it is in.
    known : dict
        Lists of numbers that were written, by identity and line.
    """
    kind = type(given)
    if isinstance(given, LISTS):
        return _texts_of_list(given, line, known) if given else ("[]", "[]")
    if isinstance(given, dict):
        return _texts_of_dict(given, line, known) if given else ("{}", "{}")
    write = PLAIN.get(kind) or next((PLAIN[one] for one in PLAIN if isinstance(given, one)), None)
    if write is None:
        raise TypeError(f"JSON has no {type(given).__name__}")
    text = write(given)
    return text, text


def _texts_of_dict(given: dict[str, object], line: str, known: Known) -> tuple[str, str]:
    inner, laid, canonical = line + " ", [], {}
    for name, part in given.items():
        key, write = encode_basestring(name), PLAIN.get(type(part))
        if write is None:
            text, plain = _texts(part, inner, known)
        else:
            text = plain = write(part)
        laid.append(f"{key}: {text}")
        canonical[name] = f"{key}:{plain}"
    ordered = ",".join([canonical[name] for name in sorted(canonical)])
    return f"{{{inner}{f',{inner}'.join(laid)}{line}}}", f"{{{ordered}}}"


def _texts_of_list(given: list[object] | tuple[object, ...], line: str, known: Known) -> tuple[str, str]:
    place = id(given), line
    if place in known:
        return known[place]
    inner = line + " "
    try:
        texts = [*map(float.__repr__, given)]
        _check_finite(",".join(texts))
    except TypeError:  # not floats alone
        writes = [*map(PLAIN.get, map(type, given))]
        if None in writes:
            parts = [known.get((id(part), inner)) or _texts(part, inner, known) for part in given]
            laid = f",{inner}".join([text for text, _ in parts])
            return f"[{inner}{laid}{line}]", f"[{','.join([text for _, text in parts])}]"
        texts = [write(part) for write, part in zip(writes, given, strict=True) if write]
    known[place] = found = f"[{inner}{f',{inner}'.join(texts)}{line}]", f"[{','.join(texts)}]"
    return found
