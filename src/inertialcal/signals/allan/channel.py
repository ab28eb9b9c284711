"""One channel: its deviations, degrees of freedom and noise types, and what is suspicious in it.

What is refused before any deviation is taken.

Curve of a record from those of its channels: in the unit of the result, with intervals and remarks.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...core.errors import DataError, PlanError
from ...core.estimate import Array, Numbers
from ...core.remarks import Remark
from ..names import Deviation, Quantity
from .deviations import KINDS, Kind, terms_of, variances
from .edf import BLUEST, believed_powers, bias_of, carried_on, identified_powers
from .edf import interval as interval_of
from .gaps import COMPLETE, dead_time_remark, missing_remark
from .noise_type import SMALL_ENOUGH, looked_at
from .prefix import LEVEL_FROM, QUANTITIES, give_back, phase_of
from .streamed import is_streamed, streamed_variances
from .total import total_variances

TELLING = 4  # averaging times at which the noise type should be told, or the record is short
WHITE = 0
BY_TIME = ("edf", "deviation", "terms", "power", "inflation", "ends")  # what channels have at each averaging time
CHANNELS = ("n", "deviation", "lo", "hi", "edf", "power", "inflation", "ends")  # the same, of a curve
FEW = 3  # channels that are named x, y, z where nobody says


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


def analyse_channel(
    x: Numbers,
    present: NDArray[np.bool_] | None,
    quantity: Quantity,
    kind: Kind,
    factors: NDArray[np.int64],
    noise: Literal["auto"] | int,
    name: str,
) -> Channel:
    """Return the deviations of one channel at averaging factors, rising, shape (k,).

    Raises
    ------
    DataError
        If no sample is there, or whole numbers are too large to be summed.
    """
    streamed = streamed_variances(x, kind, factors) if present is None and is_streamed(x, quantity, kind) else None
    missing = 0
    if streamed is not None:
        found, told = streamed
        power = believed_powers(told, kind)
    else:
        phase = phase_of(x, quantity, present)
        power = identified_powers(phase, kind, factors) if noise == "auto" else np.empty(len(factors))
        own = total_variances(x, phase, quantity, kind, factors) if kind.total else variances(phase, kind, factors)
        found, missing = own, phase.missing  # the phase is used up
        give_back(phase)
    power = power if noise == "auto" else np.full(len(factors), float(noise))
    identified = int(np.count_nonzero(np.isfinite(power)))
    power, edf = carried_on(power, kind, factors, found.terms)
    variance = found.variance
    if missing:
        variance = np.where(power >= WHITE, variance / found.inflation, variance)
    if kind.total:
        sizes = zip(factors.tolist(), found.terms.tolist(), power.astype(int).tolist(), strict=True)
        variance /= np.array([bias_of(kind, *one) for one in sizes])
    remarks: list[Remark] = []
    k, empty = len(factors), int(np.count_nonzero(found.terms == 0)) if missing else 0
    flat = not (variance > 0.0).any()
    if flat:
        power, edf = np.full((2, k), np.nan)
    if flat and empty < k:
        do = "Check the wiring and the resolution"
        remarks.append(Remark("constant", "warning", f"{name}: all samples are equal", do=do))
    else:
        if identified < min(TELLING, k):
            what = f"{name}: noise type identified at {identified} of {k} averaging times; the others are extrapolated"
            remarks.append(Remark("too_short", "warning", what, do="Record longer, or state the noise type"))
        without = int(np.count_nonzero(np.isnan(edf))) if kind.total else 0
        if without:
            what = (
                f"{name}: no interval at {without} of {k} averaging times: none is published for the {kind.words} in "
            )
            what += "noise bluer than white"
            remarks.append(Remark("no_interval", "info", what, do="Take a deviation without mirrors for intervals"))
        if empty:
            what = f"{name}: {empty} averaging time(s) left out: no two windows are half full"
            remarks.append(Remark("gaps_too_many", "warning", what, count=empty))
    return Channel(np.sqrt(variance), found.terms, found.inflation, edf, power, found.ends, missing, tuple(remarks))


def analyse_alike(series: Sequence[Array], kind: Kind, factors: NDArray[np.int64]) -> tuple[Channel, list[int]]:
    """Return the deviations of complete, short channels of one length, side by side, and which of them are sound.

    Only of those nothing is to be said, and all they are compared with is shared. The others are for `analyse_channel`.

    Parameters
    ----------
    series : sequence of ndarray, shape (n,)
        Rates, in float64.
    kind : Kind
        The overlapping Allan deviation.
    factors : ndarray of int64, shape (k,)
        Averaging factors, rising.

    Returns
    -------
    Channel
        Of all sound channels, arrays of shape (k, channels).
    sound : list of int
        Which they are.
    """
    from ._kernels import fill_octaves  # noqa: PLC0415 - starts slowly

    n = len(series[0])
    where, lost, known = looked_at(n + 1, factors.tobytes(), -kind.reddest // 2)
    sums, exponents, phase = *np.empty((2, len(series), len(factors))), np.empty(n + 1)
    step = max(1, n // LEVEL_FROM)
    whole = [
        fill_octaves(x, step, factors, where, lost, SMALL_ENOUGH, known, phase, own, exponent)
        for x, own, exponent in zip(series, sums, exponents, strict=True)
    ]
    told = where[:, 0] > 0
    good = np.array(whole) & (sums > 0.0).any(axis=1) & (np.isfinite(exponents) == told).all(axis=1)
    if np.count_nonzero(told) < min(TELLING, len(factors)):
        good[:] = False
    terms = terms_of(kind, n + 1, factors)
    power, edf = carried_on(believed_powers(exponents[good].T, kind), kind, factors, terms)
    deviation = np.sqrt(sums[good].T / (kind.divisor * terms * factors.astype(np.float64) ** 2)[:, None])
    ones = np.ones(deviation.shape)
    counts = np.broadcast_to(terms[:, None], deviation.shape)
    return Channel(deviation, counts, ones, edf, power, COMPLETE * ones, 0, ()), good.nonzero()[0].tolist()


def checked_kind(quantity: str, deviation: str, p: float, noise: Literal["auto"] | int) -> Kind:
    """Return the deviation asked for.

    Raises
    ------
    PlanError
        If quantity, deviation, probability or noise type is not among the possible ones.
    """
    if quantity not in QUANTITIES:
        raise PlanError(
            f"quantity {quantity!r}",
            why="rates, increments and their integral have different deviations, and numbers do not say which",
            do=f"There are: {', '.join(QUANTITIES)}",
            code="wrong_quantity",
        )
    if deviation not in KINDS:
        raise PlanError(f"deviation {deviation!r}", do=f"There are: {', '.join(KINDS)}", code="wrong_deviation")
    if not 0.0 < p < 1.0:
        raise PlanError(
            f"probability {p}", do="Need more than 0 and less than 1, such as 0.95", code="wrong_probability"
        )
    kind = KINDS[deviation]
    if noise != "auto" and not (isinstance(noise, int | np.integer) and kind.reddest <= noise <= BLUEST):
        raise PlanError(
            f"noise type {noise!r} for the {kind.words}",
            do=f"Need 'auto' or an exponent from {kind.reddest} to {BLUEST}",
            code="wrong_noise",
        )
    return kind


def checked_samples(x: ArrayLike, interval: float, scale: float) -> Numbers:
    """Return samples as an array, shape (n, axes), in their type.

    Raises
    ------
    DataError
        If they are no real numbers or have another shape, or interval or scale are not positive and finite.
    """
    for name, value in (("sample interval", interval), ("scale", scale)):
        if not (np.isfinite(value) and value > 0.0):
            raise DataError(f"a {name} of {value}", do="It must be positive", code="wrong_interval")
    samples = np.asarray(x)
    if samples.dtype.kind not in "iuf":
        raise DataError(f"samples of type {samples.dtype}", do="Need real numbers", code="wrong_type")
    if samples.dtype == np.float16:  # compiled loops know none
        samples = samples.astype(np.float32)
    if samples.dtype == np.uint64 and samples.size and samples.max() <= np.iinfo(np.int64).max:
        samples = samples.astype(np.int64)  # compiled loops take a float for the difference of the two
    if samples.ndim not in {1, 2} or not samples.size:
        raise DataError(f"samples of shape {samples.shape}", do="Need (n,) or (n, axes), not empty", code="wrong_shape")
    return samples[:, None] if samples.ndim == 1 else samples


def checked_present(present: NDArray[np.bool_] | None, samples: Numbers) -> NDArray[np.bool_] | None:
    """Return which samples are there, shape (n, axes).

    Raises
    ------
    DataError
        If the shape is another one.
    """
    if present is None:
        return None
    there = np.asarray(present, dtype=bool)
    if there.shape not in {samples.shape, (len(samples),), (len(samples), 1)}:
        raise DataError(f"present of shape {there.shape} for samples of shape {samples.shape}", code="wrong_shape")
    return np.broadcast_to(there if there.ndim == 2 else there[:, None], samples.shape)


def checked_names(names: tuple[str, ...] | None, axes: int) -> tuple[str, ...]:
    """Return the names of the channels: x, y, z, or numbers, where nobody says.

    Raises
    ------
    PlanError
        If there are more or fewer.
    """
    if names is None:
        return tuple("xyz"[:axes]) if axes <= FEW else tuple(str(i) for i in range(axes))
    if len(names) != axes:
        raise PlanError(f"{len(names)} name(s) for {axes} channel(s)", code="wrong_names")
    return tuple(names)


def joined(
    columns: Sequence[Channel],
    m: NDArray[np.int64],
    samples: int,
    interval: float,
    averaging: float | None,
    kind: Deviation,
    quantity: Quantity,
    names: tuple[str, ...],
    unit: str,
    *,
    scale: float,
    p: float,
    remarks: tuple[Remark, ...],
) -> Allan:
    """Return the curve of channels side by side; parameters are those of `Allan`, and the scale of `allan`.

    Parameters
    ----------
    columns : sequence of Channel
        Found at the averaging factors ``m``.
    remarks : tuple of Remark
        On the averaging times.
    """
    if len(columns) == 1:
        beside = {name: vars(columns[0])[name] for name in BY_TIME}
        beside = {name: own[:, None] if own.ndim == 1 else own for name, own in beside.items()}
    else:
        beside = {name: np.array([getattr(one, name) for one in columns]).T for name in BY_TIME}
    edf, found = beside["edf"], beside["deviation"] * (scale if quantity == "rate" else scale / interval)
    lo, hi = interval_of(found, edf, p)
    missing = np.array([one.missing for one in columns], dtype=np.int64)
    missing = missing if len(columns) > 1 else np.repeat(missing, found.shape[1])
    remarks += dead_time_remark(interval, averaging) + missing_remark(missing, samples, names)
    return Allan(
        tau=m.astype(np.float64) * interval,
        m=m,
        n=beside["terms"],
        deviation=found,
        lo=lo,
        hi=hi,
        edf=edf,
        power=beside["power"],
        inflation=beside["inflation"],
        ends=beside["ends"],
        p=p,
        interval=interval,
        averaging=averaging,
        samples=samples,
        missing=missing,
        kind=kind,
        quantity=quantity,
        names=names,
        unit=unit,
        remarks=remarks + tuple(remark for one in columns for remark in one.remarks),
    )


@dataclass(frozen=True, eq=False)
class Allan:
    """Deviations of one or several channels."""

    tau: Array  # averaging time [s]: averaging factor times sample interval, shape (k,)
    m: NDArray[np.int64]  # averaging factor [samples], shape (k,)
    n: NDArray[np.int64]  # terms behind each deviation, shape (k, axes)
    # deviation, lo, hi: deviation of the rate, and the ends of its interval, in ``unit``; NaN where no term is there,
    # ends also where a channel is constant, shape (k, axes)
    deviation: Array
    lo: Array
    hi: Array
    edf: Array  # equivalent degrees of freedom, shape (k, axes)
    # exponent of the noise around each averaging time: 2 quantisation, 0 white, -1 flicker, -2 random walk, shape (k,
    # axes)
    power: Array
    # by how much missing samples raise the variance of white noise; divided out where ``power`` is 0 or more, shape (k,
    # axes)
    inflation: Array
    # sum of the squared weights that errors of the integrated signal have in a term, over 2 / m^2: 3 of a complete
    # record, more where gaps leave ends of stretches inside of windows. Of the Allan deviations; else 3, shape (k,
    # axes)
    ends: Array
    p: float  # probability of the intervals
    interval: float  # from sample to sample [s]
    averaging: float | None  # what each sample is the mean of [s]; None when nobody said
    samples: int  # length of the record
    missing: NDArray[np.int64]  # samples that are not there, shape (axes,)
    kind: Deviation  # which deviation
    quantity: Quantity  # what the samples were
    names: tuple[str, ...]  # one a channel
    unit: str = ""  # of the deviation; empty when nobody said
    remarks: tuple[Remark, ...] = ()  # what is suspicious

    def __len__(self) -> int:
        return len(self.tau)

    def apart(self) -> list[Allan]:
        """Return the curve of each channel by itself; each with the remarks of all."""
        shared = vars(self)
        arrays = [(name, shared[name]) for name in (*CHANNELS, "missing")]
        found = []
        for i, name in enumerate(self.names):
            own = {key: value[..., i : i + 1] for key, value in arrays}
            found.append(Allan(**{**shared, **own, "names": (name,)}))
        return found

    @property
    def variance(self) -> Array:
        """Square of the deviation, shape (k, axes)."""
        return self.deviation**2
