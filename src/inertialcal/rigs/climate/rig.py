"""Rig of sensitivities: a rate-sensor suite whose supply, temperature, pressure and time since power-up change.

At rest in a thermal-vacuum chamber the supply is stepped at three temperatures, in air and in vacuum, in several
power-ups; on a rate table in the chamber the scale factor is found at the same supplies and temperatures; the unit is
switched on at several temperatures; the chamber is pumped out and vented. Unit and errors of the standards are drawn.

True values: means over many power-ups, settled, at 5 V and 20 degC, without the earth's rate.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...core.estimate import Array
from ...core.key import AXES
from ..parts.gyro_bench import draw_world, table_errors
from ..protocol import Rig, on_bench
from ..twin import Drawn, Fault, TrueValue, Twin
from . import TITLE
from .campaign import campaign_text, groups_of
from .recordings import GROUPS, file_of, names_of, recording
from .setup import AIR_PA, VACUUM_PA, Bench
from .unit import Unit, draw_unit

__all__ = ["FAULTS", "RIG", "Bench", "build"]

FAULTS: dict[str, Fault] = {
    "supply_in_millivolts": Fault(
        "the supply is saved in mV, stated in V", "impossible_voltage", {"volts_per_unit": 1e3}, "refused"
    ),
    "supply_not_stepped": Fault("the supply was never stepped", "not_varied", {"unplugged": True}),
    "conditions_exchanged": Fault(
        "the recordings in air and in vacuum have each other's names", "outside_condition", {"exchanged": True}
    ),
    "one_temperature": Fault("the chamber was never switched on", "not_varied", {"temperatures": (20.0,)}),
}  # fmt: skip


def build(bench: Bench, seed: int, unit: Unit | None = None) -> Twin:
    """Return the campaign that a bench gives.

    Parameters
    ----------
    bench : Bench
        The test as it is made. Recordings do not depend on which other parts it has.
    seed : int
        Of all draws.
    unit : Unit, optional
        Drawn by default.
    """
    of_unit, of_world, *of_groups = np.random.default_rng(seed).spawn(2 + len(GROUPS))
    own = unit or draw_unit(of_unit)
    stand = (bench.tilt_deg, bench.u_tilt_deg, bench.azimuth_deg, bench.u_azimuth_deg)
    world, drawn = draw_world(bench.standards, bench.latitude_deg, 1.0, {"table": stand, "chamber": stand}, of_world)
    files = {
        file_of(name): recording(bench, own, world, group, run, axis, rng)
        for group, rng in zip(GROUPS, of_groups, strict=True)
        if group in groups_of(bench)
        for name, (run, axis) in names_of(bench, group).items()
    }
    if bench.exchanged:
        files |= {
            file_of(f"supply_{one}_{run}"): files[file_of(f"supply_{other}_{run}")]
            for run in range(1, bench.runs + bench.held_out + 1)
            for one, other in (("air", "vacuum"), ("vacuum", "air"))
        }
    errors = table_errors(bench.standards, drawn, bench.latitude_deg)
    return Twin(campaign_text(bench), files, tuple(true_values(own)), {**drawn, **drawn_of(own)}, errors=errors)


def true_values(unit: Unit) -> Iterator[TrueValue]:
    """Yield the quantities of a unit, SI."""
    yield from _each("bias_supply", unit.supply, "rad/s/V")
    yield from _each("bias_supply_temperature", unit.supply_temperature, "rad/s/V/degC")
    yield from _each("scale_factor_error_supply", unit.scale_supply, "1/V")
    yield from _each("scale_factor_error_temperature", unit.scale_temperature, "1/degC", power=1)
    yield from _each("scale_factor_error", np.diag(unit.matrix) - 1.0, "1")
    for i, axis in enumerate(AXES):
        for j, other in enumerate(AXES):
            if j != i:
                yield TrueValue("misalignment", axis + other, float(unit.matrix[i, j] / unit.matrix[i, i]), "rad")
    for j, (amplitude, time) in enumerate(zip(unit.warm_up, unit.warm_up_time, strict=True), 1):
        yield from _each("bias_warm_up", amplitude, "rad/s", power=j)
        yield TrueValue("warm_up_time", "", float(time), "s", power=j)
    change = -unit.vacuum / (AIR_PA - VACUUM_PA)
    yield from _each("bias_pressure", change, "rad/s/Pa", "pressure")
    yield from _each("bias_pressure_temperature", change * unit.vacuum_temperature, "rad/s/Pa/degC", "pressure")
    for test in ("supply_air", "supply_vacuum", "scale"):
        slope = unit.bias[1] + (unit.vacuum * unit.vacuum_temperature if test == "supply_vacuum" else 0.0)
        yield from _each("bias_temperature", slope, "rad/s/degC", test, 1)
        yield from _each("bias_temperature", unit.bias[2], "rad/s/degC^2", test, 2)


def _each(quantity: str, values: Array, unit: str, test: str = "", power: int = 0) -> Iterator[TrueValue]:
    for axis, value in zip(AXES, values, strict=True):
        yield TrueValue(quantity, axis, float(value), unit, test, power=power)


def drawn_of(unit: Unit) -> Drawn:
    """Return what else was drawn of a unit, for the file of the truth."""
    return {
        "bias": unit.bias.tolist(),
        "vacuum_temperature": unit.vacuum_temperature.tolist(),
        "warm_up_temperature": unit.warm_up_temperature,
        "references": unit.references.tolist(),
    }


RIG = Rig("climate", TITLE, on_bench(build, Bench()), FAULTS, tests=("sensitivity",))
