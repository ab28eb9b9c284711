"""Closed loop of thermal tests: power-ups held out against the polynomial of the fit in the same condition."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ..procedures.rate_table.closed_loop import AxisLoop, judged
from ..procedures.thermal.closed_loop import Left


@dataclass(frozen=True)
class ThermalLoop:
    """One axis of a thermal test held out.

    Parameters
    ----------
    test, against : str
        Held out, and fitted.
    loop : AxisLoop
        Before, after, verdict; a dwell is a cell.
    """

    test: str
    against: str
    loop: AxisLoop


def judged_loops(left: Mapping[str, tuple[str, tuple[Left, ...]]], share: float) -> tuple[ThermalLoop, ...]:
    """Return the verdicts, Holm over all axes of all thermal tests held out.

    Parameters
    ----------
    left : mapping
        As `left_over` gives it.
    share : float
        Of the risk of the closed loop.
    """
    which = [(test, other) for test, (other, every) in left.items() for _ in every]
    loops = [_loop(one) for _, every in left.values() for one in every]
    return tuple(ThermalLoop(*name, loop) for name, loop in zip(which, judged(loops, share), strict=True))


def _loop(one: Left) -> AxisLoop:
    u = one.u_gain if one.dof > 0.0 else float("inf")
    dof = one.dof if one.dof > 0.0 else 1.0
    return AxisLoop(one.axis, one.cells, one.runs, one.raw, one.compensated, one.gain, u, dof, max(one.allowed, 0.0))


def loop_rows(loops: Sequence[ThermalLoop], scale: float, unit: str) -> list[dict[str, Any]]:
    """Return the rows of ``closed_loop.over_temperature``, in the unit of the sensor."""
    return [
        {
            "test": one.test, "against": one.against, "axis": one.loop.axis, "cells": one.loop.dwells,
            "runs": one.loop.runs, "unit": unit,
            "raw_rms": one.loop.raw * scale, "compensated_rms": one.loop.compensated * scale,
            "verdict": one.loop.verdict, "reason": one.loop.reason,
        }
        for one in loops
    ]  # fmt: skip
