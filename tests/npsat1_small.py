"""A shorter campaign of the rate suite, with all its tests: for what does not depend on its length."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from inertialcal.rigs.npsat1 import rig as npsat1
from inertialcal.rigs.npsat1.setup import AIR, VACUUM, Bench, Chamber
from inertialcal.rigs.twin import Twin

QUICK = {
    AIR: Chamber(900.0, 300.0, 200.0, (760.0, 760.0)),
    VACUUM: Chamber(9000.0, 300.0, 200.0, (1e-5, 1e-6)),
}
SHORT = Bench(
    chambers=QUICK,
    ramps=(6.0, 3.0),
    chamber_runs=7,
    table_runs=8,
    table_fit_runs=5,
    zero_reference=False,  # the bias in air is taken off before: what such a chain of tests does is seen here alone
    rates_deg_s=(0.0, 0.1, -0.1, 1.5, -1.5, 4.5, -4.5, 0.0),
    static_hours=1.0,
)


def short_twin(seed: int, **change: Any) -> Twin:
    """Return the campaign of a seed, with changes to its bench."""
    return npsat1.build(replace(SHORT, **change), seed)
