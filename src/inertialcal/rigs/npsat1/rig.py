"""Rig of the rate-sensor suite: three rate sensors through thermal chamber, vacuum, rate table and a long rest.

Sizes and signs follow the published flight unit [1]_ (``npsat1_tables``). The unit is drawn about it, power-ups about
the unit; what the engineer does not know of his bench is drawn once (``npsat1_world``). What the sensors read stands in
``npsat1_reading``, what the true values mean in ``npsat1_truth``.

References
----------
.. [1] V. V. Badescu, NPS thesis, September 2011.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ...core.recording import Recording
from ..protocol import Rig, Twin, on_bench
from . import TITLE
from .campaign import campaign_text, recording_file
from .faults import FAULTS
from .recordings import chamber_recording, static_recording, table_recordings
from .setup import AIR, Bench
from .truth import drawn_of, true_values
from .unit import Unit, draw_unit
from .world import World, draw_world

__all__ = ["FAULTS", "RIG", "Bench", "build"]

Recordings = dict[str, Recording]


def build(bench: Bench, seed: int, unit: Unit | None = None) -> Twin:
    """Return the campaign that a bench gives.

    Parameters
    ----------
    bench : Bench
        The campaign as it is made. Recordings do not depend on which other parts it has.
    seed : int
        Of all draws.
    unit : Unit, optional
        Drawn by default.
    """
    of_unit, of_world, of_chambers, of_table, of_rest = np.random.default_rng(seed).spawn(5)
    own = unit or draw_unit(of_unit)
    world, drawn = draw_world(bench, of_world)
    made: dict[str, tuple[Callable[..., Recordings], np.random.Generator]] = {
        "thermal": (_chambers, of_chambers),
        "rate_table": (_table, of_table),
        "noise": (_rest, of_rest),
    }
    files: Recordings = {}
    for part in bench.parts:
        make, rng = made[part]
        files |= make(bench, own, world, rng)
    text = campaign_text(bench)
    return Twin(text, files, true_values(own, bench.parts), {**drawn, **drawn_of(own)})


def _chambers(bench: Bench, unit: Unit, world: World, rng: np.random.Generator) -> Recordings:
    found = {
        recording_file(where, number): chamber_recording(bench, unit, world, where, number, rng)
        for where in bench.chambers
        for number in range(1, bench.chamber_runs + 1)
    }
    if bench.copied:
        found[recording_file(AIR, 2)] = found[recording_file(AIR, 1)]
    return found


def _table(bench: Bench, unit: Unit, world: World, rng: np.random.Generator) -> Recordings:
    return {
        recording_file(axis, number): recording
        for number in range(1, bench.table_runs + 1)
        for axis, recording in table_recordings(bench, unit, world, number, rng).items()
    }


def _rest(bench: Bench, unit: Unit, world: World, rng: np.random.Generator) -> Recordings:
    runs = range(1, bench.static_runs + 1)
    return {recording_file("static", number): static_recording(bench, unit, world, number, rng) for number in runs}


RIG = Rig("npsat1", TITLE, on_bench(build, Bench()), FAULTS, demonstration_seed=2011)  # the year of [1]_
