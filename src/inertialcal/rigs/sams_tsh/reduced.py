"""The flip with nothing in it but bias, ambient acceleration and noise: fast, for coverage over thousands of records.

The same record as the rig makes, without temperature, lines, crew and filters, before the converter. The head is
aligned and its scale factors are the stated ones: what a ground model takes away is taken away.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ...core.influence import Influence
from .record import Record, record
from .setup import Bench, Head, draw_head


def reduced(
    seed: int,
    corner: float,
    *,
    turn_starts: tuple[float, ...] = (1200.0, 2400.0),
    positions_deg: tuple[float, ...] = (180.0, 0.0),
    arm: tuple[float, float] | None = None,
    standards: Mapping[str, Influence] | None = None,
) -> Record:
    """Return one record of an hour at 25 samples/s.

    Parameters
    ----------
    seed : int
        Of all draws.
    corner : float
        Frequency below which 1/f noise is larger than white noise [Hz]; 0 for white noise alone.
    turn_starts, positions_deg : tuple of float
        When each turn begins [s], and the angle that it ends at [deg].
    arm : (float, float), optional
        When the robot arm moves [s].
    standards : mapping of Influence, optional
        An error of each is drawn; none by default.
    """
    bench = reduced_bench(corner, turn_starts, positions_deg, arm, standards)
    of_head, of_record = np.random.default_rng(seed).spawn(2)
    return record(bench, aligned(draw_head(bench, of_head)), of_record)


def aligned(head: Head) -> Head:
    """Return a head without misalignment, with the ideal scale factors at every temperature."""
    scale = np.zeros_like(head.scale)
    scale[:, 0] = 1.0
    return replace(head, matrix=np.stack([np.eye(3), np.zeros((3, 3))]), scale=scale)


def reduced_bench(
    corner: float,
    turn_starts: tuple[float, ...],
    positions_deg: tuple[float, ...],
    arm: tuple[float, float] | None = None,
    standards: Mapping[str, Influence] | None = None,
) -> Bench:
    """Return the bench of `reduced`."""
    return Bench(
        corner=corner, turn_starts=turn_starts, positions_deg=positions_deg, stopped_deg=(0.0,) * len(turn_starts),
        arm=arm, standards=standards or {}, swing_ug=0.0, lines=(), pushes=0.0, warming=0.0, temperature_swing=0.0,
        hysteresis_ug=0.0, drift_ug=0.0, filtered=False,
    )  # fmt: skip
