"""What was found of some samples before: a function that is called with the same ones again returns the same.

Who calibrates looks at one recording many times: with other settings, by another test, in the next cell of a notebook.
What its samples show as such does not change. Arguments are compared by a digest of what they hold, not by which object
they are: an array that was changed in place is another one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import is_dataclass
from functools import wraps
from hashlib import sha1
from threading import Lock
from typing import Any, ParamSpec, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..core.batches import is_stored
from .at_hand import Choice

P = ParamSpec("P")
R = TypeVar("R")

LONGEST = 2**22  # bytes of the arrays of a call: a digest of more takes longer than it may save
ONCE = 2**16  # where each recording is looked at once, and short arrays alone come again: rates of a table, a ramp
SHORT, FEW = 512, 1_000  # numbers, and calls, beyond which a compiled loop pays
MOST = 128  # results that are kept of a function, those of the last calls
PLAIN = frozenset({np.ndarray, np.float64, np.int64, str, float, int, bool, type(None)})
_kept: list[dict[bytes, object]] = []  # of each function
_longest: ContextVar[int] = ContextVar("longest", default=LONGEST)


def remembered(function: Callable[P, R]) -> Callable[P, R]:
    """Let a function keep what it returned last; its arrays are read-only, as all callers share them.

    Parameters
    ----------
    function : callable
        Of arrays, numbers, texts, and of sequences and dataclasses of these; it reads nothing else. What it returns
        holds no array that it was given.

    Returns
    -------
    callable
        The same, of short arrays only looked up where it was called with equal arguments before.

    Examples
    --------
    >>> calls = []
    >>> @remembered
    ... def largest(x):
    ...     calls.append(len(x))
    ...     return float(x.max())
    >>> x = np.arange(3.0)
    >>> largest(x), largest(x.copy()), calls
    (2.0, 2.0, [3])
    >>> x[0] = 5.0
    >>> largest(x), calls
    (5.0, [3, 3])
    """
    known: dict[bytes, R] = {}
    _kept.append(known)  # type: ignore[arg-type]
    lock = Lock()

    @wraps(function)
    def again(*args: P.args, **kwargs: P.kwargs) -> R:
        if _room_of(args) > _longest.get():
            return _read_only(function(*args, **kwargs))
        parts = _parts((args, kwargs))
        arrays = [one for one in parts if isinstance(one, np.ndarray)]
        long = sum(one.nbytes for one in arrays) > _longest.get()
        if long or any(is_stored(one) or one.dtype.hasobject for one in arrays):
            return _read_only(function(*args, **kwargs))
        key = _digest(parts)
        with lock:
            if key in known:
                known[key] = known.pop(key)  # the last in order
                return known[key]
        found = _read_only(function(*args, **kwargs))
        with lock:
            known[key] = found
            if len(known) > MOST:
                del known[next(iter(known))]
        return found

    return again


@contextmanager
def looked_at_once() -> Iterator[None]:
    """Look up what short arrays show alone meanwhile: no recording comes again."""
    before = _longest.set(ONCE)
    try:
        yield
    finally:
        _longest.reset(before)


def forget() -> None:
    """Let go of all that is remembered."""
    for known in _kept:
        known.clear()


class Loops:
    """The loop of ``_kernels`` where that takes too long to load."""

    @staticmethod
    def fill_mixed(words: NDArray[np.uint64], lanes: NDArray[np.uint64]) -> bool:
        """Return that nothing is filled: the words themselves are digested."""
        return False


def _compiled() -> object:
    from . import _kernels  # noqa: PLC0415 - starts slowly

    return _kernels


loops_for = Choice(Loops, _compiled, LONGEST, FEW)


def _content(x: NDArray[Any]) -> NDArray[Any]:
    """Return an array, shape (n,), or eight words that all of it is mixed into."""
    lanes = np.zeros(8, dtype=np.uint64)
    if x.dtype.itemsize != lanes.itemsize or not x.flags.aligned or len(x) < SHORT:
        return x
    return lanes if loops_for(len(x)).fill_mixed(x.view(np.uint64), lanes) else x


def _room_of(args: tuple[object, ...]) -> int:
    """Return the bytes of the arrays that are given one by one or in lists."""
    total = 0
    for one in args:
        for part in one if type(one) is list else (one,):
            if type(part) is np.ndarray:
                total += part.nbytes
    return total


def _parts(given: object) -> list[object]:
    """Return what sequences, dictionaries and dataclasses hold, one after the other, with a mark where each ends."""
    kind = type(given)
    if kind in PLAIN:
        return [given]
    if is_dataclass(given):
        given = vars(given)
    if isinstance(given, dict):
        given = tuple(given.items())
    if isinstance(given, list | tuple):
        parts: list[object] = []
        for one in given:
            if type(one) in PLAIN:
                parts.append(one)
            else:
                parts += _parts(one)
        parts.append(kind)
        return parts
    if not isinstance(given, np.ndarray | np.generic | str | float | int):
        raise TypeError(f"{kind.__name__}: nothing that is compared by what it holds")
    return [given]


def _read_only(found: R) -> R:
    """Return what was found; nothing can be written into its arrays any more."""
    within: list[object] = [found]
    while within:
        one = within.pop()
        if isinstance(one, np.ndarray):
            one.flags.writeable = False
        elif is_dataclass(one):
            within += vars(one).values()
        elif isinstance(one, dict):
            within += one.values()
        elif isinstance(one, list | tuple):
            within += one
    return found


def _digest(parts: list[object]) -> bytes:
    digest = sha1(usedforsecurity=False)  # takes half the time of sha256
    said = ""
    for one in parts:
        if isinstance(one, np.ndarray):
            said += f"{one.dtype.str}{one.shape}"
            digest.update(_content(np.ascontiguousarray(one).reshape(-1)).view(np.uint8).data)
        else:
            said += f"{one!r};"
    digest.update(said.encode())
    return digest.digest()
