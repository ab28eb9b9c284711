"""What single codes say about themselves: outside the converter, missing, at a rail, stuck."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from ...core.errors import DataError
from ...core.estimate import Array
from ...core.remarks import Remark
from ...signals.codes import is_stuck, longest_run

Mask = NDArray[np.bool_]
Place = Callable[[int], str]
Ends = tuple[int, int] | None


def check_inside(names: Sequence[str], codes: Array, ends: Ends, place: Place) -> None:
    """Refuse codes that the converter cannot give.

    Parameters
    ----------
    names : sequence of str, length k
        Of the channels, for the message.
    codes : ndarray, shape (n, k)
        NaN where missing.
    ends : (int, int) or None
        Lowest and highest code.
    place : callable
        Index -> ``"file:row"``.

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


def stuck_runs(names: Sequence[str], codes: Array, ends: Ends, place: Place) -> tuple[Mask, list[Remark]]:
    """Return where a channel repeats one code far longer than its other readings explain, and remarks.

    The longest run of each channel is judged, by ``signals.codes.is_stuck``; a run at a rail is a rail.
    """
    where, remarks = np.zeros(codes.shape, dtype=bool), []
    for i, name in enumerate(names):
        column = codes[:, i]
        if not len(column) or not is_stuck(column):
            continue
        run = longest_run(column)
        if ends is not None and run.value in ends:
            continue
        where[run.start : run.start + run.length, i] = True
        text = f"{name}: code {run.value:g} stands for {run.length} readings on end; kept"
        do = "Look at the channel: stuck, or an input quieter than one step?"
        remarks.append(Remark("stuck", "warning", text, place(run.start), run.length, do))
    return where, remarks
