"""Turns that are said, by windows and their positions, against those that the record shows.

Between two windows of different position the head is said to be turned, once; between two of one position and inside a
window it is not. Turns that the record shows (``signals.segmentation.turns``) are put side by side with those. They
disagree where the head is clearly turned inside a window, or between windows of one position, or is clearly not turned
between windows of two: then a window is in the wrong place or has the wrong position. With two positions, each window
that the number of turns before it puts at the other one is named, where they are fewer than those that fit. Turns that
are too small to be seen say nothing.

Two positions that are exchanged everywhere cannot be told: the record does not show where the head started.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np

from ....core.recording import SECOND
from ....core.remarks import Remark
from ....signals.segmentation.turns import SQUARE, Turn, Turns
from .quiet import Window

Clock = Callable[[int], str]
SAME = 1e-6  # [rad]
MOST = 8  # turns in a message
FIT = 5.0  # s that a turn may reach into a window


def said_and_seen(turns: Turns, windows: Sequence[Window]) -> tuple[list[Remark], list[Remark]]:
    """Return the remarks on turns said and seen, and what disagrees so that no figure survives."""
    start = turns.blocks.start_ns
    order = sorted(range(len(windows)), key=lambda i: windows[i].start)
    placed = [windows[i] for i in order]
    sure = [one for one in turns.shifts if one.clear and one.square > SQUARE]
    seen = sorted((*turns.turns, *sure), key=lambda one: one.middle_ns)

    def clock(ns: int) -> str:
        return f"{(ns - start) / SECOND:.0f}"

    wrong = []
    free = []
    for one in seen:
        hit = [i for i, w in enumerate(placed) if w.start + _reach(one) < one.middle_ns < w.stop - _reach(one)]
        for i in hit:
            kind = "the head is turned" if one in turns.turns else "the level changes for good"
            what = f"{kind} inside a window: {_seen(one, clock)}"
            where = f"window {order[i] + 1}, {clock(placed[i].start)} to {clock(placed[i].stop)} s"
            do = "Correct the window, or give one on each side"
            wrong.append(Remark("turn_in_dwell", "error", what, where, do=do))
        jumped = one in turns.shifts and not turns.doubt
        if jumped and not hit and placed[0].start < one.middle_ns < placed[-1].stop:
            what = f"the level changes for good, without a turn: {_seen(one, clock)}"
            do = "A bias jumped, or something else did: give the windows of one side"
            wrong.append(Remark("level_step", "error", what, do=do))
        if not hit and not jumped:
            free.append(one)
    texts, parity, missed = [], [0], []
    for a, b in pairwise(placed):
        own = [one for one in free if a.stop - _reach(one) <= one.middle_ns <= b.start + _reach(one)]
        parity.append(parity[-1] + len(own))
        differ = bool(abs(a.angle - b.angle) > SAME)
        if differ:
            texts.append(_both(a, b, own, clock))
        if (len(own) % 2 == 1) is not differ and (
            own or turns.excludes((a.stop - start) / SECOND, (b.start - start) / SECOND)
        ):
            missed.append((a, b, own))
    if missed and not wrong:
        wrong += _misplaced(placed, order, parity, missed, clock)
    outside = [one for one in free if not placed[0].start < one.middle_ns < placed[-1].stop]
    return _remarks(texts, outside, bool(seen), clock), wrong


def _both(a: Window, b: Window, own: Sequence[Turn], clock: Clock) -> str:
    """Return a turn that is said, and what is seen of it, side by side."""
    said = f"{clock(a.stop)} to {clock(b.start)} s"
    if len(own) != 1:
        return f"{said}, {f'{len(own)} seen' if own else 'not seen'}"
    off = (own[0].middle_ns - 0.5 * (a.stop + b.start)) / SECOND
    return f"{said}, seen {_seen(own[0], clock)} ({off:+.0f} s)"


def _remarks(texts: Sequence[str], outside: Sequence[Turn], seen: bool, clock: Clock) -> list[Remark]:
    remarks = []
    if texts and seen:
        more = f"; and {len(texts) - MOST} more" if len(texts) > MOST else ""
        what = f"turns from the windows and as the record shows them (apart): {'; '.join(texts[:MOST])}{more}"
        remarks.append(Remark("turns_seen", "info", what))
    elif texts:
        what = "the turns that are said do not show in the record: nothing checks the positions"
        remarks.append(Remark("turn_not_seen", "info", what, count=len(texts)))
    if outside:
        what = f"turn seen outside the windows: {'; '.join(_seen(one, clock) for one in outside[:MOST])}"
        do = "Give the windows of these dwells too, or cut the record (--from, --to): it shows the noise"
        remarks.append(Remark("turn_not_said", "warning", what, do=do))
    return remarks


def _misplaced(
    placed: Sequence[Window], order: Sequence[int], parity: Sequence[int],
    missed: Sequence[tuple[Window, Window, list[Turn]]], clock: Clock,
) -> list[Remark]:  # fmt: skip
    """Return which windows have the wrong position, as far as it can be told; else between which it is wrong."""
    do = "Correct the position of this window, or its times"
    angles = np.unique(np.round([one.angle for one in placed], 6))
    if len(angles) == 2:
        state = np.array([int(abs(one.angle - angles[0]) > SAME) for one in placed])
        off = (np.array(parity) + state) % 2
        few = np.flatnonzero(off == int(2 * off.sum() < len(off)))
        if 2 * len(few) < len(off):
            found = []
            for i in (int(at) for at in few):
                what = f"the turns that are seen put this window at {math.degrees(angles[1 - state[i]]):.6g} deg"
                where = f"window {order[i] + 1}: position {math.degrees(placed[i].angle):.6g} deg"
                found.append(Remark("not_turned_by_angle", "error", what, where, do=do))
            return found
    found = []
    for a, b, own in missed:
        here = f"between {clock(a.stop)} and {clock(b.start)} s"
        what = f"{f'{len(own)} turns are seen' if own else 'no turn is seen'} {here}, where positions differ"
        if abs(a.angle - b.angle) <= SAME:
            seen = "; ".join(_seen(one, clock) for one in own)
            what = f"the head is turned {here} ({seen}), where both windows have one position"
        found.append(Remark("not_turned_by_angle", "error", what, do="Correct one of the positions, or the times"))
    return found


def _seen(one: Turn, clock: Clock) -> str:
    if one.felt:
        return f"{clock(one.start_ns)} to {clock(one.stop_ns)} s"
    return f"{clock(one.middle_ns)} ± {max(one.u, 1.0):.0f} s"


def _reach(one: Turn) -> int:
    """How far a turn may be from a window that it is at the end of [ns]."""
    return round((FIT + (0.0 if one.felt else 3.0 * one.u)) * SECOND)
