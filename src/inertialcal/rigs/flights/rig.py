"""Rig of one head that flies several times: each flight is flipped, at temperatures of its own.

The head has the bias of its ground model, what that is off, a shift since the ground that changes with temperature, a
drift with age, and what each launch adds. Flips measure it with noise, an offset of the electronics and an error of the
scale factor that all of them share. Sizes are those of a microgravity head [1]_: a bias of 1000 ug, 5 ug/degC, moved by
20 ug.

References
----------
.. [1] Chestney and Sicker, NASA TM-106980, 1996, Tables 10, 14 and 19.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from ...core.campaign_text import Noted, toml_text
from ...core.constants import STANDARD_GRAVITY
from ...core.estimate import Array, Component, Estimate
from ...core.influence import Influence
from ...core.key import AXES, Key
from ...core.recording import Source
from ...files.models.model_json import dump_model
from ...files.text.table import Table
from ...sensors.model.assemble import model_from
from ...sensors.model.sensor_model import Item, SensorModel
from ..parts.campaign import campaign_head, drawn_error, drawn_errors, standard_tables
from ..protocol import Rig, on_bench
from ..twin import Extra, Fault, TrueValue, Twin
from . import TITLE

__all__ = ["FAULTS", "RIG", "Bench", "build", "fly"]

UG = 1e-6 * STANDARD_GRAVITY.value
YEAR = 365.25 * 86400.0
FLIPS, GROUND = "flips.csv", "ground.json"
SERIAL, GROUND_DATE = "head-7", "2018-05-01"
REFERENCE = 20.0  # [degC]
RANGE = (5.0, 40.0)  # [degC]
BENT = 1e-3  # standard uncertainty of the quadratic term of the ground model [ug/degC^2]
HEADER = ("flight", "date", "serial", "axis", "temperature [degC]", "bias [ug]", "u [ug]")
FAULTS: dict[str, Fault] = {
    "other_head": Fault("one flight is that of another head", "wrong_serial", {"other_head": True}, "refused"),
    "too_warm": Fault("one flip is warmer than the ground model goes", "outside_temperature_range",
                      {"too_warm": True}, "refused"),
    "older": Fault("the ground model is younger than the first flight", "older_than_ground",
                   {"ground_date": "2020-01-01"}, "refused"),
    "copied": Fault("one flight stands in the table twice", "flight_twice", {"copied": True}, "refused"),
    "in_g": Fault("one flight is in g, the others in ug", "unit_mixed", {"in_g": True}, "refused"),
    "other_sign": Fault("y of one flight has the other sign", "wrong_sign", {"other_sign": True}, "refused"),
    "exchanged": Fault("y and z of one flight are exchanged", "axes_exchanged", {"exchanged": True}, "refused"),
    "without_covariance": Fault("the ground model has no covariance", "ground_without_covariance",
                                {"covariance": False}),
    "two_flights": Fault("two flights alone", "too_few_flights", {"flights": 2}),
    "one_temperature": Fault("all flips at one temperature", "shift_over_temperature",
                             {"apart": 0.0, "temperatures": 0.0, "said_slope": 0.0}),
    "noisy_flips": Fault("flips of one flight differ by five times their uncertainties", "flips_differ",
                         {"noise_times": 5.0}),
    "knock": Fault("the head is knocked before the last flight", "prediction_missed", {"knock": 120.0}),
}  # fmt: skip


def _standards() -> dict[str, Influence]:
    return {
        "converter.zero": Influence(0.05 * UG, "m/s^2", certificate="simulated"),
        "sensor.scale_factor": Influence(1e-4, "1", certificate="simulated"),
    }


@dataclass(frozen=True)
class Bench:
    """The flights as they are flown; accelerations in ug."""

    flights: int = 6  # that shift the model; one more is held out
    between: float = 1.0  # years from flight to flight
    flips: int = 2  # in each flight
    apart: float = 4.0  # temperature of the last flip less that of the first [degC]
    temperatures: float = 3.0  # spread of the flights' [degC]
    noise: float = 0.4  # of a flip
    noise_times: float = 1.0  # true noise over that which is stated
    common: float = 20.0  # spread of the shift since the ground
    slope: float = 0.3  # spread of its change with temperature [ug/degC]
    drift: float = 2.0  # spread of the drift [ug/year]
    launch: float = 3.0  # standard deviation of what a launch shifts
    ground_bias: float = 15.0  # standard uncertainty of the ground model, and the error that it has
    ground_slope: float = 0.3  # the same of its slope [ug/degC]
    ground_date: str = GROUND_DATE
    said_slope: float = 0.5  # stated for what the shift may change with temperature [ug/degC]
    covariance: bool = True  # whether the ground model has it
    other_head: bool = False
    too_warm: bool = False
    copied: bool = False
    in_g: bool = False
    other_sign: bool = False
    exchanged: bool = False
    knock: float = 0.0  # what the last flight is shifted by
    standards: Mapping[str, Influence] = field(default_factory=_standards)


@dataclass(frozen=True)
class Row:
    """A row of the table of flips."""

    flight: str
    date: str
    serial: str
    axis: str
    temperature: float
    bias: float  # [ug]
    u: float  # [ug]
    true: float = 0.0  # bias along the axis of the head [ug]

    def cells(self) -> tuple[str, ...]:
        """Return its cells."""
        return (self.flight, self.date, self.serial, self.axis, f"{self.temperature:.2f}", f"{self.bias:.6g}",
                f"{self.u:g}")  # fmt: skip


@dataclass(frozen=True, eq=False)
class Flown:
    """What was drawn: ground model, errors of the standards, rows of all flips, truth of the test ``shifted``."""

    ground: SensorModel
    errors: Mapping[str, float]
    rows: list[Row]
    truth: tuple[TrueValue, ...]


def build(bench: Bench, seed: int) -> Twin:
    """Return the campaign that a bench gives.

    Parameters
    ----------
    bench : Bench
        The flights as they are flown.
    seed : int
        Of all draws.
    """
    made = fly(bench, seed)
    table = _table(_spoiled(bench, made.rows))
    text = "\n".join([",".join(HEADER), *(",".join(cells) for cells in zip(*table.cells, strict=True)), ""])
    extras = {FLIPS: Extra(table, text), GROUND: Extra(made.ground, dump_model(made.ground))}
    drawn = drawn_errors(bench.standards, made.errors)
    return Twin(campaign_text(bench), {}, made.truth, made.errors, extras, drawn)


def fly(bench: Bench, seed: int) -> Flown:
    """Return what is flown on a bench, by the seed of all draws."""
    of_head, of_ground, of_errors, of_flights = np.random.default_rng(seed).spawn(4)
    ground = _ground(bench, of_head)
    off = np.array([of_ground.normal(0.0, one, 3) for one in (bench.ground_bias, bench.ground_slope, BENT)]) * UG
    shift = of_head.normal(0.0, bench.common, 3) * UG + off[0]
    slope, drift = of_head.normal(0.0, bench.slope, 3) * UG + off[1], of_head.normal(0.0, bench.drift, 3) * UG
    errors = {f"{name}[{axis}]": drawn_error(one, of_errors) for name, one in bench.standards.items() for axis in "yz"}
    rows = _rows(bench, ground, (shift, slope, drift, off[2]), errors, of_flights)
    fitted = [one for one in rows if int(one.flight) <= bench.flights]
    last = (bench.flights - 1) * bench.between
    truth = []
    for axis in "yz":
        i = AXES.index(axis)
        T = float(np.mean([one.temperature for one in fitted if one.axis == axis]))
        level = shift[i] + slope[i] * (T - REFERENCE) + drift[i] * last
        truth.append(TrueValue("bias_shift", axis, float(level), "m/s^2", "shifted"))
        truth.append(TrueValue("bias_drift", axis, float(drift[i] / YEAR), "m/s^2/s", "shifted"))
        truth.append(TrueValue("bias_shift_slope", axis, float(slope[i]), "m/s^2/degC", "shifted"))
    return Flown(ground, errors, rows, tuple(truth))


def _ground(bench: Bench, rng: np.random.Generator) -> SensorModel:
    """Return the ground model: bias of some 1000 ug, 5 ug/degC, scale factors and misalignments of some 1e-3."""
    keys = [Key("bias", axis) for axis in AXES]
    sizes = rng.choice([-1.0, 1.0], 3) * (1000.0 + 250.0 * np.arange(3) + rng.uniform(0.0, 100.0, 3)) * UG
    values, units, u = list(sizes), ["m/s^2"] * 3, [bench.ground_bias * UG] * 3
    keys += [Key("bias_temperature", axis, power=1) for axis in AXES]
    values += list(rng.normal(0.0, 5.0, 3) * UG)
    units += ["m/s^2/degC"] * 3
    u += [bench.ground_slope * UG] * 3
    keys += [Key("bias_temperature", axis, power=2) for axis in AXES]
    values += list(rng.normal(0.0, 0.02, 3) * UG)
    units += ["m/s^2/degC^2"] * 3
    u += [BENT * UG] * 3
    for quantity, names in (
        ("scale_factor_error", AXES),
        ("misalignment", [a + b for a in AXES for b in AXES if a != b]),
    ):
        keys += [Key(quantity, name) for name in names]
        values += list(rng.normal(0.0, 1e-3, len(names)))
        units += ["1" if quantity == "scale_factor_error" else "rad"] * len(names)
        u += [1e-4] * len(names)
    parts = (Component("scatter of the ground test", "A", np.diag(np.square(u)), 30.0, "t"),)
    found = model_from(
        Estimate(tuple(keys), np.array(values), tuple(units), parts), "accelerometer", AXES,
        9.5 / STANDARD_GRAVITY.value,
        "V", reference_temperature=REFERENCE, temperature_range=RANGE, item=Item("inertialcal", "head", SERIAL),
        source="simulated: made on the ground",
    )  # fmt: skip
    return found if bench.covariance else replace(found, estimate=None)


def _rows(
    bench: Bench,
    ground: SensorModel,
    true: tuple[Array, Array, Array, Array],
    errors: Mapping[str, float],
    rng: np.random.Generator,
) -> list[Row]:
    """Return the flips of all flights, that which is held out last."""
    shift, slope, drift, bent = true
    assert ground.bias_temperature is not None  # noqa: S101 - as made above
    rows = []
    for flight in range(bench.flights + 1):
        year = 2019.0 + flight * bench.between
        date = str(np.datetime64(round((year - 1970.0) * YEAR), "s"))[:10]
        centre = 20.0 + rng.normal(0.0, bench.temperatures)
        launch = rng.normal(0.0, bench.launch, 3) * UG + (bench.knock * UG if flight == bench.flights else 0.0)
        for flip in range(bench.flips):
            T = round(float(centre + bench.apart * (flip / max(bench.flips - 1, 1) - 0.5)), 2)
            away = T - REFERENCE
            bias = ground.bias + ground.bias_temperature[0] * away + ground.bias_temperature[1] * away**2
            head = np.linalg.solve(ground.matrix[0], bias)
            true_bias = head + shift + slope * away + bent * away**2 + drift * flight * bench.between + launch
            for axis in "yz":
                i = AXES.index(axis)
                read = true_bias[i] * (1.0 + errors[f"sensor.scale_factor[{axis}]"]) + errors[f"converter.zero[{axis}]"]
                read += rng.normal(0.0, bench.noise * bench.noise_times) * UG
                rows.append(Row(str(flight + 1), date, SERIAL, axis, T, float(read / UG), bench.noise,
                                float(true_bias[i] / UG)))  # fmt: skip
    return rows


def _spoiled(bench: Bench, rows: list[Row]) -> list[Row]:
    """Return the rows as the engineer has them: with a mistake in the second flight."""
    made = []
    for one in rows:
        if one.flight != "2":
            made.append(one)
            continue
        warmer, times = 40.0 if bench.too_warm else 0.0, 1e-6 if bench.in_g else 1.0
        sign = -1.0 if bench.other_sign and one.axis == "y" else 1.0
        axis = {"y": "z", "z": "y"}[one.axis] if bench.exchanged else one.axis
        serial = "head-8" if bench.other_head else one.serial
        made.append(replace(one, serial=serial, axis=axis, temperature=one.temperature + warmer,
                            bias=sign * times * one.bias))  # fmt: skip
    again = [replace(one, flight="2b") for one in made if one.flight == "2" and bench.copied]
    return [*made, *again]


def _table(rows: list[Row]) -> Table:
    cells = tuple(zip(*(one.cells() for one in rows), strict=True))
    units = (None, None, None, None, "degC", "ug", "ug")
    return Table(HEADER, cells, np.arange(2, len(rows) + 2), Source(FLIPS), units)


def campaign_text(bench: Bench) -> str:
    """Return the text of campaign.toml, with the marks for the seed and for the seal of the truth."""
    flips = {
        "file": Noted(GROUND, "the ground model"), "flight": "flight", "date": "date", "axis": "axis",
        "temperature": "temperature [degC]", "bias": "bias [ug]", "u": "u [ug]", "serial": "serial", "unit": "ug",
    }  # fmt: skip
    plan = {"ground_date": bench.ground_date}
    plan |= {"shift_slope": f"{bench.said_slope:g} ug/degC"} if bench.said_slope else {}
    test = {"procedure": "shifted_model", "recordings": ["flips"], "plan": plan}
    flights = [str(number + 1) for number in range(bench.flights)] + (["2b"] if bench.copied else [])
    tests = [
        {"id": "shifted", **test, "groups": flights},
        Noted(
            {"id": "later", **test, "groups": [str(bench.flights + 1)], "use": "hold_out"},
            above="The last flight judges",
        ),
    ]
    title, about = (
        "Ground model of a simulated head, shifted by flips of several flights",
        "one head flies several times",
    )
    return toml_text(
        {
            **campaign_head("flights", "simulated triaxial sensor head", title, about) | {
                "item": {"maker": "inertialcal", "part": "head", "serial": SERIAL}},
            "standards": standard_tables(bench.standards, {"m/s^2": "ug"}),
            "sensors": {"head": {"kind": "accelerometer", "axes": list(AXES), "unit": "ug"}},
            "recordings": {"flips": {"sensor": "head", "file": FLIPS, "flips": flips}},
            "tests": tests,
            "requirements": [{"id": "R1", "text": "drift below 20 ug a year", "quantity": "bias_drift",
                              "limit": "20 ug/year", "tests": ["shifted"]}],
        }
    )  # fmt: skip


RIG = Rig("flights", TITLE, on_bench(build, Bench()), FAULTS, tests=("shifted_model",))
