"""Clean cases that faults are put into, by procedure: a case a seed."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import numpy as np

from .. import flip, moved_mass, positions, rate_table, static, thermal
from ..case import START, Case, Table

SHARED = Path(os.environ.get("INERTIALCAL_SHARED", Path(__file__).parents[4] / "shared")) / "data"
LSB = 0.00875  # of the real gyro [deg/s]
ASSUMED = 100.0  # samples a second: the source does not say
STILL = {"x": static.Noise(white=0.004), "y": static.Noise(white=0.004, bias=0.01)}


def real(seed: int, first: int = 0, n: int | None = None) -> Case:
    """Return the real gyro of 238,256 samples (../shared/data/README.md, noise/l3g_gyro_x), or a part of it."""
    values = np.fromstring((SHARED / "noise/l3g_gyro_x/gyro2_x.txt").read_text(), sep=" ")[first:][:n]
    columns = {"unix_s": START + np.arange(len(values)) / ASSUMED, "gyro_x [deg/s]": values}
    table = Table(columns, ("gyro_x [deg/s]",), "unix_s", form={"unix_s": "%.2f", "gyro_x [deg/s]": "%.5f"})
    case = Case("allan", {"real.csv": table}, ["allan", "@real.csv"], {}, rate=ASSUMED, rng_seed=seed)
    case.noise, case.rail = 0.38, -32768 * LSB
    return case


BASES: dict[str, Callable[[int], Case]] = {
    "allan": lambda seed: static.still(seed, STILL, 24_000, 20.0, step=1e-4),
    "allan:hour": lambda seed: static.still(seed, STILL, 72_000, 20.0, step=1e-4),
    "allan:real": real,
    "allan:pad": lambda seed: static.still(seed, static.Noise(white=1e-6), 60_000, 142.0, sensor="acc", pad=True),
    "rate_table": lambda seed: rate_table.recorded(
        seed,
        rate_table.Gyros(turn_on=0.003, limit=100.0),
        rate_table.Protocol(axes="xy", samples=150),
        held_out=1,
    ),
    "rate_table:means": lambda seed: rate_table.reduced(seed, rate_table.Gyros(turn_on=0.003, dwell=0.002)),
    "rate_table:fast": lambda seed: rate_table.reduced(
        seed,
        rate_table.Gyros(turn_on=0.003),
        rate_table.Protocol(rates=(-2000.0, -1000.0, -500.0, 500.0, 1000.0, 2000.0)),
    ),
    "rate_table:unlabelled": lambda seed: rate_table.reduced(
        seed, rate_table.Gyros(dwell=0.002), rate_table.Protocol(runs=1, labelled=False)
    ),
    "positions": positions.by_hand,
    "thermal": thermal.ramped,
    "mass_attraction": moved_mass.moved,
    "flip": lambda seed: flip.turned(seed, programme=flip.Programme(dwells=4, before=300.0)),
}
