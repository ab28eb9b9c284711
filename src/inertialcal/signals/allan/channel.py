"""One channel: its deviations, degrees of freedom and noise types, and what is suspicious in it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array, Numbers
from ...core.remarks import Remark
from ..codes import is_stuck, levels_of, longest_run, rails
from ..names import Quantity
from .deviations import Kind, variances
from .noise_type import carried_on, identified_powers
from .prefix import give_back, phase_of

TELLING = 4  # averaging times at which the noise type should be told, or the record is short
WHITE = 0


@dataclass(frozen=True, eq=False)
class Channel:
    """What is found of one channel, arrays of shape (k,); the deviation is in units of the samples an interval."""

    deviation: Array
    terms: NDArray[np.int64]
    inflation: Array
    edf: Array
    power: Array
    ends: Array
    missing: int
    remarks: tuple[Remark, ...]


def of_channel(
    x: Numbers,
    present: NDArray[np.bool_] | None,
    quantity: Quantity,
    kind: Kind,
    factors: NDArray[np.int64],
    noise: Literal["auto"] | int,
    name: str,
) -> Channel:
    """Return the deviations of one channel.

    Parameters
    ----------
    x : ndarray, shape (n,)
        Samples.
    present : ndarray of bool, shape (n,), or None
        Which are there.
    quantity : {"rate", "increment", "angle"}
        What they are.
    kind : Kind
        Which deviation.
    factors : ndarray of int64, shape (k,)
        Averaging factors, rising.
    noise : "auto" or int
        Exponent of the noise.
    name : str
        Of the channel, for remarks.

    Raises
    ------
    DataError
        If no sample is there, or whole numbers are too large to be summed.
    """
    phase = phase_of(x, quantity, present)
    power = identified_powers(phase, kind, factors) if noise == "auto" else np.full(len(factors), float(noise))
    told = int(np.count_nonzero(np.isfinite(power)))
    found = variances(phase, kind, factors)  # uses the phase up
    give_back(phase)
    power, edf = carried_on(power, kind, factors, found.terms)
    variance = np.where(power >= WHITE, found.variance / found.inflation, found.variance)
    flat = not np.any(variance > 0.0)
    remarks = _remarks(flat, found.terms, told, len(factors), name)
    if flat:
        power, edf = np.full((2, len(factors)), np.nan)
    return Channel(np.sqrt(variance), found.terms, found.inflation, edf, power, found.ends, phase.missing, remarks)


def _remarks(flat: bool, terms: NDArray[np.int64], told: int, k: int, name: str) -> tuple[Remark, ...]:
    if flat and terms.any():
        do = "Look at the wiring and at the resolution; there is no noise to be told"
        return (Remark("constant", "warning", f"{name}: all samples are equal", do=do),)
    found: tuple[Remark, ...] = ()
    if told < min(TELLING, k):
        what = f"{name}: the noise type can be told at {told} of {k} averaging times; the others follow them"
        found = (Remark("too_short", "warning", what, do="Record longer, or say the noise type"),)
    empty = int(np.count_nonzero(terms == 0))
    if empty:
        what = f"{name}: {empty} averaging time(s) have no pair of windows that are half filled"
        found = (*found, Remark("gaps_too_many", "warning", what, count=empty))
    return found


def code_remarks(x: Numbers, name: str) -> tuple[Remark, ...]:
    """Return what the codes of a channel say: stuck for long, or piled up at the ends of the range.

    Takes longer than the deviations themselves, and is left to who reads the file.

    Parameters
    ----------
    x : ndarray, shape (n,)
        Samples; those that are not finite are left out.
    name : str
        Of the channel.
    """
    finite = x[np.isfinite(x)]
    if len(finite) < 2 or np.all(finite == finite[0]):
        return ()
    found = []
    if is_stuck(finite):
        run = longest_run(finite)
        what = f"{name}: one value is repeated far too long: {run.value:g}, {run.length} times on end"
        found.append(Remark("stuck", "warning", what, do="Leave the stretch out: it has no noise"))
        finite = np.delete(finite, slice(run.start, run.start + run.length))
    for rail in rails(levels_of(finite)):
        what = f"{name}: samples lie at the end of the range, {rail.value:g}"
        do = "Saturated samples hide noise: change the range"
        found.append(Remark("saturated", "warning", what, count=rail.count, do=do))
    return tuple(found)
