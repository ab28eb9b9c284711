"""From counts to outputs and readings: the signal chain applied, with what is not valid marked and counted.

The equation stands in ``sensors.chain``. A code below or above the converter is refused: the file or the campaign
is wrong. A code at either end is a rail: the input may lie beyond, so the reading is left out, and counted. So
are readings while the built-in test is low. Means of codes (not whole numbers) are codes too.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...core.errors import DataError, PlanError
from ...core.estimate import Array
from ...core.remarks import Remark
from .converter import Chain, missing_channel, nonzero, wide, zero_at_gains

Mask = NDArray[np.bool_]
Place = Callable[[int], str]
Ends = tuple[int, int] | None


@dataclass(frozen=True, eq=False)
class Converted:
    """What a chain makes of codes; all arrays of shape (n, k)."""

    output: Array  # v [output unit]; NaN where not valid
    readings: Array | None  # r [input unit]; NaN where not valid; None without a scale factor
    temperature: Array | None  # [degC]; NaN where its own channel or the reference is at a rail or missing
    valid: Mask  # False at rails, where a code is missing, while the built-in test is low
    remarks: tuple[Remark, ...] = ()  # The same, counted


def sample(index: int) -> str:
    """Place of a reading where there is no file."""
    return f"sample {index}"


def convert(
    chain: Chain,
    counts: ArrayLike,
    *,
    reference: ArrayLike | None = None,
    temperature: ArrayLike | None = None,
    temperature_reference: ArrayLike | None = None,
    validity: ArrayLike | None = None,
    gain: ArrayLike | None = None,
    place: Place = sample,
) -> Converted:
    """Return outputs and readings of codes, with what is not valid marked and counted.

    Parameters
    ----------
    counts : array_like, shape (n, k)
        Codes, or means of codes; NaN where missing.
    reference, temperature, validity : array_like, shape (n,) or (n, k), optional
        Codes of the reference voltage, of the temperature channel and of the built-in test.
    temperature_reference : array_like, shape (n,) or (n, k), optional
        Codes of the reference voltage of the temperature channel, where it has one of its own.
    gain : array_like, shape (n,) or (n, k), optional
        Over time; instead of the chain's.
    place : callable
        Index of a sample -> ``"file:row"``, for messages.

    Raises
    ------
    DataError
        ``code_outside``; ``missing_reference``, ``missing_temperature`` or ``missing_validity`` where the chain
        needs a channel that is not there; ``never_valid`` where the built-in test is low throughout.
    PlanError
        If the gain over time is zero somewhere.
    """
    k = len(chain.axes)
    signal = wide("counts", counts, k)
    others = {
        "reference": reference,
        "temperature": temperature,
        "temperature_reference": temperature_reference,
        "validity": validity,
    }
    channels = {name: wide(name, codes, k, len(signal)) for name, codes in others.items() if codes is not None}
    channels["counts"] = signal
    if chain.reference == "channel" and "reference" not in channels:
        raise missing_channel(chain, "reference", "it is subtracted from the signal sample by sample")
    if chain.validity_minimum is not None and "validity" not in channels:
        raise missing_channel(chain, "validity", "readings while the built-in test is low are left out")
    if chain.validity_minimum is None and "validity" in channels:
        raise PlanError("built-in test given, but no validity_minimum", do="Give the lowest good voltage [V]")
    volts, remarks = _volts(chain, channels, place)
    above = volts.get("reference", np.asarray(0.0 if chain.reference == "channel" else chain.reference))
    degrees = None
    if chain.thermometer is not None and "temperature" in volts:
        if chain.thermometer.own_reference and "temperature_reference" not in volts:
            raise missing_channel(chain, "temperature_reference", "the temperature was read against its own reference")
        degrees = chain.thermometer.degrees(volts["temperature"] - volts.get("temperature_reference", above))
    over_time = None if gain is None else nonzero("gain", wide("gain", gain, k, len(signal)), k)
    amplified = chain.gain if over_time is None else over_time
    output = (volts["counts"] - above - zero_at_gains(chain, degrees, over_time)) / amplified
    if chain.validity_minimum is not None:
        good, found = _tested(chain.axes, chain.step * channels["validity"], chain.validity_minimum, place)
        output, remarks = np.where(good, output, np.nan), remarks + found
    readings = None if chain.scale_factor is None else output / chain.scale_factor
    return Converted(output, readings, degrees, np.isfinite(output), tuple(remarks))


def _volts(chain: Chain, channels: Mapping[str, Array], place: Place) -> tuple[dict[str, Array], list[Remark]]:
    """Volts of each channel, NaN where its code cannot be used, and why."""
    volts, remarks = {}, []
    for name in ("counts", "reference", "temperature", "temperature_reference", "validity"):
        if name in channels:
            names = [axis if name == "counts" else f"{name} of {axis}" for axis in chain.axes]
            check_inside(names, channels[name], chain.codes, place)
            if name != "validity":  # a built-in test rests at a rail when all is well
                bad, found = unusable(names, channels[name], chain.codes, place)
                volts[name] = chain.step * np.where(bad, np.nan, channels[name])
                remarks += found
    return volts, remarks


def _tested(axes: tuple[str, ...], volts: Array, minimum: float, place: Place) -> tuple[Mask, list[Remark]]:
    """Where the built-in test says good: at or above the minimum; missing is not good."""
    good = volts >= minimum
    never = [axis for axis, column in zip(axes, good.T, strict=True) if len(column) and not column.any()]
    if never:
        raise DataError(
            f"{', '.join(never)}: the built-in test is below {minimum:g} V throughout",
            where=place(0),
            why="readings while it is low are not valid, so none is left",
            do="Check the column of the built-in test, or leave the recording out",
            code="never_valid",
        )
    what = f"reading(s) while the built-in test is below {minimum:g} V; left out"
    return good, counted("test_low", axes, ~good, what, place)


def to_counts(
    chain: Chain,
    readings: ArrayLike,
    *,
    reference: ArrayLike | None = None,
    temperature: ArrayLike | None = None,
    gain: ArrayLike | None = None,
) -> NDArray[np.int64]:
    """Return the codes that a converter gives for readings: the inverse of `convert`.

    Parameters
    ----------
    readings : array_like, shape (n, k)
        [input unit]; outputs where the chain has no scale factor.
    reference : array_like, shape (n,) or (n, k), optional
        Codes of the reference voltage.
    temperature : array_like, shape (n,) or (n, k), optional
        Of the electronics [degC], where their zero depends on it.
    gain : array_like, shape (n,) or (n, k), optional
        Over time; instead of the chain's.

    Returns
    -------
    ndarray of int64, shape (n, k)
        The nearest codes; beyond the ends, the end.

    Raises
    ------
    DataError
        ``missing_reference`` or ``missing_temperature``.
    """
    k = len(chain.axes)
    wanted = wide("readings", readings, k)
    degrees = None if temperature is None else wide("temperature", temperature, k, len(wanted))
    over_time = None if gain is None else wide("gain", gain, k, len(wanted))
    amplified = chain.gain if over_time is None else over_time
    output = wanted if chain.scale_factor is None else wanted * chain.scale_factor
    return _codes(chain, output * amplified + zero_at_gains(chain, degrees, over_time), reference)


def to_temperature_counts(
    chain: Chain, temperature: ArrayLike, *, reference: ArrayLike | None = None
) -> NDArray[np.int64]:
    """Return the codes of the temperature channel, shape (n, k), at temperatures [degC].

    Raises
    ------
    DataError
        ``missing_temperature`` if the chain has no thermometer; ``missing_reference``.
    """
    if chain.thermometer is None:
        raise DataError("the chain has no thermometer", code="missing_temperature")
    return _codes(chain, chain.thermometer.volts(wide("temperature", temperature, len(chain.axes))), reference)


def _codes(chain: Chain, volts: Array, reference: ArrayLike | None) -> NDArray[np.int64]:
    """Nearest codes of volts above the reference."""
    if chain.reference != "channel":
        above: Array | float = chain.reference
    elif reference is None:
        raise missing_channel(chain, "reference", "the chain subtracts a reference voltage sample by sample")
    else:
        above = chain.step * wide("reference", reference, len(chain.axes), len(volts))
    codes = np.rint((volts + above) / chain.step)
    return (codes if chain.codes is None else np.clip(codes, *chain.codes)).astype(np.int64)


def check_inside(names: Sequence[str], codes: Array, ends: Ends, place: Place) -> None:
    """Refuse codes that the converter cannot give.

    Raises
    ------
    DataError
        ``code_outside``, with the first place and how many there are.
    """
    lo, hi = (-np.inf, np.inf) if ends is None else ends
    outside = (codes < lo) | (codes > hi) | np.isinf(codes)
    if np.any(outside):
        row, column = (int(i) for i in np.argwhere(outside)[0])
        count = int(np.count_nonzero(outside))
        raise DataError(
            f"{names[column]}: code {codes[row, column]:g} is outside the converter"
            + (f" ({lo:g} to {hi:g})" if ends else "")
            + (f", and {count - 1} more" if count > 1 else ""),
            where=place(row),
            why="the column holds no codes, or the converter is another one",
            do="Check the column, its unit and the ends of the converter",
            code="code_outside",
        )


def unusable(names: Sequence[str], codes: Array, ends: Ends, place: Place) -> tuple[Mask, list[Remark]]:
    """Return where codes are missing or at a rail, shape (n, k), and remarks that count them."""
    lost = np.isnan(codes)
    railed = np.zeros(codes.shape, dtype=bool) if ends is None else (codes == ends[0]) | (codes == ends[1])
    remarks = counted("missing", names, lost, "code(s) missing; left out", place)
    if ends is not None:
        what = f"code(s) at an end of the converter ({ends[0]} or {ends[1]}); left out"
        remarks += counted("rail", names, railed, what, place, "The input may lie beyond: use a wider range")
    return lost | railed, remarks


def counted(code: str, names: Sequence[str], where: Mask, what: str, place: Place, do: str = "") -> list[Remark]:
    """One remark a channel that has any."""
    remarks = []
    for name, column in zip(names, where.T, strict=True):
        count = int(np.count_nonzero(column))
        if count:
            text = f"{name}: {count} of {len(column)} {what}"
            remarks.append(Remark(code, "warning", text, place(int(np.argmax(column))), count, do))
    return remarks
