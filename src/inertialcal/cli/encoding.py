"""Text for people in any encoding: a character that it lacks is written as the nearest ASCII."""

from __future__ import annotations

import codecs

NEAREST = "inertialcal.nearest"  # Name of the error handler
ASCII = {
    "±": "+/-", "°": "deg", "º": "deg", "˚": "deg", "µ": "u", "μ": "u", "√": "sqrt", "Ω": "ohm", "σ": "sigma",
    "→": "->", "←": "<-", "×": "x", "·": "*", "⋅": "*", "∙": "*", "•": "*", "∕": "/", "⁄": "/", "≤": "<=", "≥": ">=",
    "≠": "!=", "≈": "~", "∞": "inf", "−": "-", "–": "-", "—": "-", "‐": "-", "‑": "-", "⁻": "-", "⁺": "+",
    "‘": "'", "’": "'", "“": '"', "”": '"', "━": "-", "╸": "-", "╺": "-", "✓": "+", "✗": "x",
}  # fmt: skip


def nearest(error: UnicodeError) -> tuple[str, int]:
    """Return ASCII for the characters that an encoding lacks: an error handler of ``codecs``.

    Examples
    --------
    >>> codecs.register_error(NEAREST, nearest)
    >>> "(1.0 ± 0.2) µg/√Hz, 3 °/s², é".encode("ascii", NEAREST)
    b'(1.0 +/- 0.2) ug/sqrtHz, 3 deg/s2, e'
    """
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return "".join(map(_nearest, error.object[error.start : error.end])), error.end


def _nearest(character: str) -> str:
    import unicodedata

    base = unicodedata.normalize("NFKD", character)[0]
    return ASCII.get(character) or ASCII.get(base) or (base if base.isascii() and base.isprintable() else "?")


def json_text(content: object, encoding: str) -> str:
    """Return JSON that is valid in an encoding: other than in UTF-8, escaped to ASCII.

    Bytes of a file name that are no UTF-8 become U+FFFD: half a surrogate pair is no JSON for many readers.
    """
    import json
    import re

    text = json.dumps(content, ensure_ascii=False, allow_nan=False)
    text = re.sub("[\ud800-\udfff]", "\ufffd", text)
    if codecs.lookup(encoding).name == "utf-8":
        return text
    return re.sub(r"[^\x00-\x7f]+", lambda found: json.dumps(found[0])[1:-1], text)
