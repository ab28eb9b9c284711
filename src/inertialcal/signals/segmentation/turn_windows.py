"""Quiet windows before and after turns by a stated criterion, or given by the user and taken as they are.

Both windows of a turn are equally long and equally far from it (a steady drift then shows least), ``settle`` away from
its spike and from its neighbours. Every block inside is full and quiet by the one detector; the two halves of a
window agree in level within what halves differ elsewhere in the record, and in variance within a stated ratio, as do
the windows with each other; the temperature moves no faster than stated. What fails is named, and the pair is not
quiet: the windows are then given as far as they exist, and whoever uses them knows why he should not.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array
from ...core.recording import SECOND
from ...core.remarks import Remark
from ..time.samples import Flags
from .block_statistics import Blocks, LevelScatter
from .turns import Turn, TurnPlan, Turns


@dataclass(frozen=True, eq=False)
class Window:
    """A stretch of the record."""

    # start, stop: samples, half-open
    start: int
    stop: int
    # start_ns, stop_ns: its time, half-open [ns]
    start_ns: int
    stop_ns: int
    # mean, variance: of the samples in it; of windows found, the variance is the mean of those of the blocks [unit of
    # the signal], shape (channels,)
    mean: Array
    variance: Array
    count: Array  # finite samples, shape (channels,)

    @property
    def length(self) -> float:
        """Its length [s]."""
        return (self.stop_ns - self.start_ns) / SECOND


@dataclass(frozen=True, eq=False)
class WindowPair:
    """Windows before and after a turn."""

    turn: Turn  # between them
    # before, after: none where there is no room
    before: Window | None
    after: Window | None
    problems: tuple[Remark, ...]  # why they are not quiet; empty where they are

    @property
    def quiet(self) -> bool:
        """Whether both are there, and nothing speaks against them."""
        return not self.problems


def turn_windows(turns: Turns, temperature: Blocks | None = None) -> tuple[WindowPair, ...]:
    """Lay a window before and one after each turn.

    Parameters
    ----------
    turns : Turns
        From ``find_turns``; its plan holds the criterion.
    temperature : Blocks, optional
        Of the temperatures, in blocks of the same time [degC].

    Returns
    -------
    tuple of WindowPair
        One a turn.

    Raises
    ------
    DataError
        If the temperatures lie in other blocks.
    """
    if temperature is not None and (
        temperature.length_ns != turns.blocks.length_ns or temperature.start_ns != turns.blocks.start_ns
    ):
        raise DataError("temperature and signal are in different blocks")
    apart = LevelScatter(turns.blocks, turns.quiet)
    found = []
    for i, turn in enumerate(turns.turns):
        ends = [turns.turns[j] if 0 <= j < len(turns.turns) else None for j in (i - 1, i + 1)]
        found.append(_pair(turns, turn, (ends[0], ends[1]), apart, temperature))
    return tuple(found)


def _pair(
    turns: Turns,
    turn: Turn,
    neighbours: tuple[Turn | None, Turn | None],
    apart: LevelScatter,
    temperature: Blocks | None,
) -> WindowPair:
    blocks, plan = turns.blocks, turns.plan
    gap = plan.blocks(plan.settle)
    first, stop = _reach(turn, blocks)
    left, right = first - gap, stop + gap  # last edge of the window before, first edge of the one after
    room = (_room(blocks, neighbours[0], left, gap, -1), _room(blocks, neighbours[1], right, gap, 1))
    calm = (_calm(blocks, turns.quiet, left, -1), _calm(blocks, turns.quiet, right, 1))
    wanted = plan.blocks(plan.window if plan.window is not None else plan.shortest)
    size = wanted if plan.window is not None else min(*room, *calm, plan.blocks(plan.widest))
    size = max(size, min(wanted, *room))
    where = f"turn {(turn.start_ns - blocks.start_ns) / SECOND:.0f} s after the start"
    problems: list[Remark] = []
    for side, space, still in zip(("before", "after"), room, calm, strict=True):
        if space < wanted:
            text = f"{space * plan.block:g} s left {side} the turn after settling, need {wanted * plan.block:g} s"
            do = "Record longer, or give a shorter window"
            problems.append(Remark("shorter_than_settling", "warning", text, where, do=do))
        elif still < wanted:
            text = f"disturbed {still * plan.block:g} s from the turn ({side}), need {wanted * plan.block:g} s quiet"
            problems.append(Remark("disturbed", "warning", text, where, do="Repeat the turn, or give the windows"))
    before = _window(blocks, left - size, size) if room[0] >= size >= 2 else None
    after = _window(blocks, right, size) if room[1] >= size >= 2 else None
    if not problems and before is not None and after is not None:
        edges = (left - size, right)
        problems = [*_unsteady(turns, edges, size, apart), *_warming(temperature, edges, size, plan)]
    return WindowPair(turn, before, after, tuple(problems))


def _reach(turn: Turn, blocks: Blocks) -> tuple[int, int]:
    """Blocks of time [first, stop) that a turn reaches into."""
    first = (turn.start_ns - blocks.start_ns) // blocks.length_ns
    return int(first), int(-(-(turn.stop_ns - blocks.start_ns) // blocks.length_ns))


def _room(blocks: Blocks, neighbour: Turn | None, edge: int, gap: int, way: int) -> int:
    """Blocks of time between an edge and the settling of the next turn, or the end of the record; 0 or more."""
    if way < 0:
        end = 0 if neighbour is None else _reach(neighbour, blocks)[1] + gap
        return max(edge - end, 0)
    end = int(blocks.at[-1]) + 1 if neighbour is None else _reach(neighbour, blocks)[0] - gap
    return max(end - edge, 0)


def _calm(blocks: Blocks, quiet: Flags, edge: int, way: int) -> int:
    """Quiet blocks of time without a gap, counted from an edge away from the turn."""
    if way > 0:
        here = int(np.searchsorted(blocks.at, edge))
        run = quiet[here:] & (blocks.at[here:] == edge + np.arange(len(blocks) - here))
    else:
        here = int(np.searchsorted(blocks.at, edge))
        run = (quiet[:here] & (blocks.at[:here] == edge - np.arange(here, 0, -1)))[::-1]
    return len(run) if run.all() else int(np.argmin(run))


def _window(blocks: Blocks, at: int, size: int) -> Window:
    a, b = (int(i) for i in np.searchsorted(blocks.at, (at, at + size)))
    count = blocks.count[a:b]
    n = count.sum(axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = np.where(count > 0, count * blocks.mean[a:b], 0.0).sum(axis=0) / n
        rest = np.where(count > 1, count - 1, 0)
        variance = np.where(count > 1, rest * blocks.variance[a:b], 0.0).sum(axis=0) / rest.sum(axis=0)
    start_ns = blocks.start_ns + at * blocks.length_ns
    first = int(blocks.first[a]) if a < len(blocks) else int(blocks.stop[-1])
    last = int(blocks.stop[b - 1]) if b > a else first
    return Window(first, last, start_ns, start_ns + size * blocks.length_ns, mean, variance, n)


def _unsteady(turns: Turns, edges: tuple[int, int], size: int, apart: LevelScatter) -> list[Remark]:
    """List what speaks against the steadiness of level and variance in two windows."""
    blocks, plan, half = turns.blocks, turns.plan, size // 2
    limit, found, spread = plan.step * apart.of(half, size - 2 * half), [], []
    for side, at in zip(("before", "after"), edges, strict=True):
        one, two = _window(blocks, at, half), _window(blocks, at + size - half, half)
        moved = np.abs(two.mean - one.mean)
        spread += [one.variance, two.variance]
        if np.any(moved > limit):
            worst = float(np.max(moved / limit)) * plan.step
            text = f"level moves inside the window {side} the turn: {worst:.1f} standard deviations between its halves"
            found.append(Remark("not_stationary", "warning", text))
    lo, hi = np.min(spread, axis=0), np.max(spread, axis=0)
    if np.any(hi > plan.variance_ratio * lo):
        worst = float(np.max(hi[lo > 0.0] / lo[lo > 0.0], initial=0.0))
        text = (
            f"variance changes by {worst:.3g} between or inside the windows, at most {plan.variance_ratio:g} is quiet"
        )
        found.append(Remark("not_stationary", "warning", text))
    return found


def _warming(temperature: Blocks | None, edges: tuple[int, int], size: int, plan: TurnPlan) -> list[Remark]:
    """Whether the temperature moves too fast in a window."""
    if temperature is None or not np.isfinite(plan.temperature_slope):
        return []
    steepest = max(_slope(temperature, at, size) for at in edges)
    if not steepest > plan.temperature_slope:
        return []
    text = f"temperature moves by {steepest:.2g} degC/s in a window, at most {plan.temperature_slope:g} is quiet"
    return [Remark("temperature_slope", "warning", text)]


def _slope(temperature: Blocks, at: int, size: int) -> float:
    """Steepest slope of a straight line through the temperatures of a window [degC/s]."""
    a, b = np.searchsorted(temperature.at, (at, at + size))
    slopes = [0.0]
    for column in temperature.mean[a:b].T:
        good = np.isfinite(column)
        t = temperature.at[a:b][good] * temperature.length
        if np.count_nonzero(good) > 1:
            slopes.append(abs(float(np.polyfit(t - t.mean(), column[good], 1)[0])))
    return max(slopes)


def quiet_part(turns: Turns, start_ns: int, stop_ns: int) -> float:
    """Return the part of the blocks of a stretch, half-open [ns], that are there and quiet; 1 where nothing moves.

    Blocks that the stretch only touches at its ends count too: a window should keep off them.
    """
    blocks = turns.blocks
    begin = (start_ns - blocks.start_ns) // blocks.length_ns
    end = -(-(stop_ns - blocks.start_ns) // blocks.length_ns)
    a, b = np.searchsorted(blocks.at, (begin, end))
    return float(np.count_nonzero(turns.quiet[a:b])) / max(end - begin, 1)
