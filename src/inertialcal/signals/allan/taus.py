"""Averaging times: whole numbers of samples, from words, from averaging factors, or from seconds.

Words go up to the longest averaging time at which a record holds one window more than a term spans: a third of it for
the Allan deviation, a quarter for the others. A list goes as far as there is one term.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ...core.errors import DataError, PlanError
from ...core.remarks import Remark
from .deviations import Kind, terms_of

WORDS = ("octave", "decade", "all")
DECADE = (1, 2, 4)  # of each decade, as Stable32 has them
OFF = 1e-3  # samples that an averaging time may lie off a whole number of them without a remark

Taus = str | Sequence[float] | NDArray[np.floating]
Factors = Sequence[int] | NDArray[np.integer]


def factors_of(
    kind: Kind, points: int, interval: float, taus: Taus = "octave", factors: Factors | None = None
) -> tuple[NDArray[np.int64], tuple[Remark, ...]]:
    """Return the averaging factors, rising, and what was changed of those asked for.

    Parameters
    ----------
    kind : Kind
        Which deviation.
    points : int
        Phase points of the record.
    interval : float
        From sample to sample [s].
    taus : {"octave", "decade", "all"} or sequence of float
        Averaging times: 1, 2, 4, 8, ... or 1, 2, 4, 10, 20, 40, ... samples, every number of them, or a list [s].
    factors : sequence of int, optional
        Averaging times in samples, in place of ``taus``.

    Raises
    ------
    DataError
        If the record is too short for a single term.
    PlanError
        If a word is not known, a list is empty or holds what is no averaging time, or both are given.
    """
    if terms_of(kind, points, np.array([1]))[0] < 1:
        raise DataError(
            f"a record of {points - 1} sample(s)",
            why=f"one term of the {kind.words} spans {kind.windows}",
            do="Record longer",
            code="too_short",
        )
    if factors is not None:
        if not (isinstance(taus, str) and taus == "octave"):
            raise PlanError("both averaging times and averaging factors given", do="Give one", code="wrong_taus")
        return _possible(kind, points, interval, np.asarray(factors), ())
    if isinstance(taus, str):
        return _factors_of_word(taus, max(1, (points - 1) // (kind.windows + 1))), ()
    seconds = np.asarray(taus, dtype=np.float64)
    near = np.rint(seconds / interval)
    return _possible(kind, points, interval, near, _rounded(seconds, near, interval))


def _factors_of_word(word: str, longest: int) -> NDArray[np.int64]:
    if word == "octave":
        return 2 ** np.arange(longest.bit_length())
    if word == "all":
        return np.arange(1, longest + 1)
    if word == "decade":
        every = np.array([first * 10**k for k in range(len(str(longest))) for first in DECADE])
        return every[every <= longest]
    raise PlanError(
        f"averaging times {word!r}", do=f"There are: {', '.join(WORDS)}, or a list in seconds", code="wrong_taus"
    )


def _rounded(seconds: NDArray[np.float64], near: NDArray[np.float64], interval: float) -> tuple[Remark, ...]:
    off = np.abs(seconds / interval - near) > OFF
    if not off.any():
        return ()
    first = int(np.argmax(off))
    what = f"averaging time {seconds[first]:g} s taken as {near[first] * interval:g} s, whole samples of {interval:g} s"
    return (Remark("tau_rounded", "info", what, count=int(np.count_nonzero(off))),)


def _possible(
    kind: Kind, points: int, interval: float, wanted: NDArray[np.generic], remarks: tuple[Remark, ...]
) -> tuple[NDArray[np.int64], tuple[Remark, ...]]:
    """Return the wanted factors in order, each once, without those for which the record is too short."""
    numbers = wanted.astype(np.float64)
    if numbers.ndim != 1 or not len(numbers) or not np.all((numbers >= 1.0) & (numbers == np.rint(numbers))):
        raise PlanError(
            f"averaging times of {_few(wanted)} samples of {interval:g} s",
            do="Need a list of whole numbers of samples, 1 or more",
            code="wrong_taus",
        )
    unique = np.unique(numbers)
    there = unique <= points
    there[there] = terms_of(kind, points, unique[there].astype(np.int64)) >= 1
    if not there.any():
        raise DataError(
            f"no averaging time up to {unique[0] * interval:g} s fits into a record of {(points - 1) * interval:g} s",
            why=f"one term of the {kind.words} spans {kind.windows} of them",
            do="Record longer, or ask for shorter ones",
            code="too_short",
        )
    if not there.all():
        what = f"averaging time {unique[~there][0] * interval:g} s needs a longer record: left out"
        remarks = (*remarks, Remark("tau_too_long", "warning", what, count=int(np.count_nonzero(~there))))
    return unique[there].astype(np.int64), remarks


def _few(wanted: NDArray[np.generic]) -> str:
    listed = [f"{value}" for value in np.ravel(wanted)[:4]]
    return ", ".join([*listed, "..."] if wanted.size > len(listed) else listed) or "no"
