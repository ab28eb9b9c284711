"""Numbers and texts that know where in the results they stand, so that a page can say so.

Every number on the page is ``<data value="all digits" data-at="pointer">rounded</data>``: the pointer is a JSON
pointer [1]_ into ``results.json``; those into other files begin with ``curves:``, ``model:`` or ``provenance:``. A
template is handed no other numbers, and the environment refuses to print a bare one.

Texts of the files are printed as ``<bdi>``, so that writing from right to left stays inside its place.

References
----------
.. [1] RFC 6901, JavaScript Object Notation (JSON) Pointer.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from markupsafe import Markup

from ..core.show.rounding import dof, number, with_uncertainty
from ..core.show.rounding import uncertainty as two_digits
from ..core.units import factor
from ..sensors.noise.fitting.noise_fit import duration

FEW = 3  # digits of a figure whose uncertainty does not stand beside it
PAIR = re.compile(r"\(?(?P<value>[^ )]+) ± (?P<u>[^ )]+)\)?(?P<decade>e[+-]\d+)?")

# Characters that have no place in a name: controls, embeddings and overrides of direction, halves of pairs.
UNPRINTABLE = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069\ud800-\udfff\ufffe\uffff]")


def clean(text: str) -> str:
    """Return text without what could steer a browser or a reader's eye: each such character is replaced."""
    return UNPRINTABLE.sub("\N{REPLACEMENT CHARACTER}", str(text))


class Text(str):
    """A text of the files; prints escaped and isolated. A ``str``, so that it compares and sorts as one."""

    __slots__ = ()

    def __html__(self) -> Markup:
        return Markup("<bdi>{}</bdi>").format(clean(self))


@dataclass(frozen=True)
class Number:
    """A number of the files.

    Parameters
    ----------
    raw : int or float
        As the file has it.
    at : str
        JSON pointer to it.
    """

    raw: float
    at: str

    def tag(self, shown: str) -> Markup:
        """Return the element that shows this number as a text."""
        return Markup('<data value="{}" data-at="{}">{}</data>').format(repr(self.raw), self.at, shown)

    @property
    def full(self) -> Markup:
        """With all its digits: the shortest text that reads back to the same bits."""
        return self.tag(self.text)

    @property
    def text(self) -> str:
        """All its digits, for an attribute."""
        return repr(self.raw)

    def __float__(self) -> float:
        return float(self.raw)

    def __html__(self) -> Markup:
        return self.tag(plain(self))


Leaf = Text | Number | bool | None


@dataclass(frozen=True)
class Branch:
    """An object of the files: a member by its key, each knowing its pointer; its own fields hide no key."""

    _content: Mapping[str, Any]
    _pointer: str

    def __getitem__(self, key: str) -> Any:
        return wrap(self._content[key], f"{self._pointer}/{_token(key)}")

    def get(self, key: str, default: Any = None) -> Any:
        """Return a member by its key, or what stands for one that is absent."""
        return self[key] if key in self._content else default

    def __contains__(self, key: object) -> bool:
        return key in self._content

    def __iter__(self) -> Iterator[str]:
        return (Text(key) for key in self._content)

    def __len__(self) -> int:
        return len(self._content)


def unwrapped(branch: Branch) -> Mapping[str, Any]:
    """Return an object as the file has it, its numbers without pointers."""
    return branch._content


def wrap(content: Any, at: str) -> Any:
    """Return content of a file so that each of its numbers carries its pointer.

    Parameters
    ----------
    content : dict, list, str, int, float, bool or None
        What ``json.loads`` gives.
    at : str
        Pointer to it: ``""`` for all of results.json, ``"model:"`` and ``"provenance:"`` for the others.

    Raises
    ------
    TypeError
        For anything else.
    """
    if content is None or isinstance(content, bool):
        return content
    if isinstance(content, str):
        return Text(content)
    if isinstance(content, int | float):
        return Number(content, at)
    if isinstance(content, Mapping):
        return Branch(content, at)
    if isinstance(content, Sequence):
        return [wrap(one, f"{at}/{i}") for i, one in enumerate(content)]
    raise TypeError(f"{at}: {type(content).__name__} is nothing that JSON holds")


def plain(value: Number) -> str:
    """Return a number as text: a count whole, else six significant digits."""
    return str(value.raw) if isinstance(value.raw, int) else number(value.raw)


def digits(value: Number | None, places: int = FEW) -> Markup | str:
    """Return a number with few significant digits, or a dash where it is absent."""
    return DASH if value is None else value.tag(number(value.raw, places))


def time(value: Number | None, unit: str) -> Markup | str:
    """Return a length of time in the unit that people would say it in: ``8 min``; a dash where it is absent."""
    return DASH if value is None else value.tag(duration(value.raw * factor(unit, "s")))


def rounded(value: Number | None, u: Number | None) -> Markup | str:
    """Return a value with as many digits as its standard uncertainty carries."""
    if value is None:
        return DASH
    return value.tag(_split(value, u)[0])


def uncertainty(value: Number | None, u: Number | None) -> Markup | str:
    """Return a standard uncertainty beside its value: two digits, in the decade of the value."""
    if u is None:
        return DASH
    shown = _split(value, u)[1] if value is not None else ""
    return u.tag(shown or two_digits(u.raw))


def alone(u: Number | None) -> Markup | str:
    """Return a standard uncertainty that stands without its value, or a dash."""
    return DASH if u is None else u.tag(two_digits(u.raw))


def freedom(value: Number) -> Markup:
    """Return degrees of freedom."""
    return value.tag(dof(value.raw))


def both(value: Number | None, u: Number | None) -> Markup | str:
    """Return ``value ± u``, or the value alone."""
    if value is None:
        return DASH
    shown, shown_u = _split(value, u)
    if u is None or not shown_u:
        return value.tag(shown)
    return Markup("{} ± {}").format(value.tag(shown), u.tag(shown_u))


DASH = "–"


def _split(value: Number, u: Number | None) -> tuple[str, str]:
    """Texts of value and uncertainty as core.rounding pairs them; each can be read as a number."""
    text = with_uncertainty(value.raw, None if u is None else u.raw)
    found = PAIR.fullmatch(text)
    if found is None:
        return text, ""
    decade = found["decade"] or ""
    return found["value"] + decade, found["u"] + decade


def _token(key: str) -> str:
    if "~" not in key and "/" not in key:
        return key
    return key.replace("~", "~0").replace("/", "~1")
