"""Rig of the rate-sensor suite: three rate sensors through thermal chamber, vacuum, rate table and a long rest.

Sizes and signs follow the published flight unit [1]_. The unit is drawn about it, and each power-up about the unit.
What the engineer does not know of his bench is drawn once for the whole campaign.

True values: the bias is a mean over many power-ups, settled, midway between warming and cooling, without the earth's
rate, at the true temperature. The rate-table tests subtract the reading at rest, in which power-ups differ by more than
5 % of a low rate. Where they take off the bias in air instead, the bias on the rate table is what remains: its
installation, which is not in the models.

References
----------
.. [1] V. V. Badescu, NPS thesis, September 2011.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

import numpy as np

from ...core.estimate import Array
from ...core.key import AXES, At
from ...core.recording import Recording
from ..parts.gyro_bench import World, draw_world, table_errors
from ..protocol import Rig, on_bench
from ..twin import Drawn, Fault, TrueValue, Twin
from . import TITLE
from .campaign import AT_DEGC, MODELS, NAMES, REFERENCE_DEGC, campaign_text, recording_file
from .recordings import chamber_recording, static_recording, table_recordings
from .setup import AIR, AVERAGING, VACUUM, Bench
from .unit import Unit, draw_unit, polynomial_bias, reference_volts

__all__ = ["FAULTS", "RIG", "Bench", "build"]

Recordings = dict[str, Recording]
MODEL_DEGC = np.array([-30.0, 0.0, 40.0, 70.0])  # four points tell a cubic
FAULTS: dict[str, Fault] = {
    "no_temperature_change": Fault(
        "the chamber was never switched on", "no_temperature_change", {"set_points": (23.0, 23.0, 23.0, 23.0)}
    ),
    "missing_reference": Fault(
        "the reference voltages of the rates are missing", "missing_reference", {"reference_saved": False}
    ),
    "swapped_axes": Fault("the connectors x and y are exchanged", "axes_disagree", {"wiring": ("y", "x", "z")}),
    "inverted_sign": Fault(
        "the z sensor is not mounted inverted, though the campaign says so", "sign_disagrees", {"inverted": (-1, 1, 1)}
    ),
    "overlapping_windows": Fault("the windows of a fit and a hold-out test overlap", "overlap", {"overlapping": True}),
    "saturated_end": Fault(
        "the temperature channels saturate before the cold end of the ramp",
        "rail",
        {"nominal_shift": -0.9},
    ),
    "duplicate_recording": Fault(
        "the file of the second ramp in air is a copy of the first", "duplicate_recording", {"copied": True}
    ),
    "only_cooling": Fault("the chamber only cooled", "one_path", {"set_points": (67.0, -30.0)}),
    "wide_requirement": Fault(
        "the bias requirement goes beyond the temperatures of the ramps",
        "outside",
        {"required_degc": (-40.0, 85.0)},
        "covered",
    ),
    "no_zero_reference": Fault(
        "the rate table was never still",
        "never_still",
        {
            "rates_deg_s": (0.1, -0.1, 0.2, -0.2, 0.5, -0.5, 1.5, -1.5, 3.0, -3.0, 4.5, -4.5),
            "zero_reference": False,
        },
    ),
}


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
    stands = {
        "table": (bench.tilt_deg, bench.u_tilt_deg, bench.azimuth_deg, bench.u_azimuth_deg),
        "chamber": (
            bench.chamber_tilt_deg, bench.u_chamber_tilt_deg, bench.chamber_azimuth_deg, bench.u_chamber_azimuth_deg,
        ),
    }  # fmt: skip
    world, drawn = draw_world(bench.standards, bench.latitude_deg, bench.table_gain, stands, of_world)
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
    errors = table_errors(bench.standards, drawn, bench.latitude_deg)
    return Twin(
        text, files, true_values(own, bench.parts, bench.zero_reference), {**drawn, **drawn_of(own)}, errors=errors
    )


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


def true_values(unit: Unit, parts: tuple[str, ...], at_rest: bool = False) -> tuple[TrueValue, ...]:
    """Return the quantities of a unit that the tests of these parts find.

    Parameters
    ----------
    unit : Unit
        Whose.
    parts : tuple of str
        Of the campaign.
    at_rest : bool
        Whether the rate-table tests subtract the reading at rest, and so find no bias.
    """
    found = {"thermal": _thermal, "rate_table": _on_table, "noise": _noise}
    each = [value for part in parts for value in found[part](unit)]
    each = [value for value in each if not (at_rest and value.test == NAMES["rate_table"])]
    return (*each, *(_model(unit) if {"thermal", "rate_table"} <= set(parts) else ()))


def _model(unit: Unit) -> Iterator[TrueValue]:
    """Yield the bias over temperature of the models in air and in vacuum: that of the chamber."""
    for where, model in MODELS.items():
        bias = polynomial_bias(unit, where, MODEL_DEGC)
        for i, axis in enumerate(AXES):
            powers = np.polynomial.Polynomial.fit(MODEL_DEGC - REFERENCE_DEGC, bias[:, i], 3).convert()
            constant, *others = powers.coef
            yield TrueValue("bias", axis, float(constant), "rad/s", model)
            for j, value in enumerate(others, 1):
                name = "rad/s/degC" if j == 1 else f"rad/s/degC^{j}"
                yield TrueValue("bias_temperature", axis, float(value), name, model, power=j)


def _thermal(unit: Unit) -> Iterator[TrueValue]:
    bias = {where: polynomial_bias(unit, where, [REFERENCE_DEGC, *AT_DEGC]) for where in (AIR, VACUUM)}
    places = [None, *(At("temperature", float(one), "degC") for one in AT_DEGC)]
    for where in (AIR, VACUUM):
        test = NAMES[where]
        for row, at in enumerate(places):
            yield from _each("bias", bias[where][row], "rad/s", test, at)
        yield from _each("hysteresis", 2.0 * unit.hysteresis, "rad/s", test)
        yield from _each("thermal_lag", np.full(3, unit.lag), "s", test)
        yield from _each("warm_up_change", unit.start_up[where], "rad/s", test)
        yield from _each("warm_up_time_constant", np.full(3, unit.start_up_time[where]), "s", test)
        for which, quantity in enumerate(("reference_voltage", "temperature_reference_voltage")):
            yield from _each(quantity, reference_volts(unit, which, REFERENCE_DEGC), "V", test)
    for row, at in enumerate(places):
        offset = bias[VACUUM][row] - bias[AIR][row]
        yield from _each("vacuum_offset", offset, "rad/s", NAMES[VACUUM], at)


def _on_table(unit: Unit) -> Iterator[TrueValue]:
    model = unit.model
    matrix, own = model.matrix[0], np.diag(model.matrix[0])
    yield from _each("bias", unit.installation, "rad/s", NAMES["rate_table"])
    yield from _each("scale_factor", model.scale_factor * own, "V/(rad/s)")
    yield from _each("scale_factor_error", own - 1.0, "1")
    if model.scale_factor_asymmetry is not None:
        yield from _each("scale_factor_asymmetry", model.scale_factor_asymmetry, "1")
    for i, axis in enumerate(AXES):
        for j, other in enumerate(AXES):
            if j != i:
                yield TrueValue("cross_axis_sensitivity", axis + other, float(matrix[i, j]), "1")
                yield TrueValue("misalignment", axis + other, float(matrix[i, j] / own[i]), "rad")


def _noise(unit: Unit) -> Iterator[TrueValue]:
    yield from _each("angle_random_walk", unit.white * np.sqrt(AVERAGING), "rad/sqrt(s)")
    yield from _each("rate_random_walk", unit.walk, "rad/s/sqrt(s)")


def _each(quantity: str, values: Array, unit: str, test: str = "", at: At | None = None) -> Iterator[TrueValue]:
    for axis, value in zip(AXES, values, strict=True):
        yield TrueValue(quantity, axis, float(value), unit, test, at=at)


def drawn_of(unit: Unit) -> Drawn:
    """Return what else was drawn of a unit, for the file of the truth."""
    found: Mapping[str, Array] = {
        **{f"bias_volts_{where}": coefficients for where, coefficients in unit.bias_volts.items()},
        **{f"start_up_{where}": change for where, change in unit.start_up.items()},
        "installation": unit.installation,
        "hysteresis": unit.hysteresis,
        "reference_volts_of_rate": unit.reference_volts[0],
        "reference_volts_of_temperature": unit.reference_volts[1],
    }
    times = {f"start_up_time_{where}": float(time) for where, time in unit.start_up_time.items()}
    return {**{name: values.tolist() for name, values in found.items()}, **times, "lag": unit.lag}


TESTS = ("thermal", "rate_table", "static_noise")
RIG = Rig("npsat1", TITLE, on_bench(build, Bench()), FAULTS, tests=TESTS)
