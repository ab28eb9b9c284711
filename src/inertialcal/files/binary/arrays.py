"""Named arrays (MATLAB, HDF5, NumPy) as columns.

The longest dimension is time. Arrays of one length share a clock; a file may hold several. A matrix becomes
a column for each of its channels, named ``accel_1``, ``accel_2``, ... Scalars are no columns; one that is named
as a sample rate is taken as such.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import prod
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from ...core.batches import batches, changed, empty, is_stored, where
from ...core.errors import DataError
from ...core.key import AXES
from ...core.remarks import Remark
from ..columns import Column, Content

MOST_CHANNELS = 1000
AT_ONCE = 2**23  # bytes of a long array
SAMPLE_RATES = frozenset(
    {"fs", "fshz", "samplerate", "sampleratehz", "samplingrate", "samplingratehz", "samplefrequency"}
    | {"samplingfrequency", "samplefreq", "samplingfreq", "srate"}
)


@dataclass(frozen=True, eq=False)
class NamedArray:
    """An array with its name in the file (empty if it has none), and its unit as metadata say it."""

    name: str
    values: NDArray[Any]
    unit: str | None = None


def received(
    stream: IO[bytes], kind: np.dtype[np.generic], shape: Sequence[int], stored: bool | None = None
) -> NDArray[Any]:
    """Return an array whose values a stream gives in order of storage, filled a batch at a time.

    Parameters
    ----------
    stream : binary file
        At its first value.
    kind, shape
        Of the array.
    stored : bool, optional
        As ``core.batches.empty`` takes it.

    Raises
    ------
    EOFError
        If the stream ends too early.
    """
    array = empty(prod(shape), kind, stored)
    if array.nbytes:
        for first, stop in batches(array, size=max(AT_ONCE // kind.itemsize, 1)):
            view = array[first:stop].view(np.uint8).data
            done = 0
            while done < len(view):
                got = stream.readinto(view[done:])  # type: ignore[attr-defined]
                if not got:
                    raise EOFError
                done += got
    return array.reshape(shape)


@dataclass(frozen=True, eq=False)
class _Variable:
    """An array laid time-first, shape (n, k)."""

    source: NamedArray
    values: NDArray[Any]


def columns_of(
    arrays: Sequence[NamedArray],
    kind: str,
    path: str,
    *,
    variables: Sequence[str] | None = None,
    skipped: Sequence[str] = (),
) -> Content:
    """Return the columns of one clock.

    Parameters
    ----------
    arrays : sequence of NamedArray
        All that the file holds.
    kind : str
        Format, in words.
    path : str
        File, for messages.
    variables : sequence of str, optional
        Names to take; by default those of the length that holds most values.
    skipped : sequence of str
        Names of what is no array of numbers.

    Raises
    ------
    DataError
        If a variable is not there (``wrong_column``), those wanted differ in length (``several_clocks``), or
        there is no array (``no_channel``).
    """
    laid = [variable for variable in map(_laid, arrays) if variable is not None]
    wide = {array.name for array in arrays} - {v.source.name for v in laid} - _scalars(arrays)
    remarks = _skipped_remark([*skipped, *sorted(wide)], path)
    chosen = _wanted(laid, variables, path) if variables else _largest(laid)
    if not chosen:
        raise DataError(
            "no array of two or more numbers", where=path, code="no_channel",
            do=f"It holds: {', '.join([a.name for a in arrays] + list(skipped)) or 'nothing'}",
        )  # fmt: skip
    others = [v for v in laid if v not in chosen] if not variables else []
    columns = tuple(column for variable in chosen for column in _columns(variable))
    return Content(columns, kind, None, _sample_rate(arrays), remarks + _other_remark(others, path))


def _laid(array: NamedArray) -> _Variable | None:
    """Array with time first; None for scalars and what is no table."""
    values = np.squeeze(array.values)
    if values.ndim not in (1, 2) or values.size < 2 or values.dtype.kind not in "biufM":
        return None
    if values.ndim == 1:
        return _Variable(array, values[:, None])
    values = values if values.shape[0] >= values.shape[1] else values.T
    return None if values.shape[1] > MOST_CHANNELS else _Variable(array, values)


def _scalars(arrays: Sequence[NamedArray]) -> set[str]:
    return {array.name for array in arrays if array.values.size < 2}


def _wanted(laid: Sequence[_Variable], variables: Sequence[str], path: str) -> list[_Variable]:
    """Variables by name, all of one length."""
    by_name = {variable.source.name: variable for variable in laid}
    missing = [name for name in variables if name not in by_name]
    if missing:
        raise DataError(
            f"no variable {missing[0]!r}",
            where=path,
            do=f"The file has: {', '.join(by_name) or 'none'}",
            code="wrong_column",
        )
    chosen = [by_name[name] for name in variables]
    lengths = {v.source.name: len(v.values) for v in chosen}
    if len(set(lengths.values())) > 1:
        said = ", ".join(f"{name} has {n}" for name, n in lengths.items())
        raise DataError(
            f"variables differ in length: {said}",
            where=path,
            why="they cannot share a clock",
            do="Read the variables of one length at a time",
            code="several_clocks",
        )
    return chosen


def _largest(laid: Sequence[_Variable]) -> list[_Variable]:
    """Variables of the length that holds most values."""
    sizes: dict[int, int] = {}
    for variable in laid:
        sizes[len(variable.values)] = sizes.get(len(variable.values), 0) + variable.values.size
    longest = max(sizes, key=lambda n: (sizes[n], n), default=0)
    return [variable for variable in laid if len(variable.values) == longest]


def _columns(variable: _Variable) -> list[Column]:
    """One column a channel."""
    name, unit, table = variable.source.name, variable.source.unit, variable.values
    several = table.shape[1] > 1
    columns = []
    for i in range(table.shape[1]):
        title = (f"{name}_{i + 1}" if several else name) if name else f"column_{i + 1}"
        column = number_column(title, table[:, i], unit, named=bool(name) and not several)
        axis = AXES[i] if table.shape[1] == len(AXES) else ""
        columns.append(replace(column, matrix=name, axis=axis))
    return columns


def number_column(name: str, values: NDArray[Any], unit: str | None, *, named: bool = True) -> Column:
    """Return a column of numbers: NaN is a missing value, as these formats have no other; infinity is NaN.

    Parameters
    ----------
    name, unit, named
        As ``Column`` takes them.
    values : ndarray, shape (n,)
        Numbers, truth values or dates.
    """
    kind = values.dtype.newbyteorder("=")
    if kind.kind == "M":
        stamps = _as_type(values, np.dtype("datetime64[ns]"))
        return Column(name, stamps, unit, named, empty=where(stamps, np.isnat))
    if kind.kind == "b":
        kind = np.dtype(np.uint8)
    elif kind.kind == "f" and kind.itemsize > 8:
        kind = np.dtype(np.float64)
    values = _as_type(values, kind)
    if kind.kind != "f":
        return Column(name, values, unit, named)
    gone, infinite = where(values, np.isnan), where(values, np.isinf)
    if len(infinite):
        values = changed(values, lambda part: np.where(np.isinf(part), np.array(np.nan, kind), part), kind)
    return Column(name, values, unit, named, empty=gone, not_a_number=infinite)


def _as_type(values: NDArray[Any], kind: np.dtype[Any]) -> NDArray[Any]:
    """Return values one after the other in another type; as long as they are if they have it."""
    if values.dtype == kind and values.flags.c_contiguous:
        return values
    out = empty(len(values), kind, is_stored(values) or None)
    for first, stop in batches(out, values):
        out[first:stop] = values[first:stop]
    return out


def _sample_rate(arrays: Sequence[NamedArray]) -> float | None:
    """Scalar that is named as a sample rate [Hz]."""
    for array in arrays:
        name = re.sub(r"[^a-z]", "", array.name.rpartition(".")[2].lower())
        if array.values.size == 1 and name in SAMPLE_RATES and array.values.dtype.kind in "iuf":
            value = float(array.values.reshape(-1)[0])
            if np.isfinite(value) and value > 0.0:
                return value
    return None


def _skipped_remark(names: Sequence[str], path: str) -> tuple[Remark, ...]:
    if not names:
        return ()
    some = ", ".join(names[:5]) + (", ..." if len(names) > 5 else "")
    what = f"not arrays of numbers, left out: {some[:120]}"
    return (Remark("variables_left_out", "info", what, where=path, count=len(names)),)


def _other_remark(others: Sequence[_Variable], path: str) -> tuple[Remark, ...]:
    if not others:
        return ()
    said = ", ".join(f"{v.source.name} ({len(v.values)} samples)" for v in others[:5])
    what = f"different length, so a different clock; not read: {said[:160]}"
    do = "Read them by name: --topic NAME"
    return (Remark("other_clock", "warning", what, where=path, count=len(others), do=do),)
