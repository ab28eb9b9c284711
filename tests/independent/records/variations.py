"""The lines of issue 20 once more as an examiner would try them: other sizes, places, rates, units, layouts, orders.

Nothing here was looked at while the gate was built. A variation is a :class:`Fault` on bases of its own.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .. import flip, moved_mass, positions, rate_table, static, thermal
from ..case import START, Array, Case, Table
from ..faults import (
    ARCHIVE,
    ARW,
    BACKWARDS,
    COPY,
    GLITCH,
    RAIL,
    UNIT,
    Fault,
    backwards,
    grouped,
    scaled,
    spikes,
    stuck,
    temperature,
    unit_mid,
)  # fmt: skip
from .bases import SHARED

Rng = np.random.Generator


# Clean cases of other layouts


def counted(seed: int) -> Case:
    """Return a gyro in counts at 40 Hz, semicolons between columns; the code -32768 is that of its converter."""
    noise = static.Noise(white=0.01, flicker=0.002, bias=0.3)
    case = static.still(seed, noise, 50_000, 40.0, counts=0.01)
    case.tables["still.csv"].separator = ";"
    case.rail = -32768.0
    return case


def slow(seed: int) -> Case:
    """Return accelerometers in g at 10 Hz, for 6.5 cycles of 900 s."""
    return static.still(seed, static.Noise(white=2e-5, bias=3e-4), 58_500, 10.0, sensor="acc", step=1e-7)


def archive(seed: int) -> Case:
    """Return the real pair of the acceleration archive (../shared/data/README.md, pims_pad), from another second on."""
    file = next((SHARED / "pims_pad").glob("*.121f03006"))
    values = np.fromfile(file, dtype="<f4").reshape(-1, 4)[17 * seed :, 1:].astype(float)
    columns = {f"{axis} [g]": values[:, i] for i, axis in enumerate("xyz")}
    table = Table(columns, tuple(columns), kind="pad", pad={"rate": 142.0, "cutoff": 6.0, "start": START + 1e4 * seed})
    case = Case("allan", {"still.csv": table}, ["allan", "@"], {}, rate=142.0, rng_seed=seed)
    case.noise = 1e-5
    return case


def three(seed: int) -> Case:
    """Return three power-ups of each of three axes at 50 Hz, rates in shuffled order, files in reverse order."""
    protocol = rate_table.Protocol(runs=3, samples=120, rate=50.0, shuffled=True, rates=(-30.0, -12.0, 12.0, 30.0))
    case = rate_table.recorded(seed, rate_table.Gyros(turn_on=0.004, limit=250.0, sample=0.03), protocol, held_out=1)
    text = case.texts["campaign.toml"]
    before, _, rest = text.partition("recordings = [")
    names, _, after = rest.partition("]")
    case.texts["campaign.toml"] = f"{before}recordings = [{', '.join(reversed(names.split(', ')))}]{after}"
    return case


def three_means(seed: int) -> Case:
    """Return a table of means of three runs an axis, rates in shuffled order."""
    protocol = rate_table.Protocol(runs=3, shuffled=True, rates=(-90.0, -60.0, -30.0, 30.0, 60.0, 90.0))
    return rate_table.reduced(seed, rate_table.Gyros(turn_on=0.02, dwell=0.005, sample=0.05), protocol)


BASES: dict[str, Callable[[int], Case]] = {
    "allan:counts": counted,
    "allan:slow": slow,
    "allan:archive": archive,
    "rate_table:three": three,
    "rate_table:three_means": three_means,
    "positions:slow": lambda seed: positions.by_hand(seed, positions=18, rate=50.0, rest=8.0, turn=2.5),
    "thermal:three": lambda seed: thermal.ramped(
        seed, thermal.Unit(turn_on=0.002), thermal.Chamber(runs=3, interval=5.0, points=(25.0, 60.0, -30.0, 25.0),
        speeds=(0.02, 0.02, 0.02)), "xyz",
    ),
    "mass_attraction:three": lambda seed: moved_mass.moved(
        seed, moved_mass.Bench(shape="line", size=2.0), moved_mass.Schedule(runs=3, dwells=80)
    ),
    "flip:six": lambda seed: flip.turned(
        seed, flip.Head(white=30.0), flip.Programme(dwells=6, dwell=(300.0, 360.0), rate=10.0)
    ),
}  # fmt: skip


# What goes wrong


def _pick(case: Case, rng: Rng) -> Table:
    name = str(rng.choice(sorted(case.names)))
    case.spoiled = (name,)
    return case.tables[name]


def _numbers(table: Table, name: str) -> Array:
    return np.asarray(table.columns[name], dtype=float).copy()


def _set(table: Table, name: str, values: Array) -> None:
    kind = table.columns[name].dtype
    table.columns[name] = np.rint(values).astype(kind) if kind.kind in "iu" else values


def _spread(values: Array) -> float:
    return float(np.median(np.abs(np.diff(values, 2))) / 0.6745 / np.sqrt(6.0))


def at_end(case: Case, size: float, rng: Rng) -> None:
    """Put the code of the rail into the first or the last sample of one axis."""
    table = _pick(case, rng)
    name = str(rng.choice(list(table.signals)))
    table.columns[name][int(rng.choice([0, -1]))] = round(case.rail)


def bursts_of_five(case: Case, size: float, rng: Rng) -> None:
    table = _pick(case, rng)
    for name in table.signals:
        values = _numbers(table, name)
        for at in rng.choice(len(values) - 5, 4, replace=False):
            values[at : at + 5] += size * _spread(values) * rng.choice([-1.0, 1.0])
        _set(table, name, values)


def late_step(case: Case, size: float, rng: Rng) -> None:
    """The level of every axis steps down near the end or the beginning."""
    table = _pick(case, rng)
    at = round(float(rng.choice([0.12, 0.88])) * len(table))
    for name in table.signals:
        values = _numbers(table, name)
        values[at:] -= size * _spread(values)
        _set(table, name, values)


def wave(case: Case, size: float, rng: Rng) -> None:
    """A sine of 900 s on one axis."""
    table = _pick(case, rng)
    name = str(rng.choice(list(table.signals)))
    values = _numbers(table, name)
    time = np.arange(len(values)) / case.rate
    _set(table, name, values + 0.5 * size * _spread(values) * np.sin(2 * np.pi * (time / 900.0 + rng.random())))


def quieter(case: Case, size: float, rng: Rng) -> None:
    """The noise of one axis falls in its last quarter."""
    table = _pick(case, rng)
    name = str(rng.choice(list(table.signals)))
    values = _numbers(table, name)
    rest = slice(3 * len(values) // 4, None)
    values[rest] = np.median(values) + size * (values[rest] - np.median(values))
    _set(table, name, values)


def one_side(case: Case, size: float, rng: Rng) -> None:
    """Saturate the widest gyro on its negative side only."""
    table = _pick(case, rng)
    gyros = [name for name in table.signals if name.startswith("g")] or list(table.signals)
    name = max(gyros, key=lambda n: float(np.ptp(_numbers(table, n))))
    values = _numbers(table, name)
    _set(table, name, np.maximum(values, np.quantile(values, size)))


def four_low(case: Case, size: float, rng: Rng) -> None:
    """Four samples of one axis are held at the least value."""
    table = _pick(case, rng)
    name = str(rng.choice(list(table.signals)))
    values = _numbers(table, name)
    least = np.sort(values)[round(size) - 1]
    _set(table, name, np.maximum(values, least))


def radians_longer(case: Case, size: float, rng: Rng) -> None:
    """One run is in rad/s, and has more rows than the others: the table stood still longer before it."""
    table = _pick(case, rng)
    more = round(size)
    table.taken(np.concatenate([np.arange(more), np.arange(len(table))]))
    first = table.columns[table.time][more]
    table.columns[table.time][:more] = first - (more - np.arange(more)) / case.rate
    for name in table.signals:
        table.columns[name] = np.radians(table.columns[name])


def _axis_of(case: Case, name: str) -> str:
    """Return the column along the axis that a recording turns."""
    return next(one for one in case.tables[name].signals if one.startswith(f"g{name[0]} "))


def sign_of_one(case: Case, size: float, rng: Rng) -> None:
    """Of one run, only the gyro along the turned axis has its sign turned."""
    table = _pick(case, rng)
    name = _axis_of(case, case.spoiled[0])
    table.columns[name] = -table.columns[name]


def gain_first(case: Case, size: float, rng: Rng) -> None:
    """The first run about z reads too much, on all axes."""
    case.spoiled = ("z1.csv",)
    for name in case.tables["z1.csv"].signals:
        case.tables["z1.csv"].columns[name] *= 1.0 + size


def _rows(case: Case, rng: Rng) -> tuple[Table, Array]:
    table = next(iter(case.tables.values()))
    label = str(rng.choice(sorted(set(table.columns[table.run].tolist()))))
    case.spoiled = (label,)
    return table, table.columns[table.run] == label


def gain_of_one(case: Case, size: float, rng: Rng) -> None:
    """Of one run in a table of means, only the gyro along the turned axis reads too much."""
    table, rows = _rows(case, rng)
    name = f"g{case.spoiled[0][0]} [deg/s]"
    table.columns[name][rows] *= 1.0 + size


def means_radians(case: Case, size: float, rng: Rng) -> None:
    table, rows = _rows(case, rng)
    for name in table.signals:
        table.columns[name][rows] = np.radians(table.columns[name][rows])


def one_off(case: Case, size: float, rng: Rng) -> None:
    """One reading along the turned axis is off by a twentieth."""
    table = next(iter(case.tables.values()))
    at = int(rng.integers(len(table)))
    table.columns[f"g{table.columns['axis'][at]} [deg/s]"][at] *= 1.0 + size
    case.spoiled = (str(table.columns[table.run][at]),)


def swapped_runs(case: Case, size: float, rng: Rng) -> None:
    """The second file about z and the third about y have each other's names."""
    tables = case.tables
    tables["z2.csv"], tables["y3.csv"] = tables["y3.csv"], tables["z2.csv"]
    case.spoiled = ("z2.csv", "y3.csv")


def own_applied(case: Case, size: float, rng: Rng) -> None:
    """In one run the reading along the turned axis is a copy of the commanded rate."""
    table = _pick(case, rng)
    table.columns[_axis_of(case, case.spoiled[0])] = table.columns[table.applied].copy()


def hold_out_later(case: Case, size: float, rng: Rng) -> None:
    """The recording held out is a fitted one with later stamps."""
    for name in case.held_out:
        table = case.tables[f"{name[0]}2.csv"].copy()
        table.columns[table.time] = table.columns[table.time] + 86_400.0
        case.tables[name] = table
    case.spoiled = case.held_out


def copy_later(case: Case, size: float, rng: Rng) -> None:
    """One recording is another one with later stamps."""
    first, second = (str(name) for name in rng.choice(sorted(case.names), 2, replace=False))
    case.tables[second] = case.tables[first].copy()
    table = case.tables[second]
    table.columns[table.time] = table.columns[table.time] + 86_400.0
    case.spoiled = (first, second)


def copy_rounded(case: Case, size: float, rng: Rng) -> None:
    """The last run about x is the first one, written with a digit less."""
    table = case.tables["x1.csv"].copy()
    for name in table.signals:
        table.columns[name] = np.round(table.columns[name], 5)
    case.tables["x3.csv"] = table
    case.spoiled = ("x1.csv", "x3.csv")


def twice(case: Case, size: float, rng: Rng) -> None:
    """The record is appended to itself once, an hour later."""
    table = _pick(case, rng)
    n = len(table)
    table.taken(np.tile(np.arange(n), 2))
    time = table.columns[table.time]
    time[n:] += time[n - 1] - time[0] + 3600.0


def warm_stuck(case: Case, size: float, rng: Rng) -> None:
    """The first half of the temperatures is one value."""
    table = _pick(case, rng)
    values = table.columns[table.temperature]
    values[: round(size * len(values))] = values[0]


def unseen_row_2(case: Case, size: float, rng: Rng) -> None:
    """Stamps in a column of a name that says nothing step back once, at the second row or in the middle."""
    table = _pick(case, rng)
    time = np.asarray(table.columns[table.time], dtype=float)
    at = int(rng.choice([1, len(time) // 2]))
    time[at:] -= size / case.rate
    table.renamed(table.time, "col_7")
    case.words += ["--sample-rate", repr(case.rate)]


def units_of_acceleration(case: Case, size: float, rng: Rng) -> None:
    """Accelerations go on in g instead of m/s2."""
    table = _pick(case, rng)
    rest = slice(round(rng.uniform(0.3, 0.8) * len(table)), None)
    for name in table.signals:
        if name.startswith("acc"):
            table.columns[name][rest] /= 9.80665


def sign_of_one_axis(case: Case, size: float, rng: Rng) -> None:
    """From some sample on, one axis has the other sign: the one with the most to show."""
    table = _pick(case, rng)
    at = round(rng.uniform(0.35, 0.65) * len(table))
    name = max(table.signals, key=lambda one: float(np.ptp(_numbers(table, one))))
    table.columns[name][at:] *= -1.0


def exchanged(case: Case, size: float, rng: Rng) -> None:
    """From some sample on, two axes are in each other's columns."""
    table = _pick(case, rng)
    at = round(rng.uniform(0.35, 0.65) * len(table))
    signals = sorted(table.signals, key=lambda one: float(np.ptp(_numbers(table, one))))
    first, second = (
        signals[-1],
        next(one for one in reversed(signals[:-1]) if one[:3] == signals[-1][:3] or one[0] == "g"),
    )
    a, b = table.columns[first].copy(), table.columns[second].copy()
    table.columns[first][at:], table.columns[second][at:] = b[at:], a[at:]


def grouped_reading(case: Case, size: float, rng: Rng) -> None:
    """Only the pulses are quoted and grouped; the file has tabs."""
    grouped(case, size, rng)
    case.tables[case.spoiled[0]].separator = "\t"


def stated_zero(case: Case, size: float, rng: Rng) -> None:
    """The command says that a standard has no uncertainty."""
    zero = {"thermal": "thermometer.temperature=0 degC", "mass_attraction": "source_mass.density=0 %"}[case.procedure]
    if "--standard" in case.words:
        case.words[case.words.index("--standard") + 1] = zero
    else:
        case.words += ["--standard", zero]


_TABLE = (
    Fault("v_glitch_at_end", "-32768 in the first or last sample", 0.0, "", ("allan:counts",), GLITCH, at_end,
          issue="one glitch of -32768", keeps=ARW),
    Fault("v_spikes_20", "1e-4 of the samples", 20.0, "sigma", ("allan:counts", "positions:slow", "rate_table:three"),
          GLITCH, spikes, issue="1e-4 spikes of 50 sigma", keeps=ARW),
    Fault("v_bursts_5", "5 samples in a row, to one side", 20.0, "sigma", ("allan:counts", "rate_table:three"), GLITCH,
          bursts_of_five, issue="bursts", keeps=ARW),
    Fault("v_step_late", "every axis steps at 12 or 88 %", 1.1, "sigma", ("allan:counts", "allan:slow"),
          ("level_step",), late_step, issue="level step of 72 deg/h"),
    Fault("v_wave", "6.5 cycles of 900 s on one axis", 0.4, "sigma", ("allan:slow",), ("slow_wave",), wave,
          issue="10 min thermostat, six cycles"),
    Fault("v_quieter", "the noise falls by a third in the last quarter", 0.67, "", ("allan:slow",), ("noise_change",),
          quieter, issue="changes of noise level"),
    Fault("v_clip_one_side", "saturated below only", 0.03, "", ("positions:slow", "rate_table:three"), RAIL, one_side,
          issue="gyro clipped, 5 % of samples"),
    Fault("v_four_low", "held at the least value", 4.0, "samples", ("allan:slow", "flip:six"), RAIL,
          four_low, issue="saturation from 4 held samples"),
    Fault("v_stuck_50", "one code for so many samples", 50.0, "samples", ("allan:slow", "flip:six"), ("stuck",), stuck,
          issue="stuck codes"),
    Fault("v_radians_longer", "1 run in rad/s, with more rows", 250.0, "rows", ("rate_table:three",),
          ("unit_disagrees",), radians_longer, issue="1 of 5 runs in rad/s", model=False),
    Fault("v_radians_means", "1 of 3 runs in rad/s", 0.0, "", ("rate_table:three_means",), ("unit_disagrees",),
          means_radians, issue="1 of 5 runs in rad/s", model=False),
    Fault("v_sign_of_one", "1 channel of 1 run with its sign turned", 0.0, "", ("rate_table:three",),
          ("sign_disagrees",), sign_of_one, issue="sign of a run flipped", model=False),
    Fault("v_sign_thermal", "1 of 3 runs with its sign turned", 1.0, "", ("thermal:three", "mass_attraction:three"),
          ("sign_disagrees",), lambda case, size, rng: _run_of(case, rng, -1.0), issue="sign of a run flipped",
          model=False),
    Fault("v_radians_thermal", "1 of 3 runs in rad/s", 0.0, "", ("thermal:three",), ("unit_disagrees",),
          lambda case, size, rng: _run_of(case, rng, np.pi / 180.0), issue="1 of 5 runs in rad/s", model=False),
    Fault("v_gain_first", "the first run about z reads more", 0.02, "", ("rate_table:three",), ("gain_disagrees",),
          gain_first, issue="gain of 2 % in one run", model=False),
    Fault("v_gain_of_one", "one channel of one run reads more", 0.02, "", ("rate_table:three_means",),
          ("gain_disagrees",), gain_of_one, issue="gain of 2 % in one run", model=False),
    Fault("v_one_off", "one reading is off", 0.05, "", ("rate_table:three_means",), ("reading_disagrees",), one_off,
          issue="one reading of +100", model=False),
    Fault("v_swapped_runs", "z2 and y3 have each other's names", 0.0, "", ("rate_table:three",), ("axes_disagree",),
          swapped_runs, issue="x and y files swapped", model=False),
    Fault("v_own_applied", "one run: reading = commanded rate", 0.0, "", ("rate_table:three",), ("copy_of_applied",),
          own_applied, issue="equal readings and applied rates", model=False),
    Fault("v_hold_out_later", "hold-out: a copy with later stamps", 0.0, "", ("rate_table:three",), COPY,
          hold_out_later, issue="hold-out a byte copy of the fit", model=False),
    Fault("v_copy_later", "one recording again, with later stamps", 0.0, "",
          ("thermal:three", "mass_attraction:three", "rate_table:three"), COPY, copy_later,
          issue="runs 2-5 byte copies of run 1", model=False),
    Fault("v_copy_rounded", "one recording again, with a digit less", 0.0, "", ("rate_table:three",), COPY,
          copy_rounded, issue="runs 2-5 byte copies of run 1", model=False, limit="a hash does not see it"),
    Fault("v_twice", "appended once, an hour later", 0.0, "", ("allan:counts", "allan:slow"), ("repeated", *COPY),
          twice, issue="a recording appended four times"),
    Fault("v_temperature_low", "ten temperatures of this", -300.0, "degC", ("thermal:three",),
          ("impossible_temperature",), temperature, issue="temperature of -400 or 50,000 degC"),
    Fault("v_temperature_stuck", "the first half is stuck", 0.5, "", ("thermal:three",), ("stuck",), warm_stuck,
          issue="half of the temperatures stuck"),
    Fault("v_backwards_row_2", "stamps that nothing names step back once", 3.0, "samples", ("allan:slow",), BACKWARDS,
          unseen_row_2, issue="backward stamps where time is not recognised"),
    Fault("v_backwards", "the clock jumps back", 2.0, "samples", ("allan:counts", "rate_table:three"), BACKWARDS,
          backwards, issue="backward stamps"),
    Fault("v_unit_acc", "m/s2 to g in mid-record", 0.0, "", ("positions:slow",), UNIT, units_of_acceleration,
          issue="unit changing in mid-record", model=False),
    Fault("v_unit_radians", "rad/s to deg/s in mid-record", 180.0 / np.pi, "", ("rate_table:three",), UNIT, unit_mid,
          issue="unit changing in mid-record", model=False),
    Fault("v_unit_milli", "ug to mg in mid-record", 1e-3, "", ("flip:six", "allan:slow"), UNIT, unit_mid,
          issue="unit changing in mid-record", model=False),
    Fault("v_sign_axis", "one axis turns its sign in mid-record", 0.0, "", ("rate_table:three", "positions:slow"),
          ("sign_changed",), sign_of_one_axis, issue="sign changing in mid-record", model=False),
    Fault("v_exchanged", "two axes change places in mid-record", 0.0, "", ("rate_table:three", "positions:slow"),
          ("axes_changed",), exchanged, issue="sensor changing in mid-record", model=False),
    Fault("v_grouped", "quoted digits, tabs, one column", 0.0, "", ("mass_attraction:three",), ("grouped_digits",),
          grouped_reading, issue='quoted "1,242" read as 1.242'),
    Fault("v_stated_zero", "--standard NAME=0", 0.0, "", ("thermal:three", "mass_attraction:three"),
          ("zero_uncertainty",), stated_zero, issue='rate = { u = "0 %" }'),
    Fault("v_scaled_1e3", "the real archive file 1e3 times too large", 1e3, "", ("allan:archive",), ARCHIVE, scaled,
          issue="archive data scaled by 1e3 or 1e6"),
    Fault("v_scaled_1e6", "the real archive file 1e6 times too large", 1e6, "", ("allan:archive",), ARCHIVE, scaled,
          issue="archive data scaled by 1e3 or 1e6"),
)  # fmt: skip


def _run_of(case: Case, rng: Rng, factor: float) -> None:
    """Multiply the readings of one run."""
    table = _pick(case, rng)
    for name in table.signals:
        values = _numbers(table, name)
        middle = float(np.mean(values)) if case.procedure == "mass_attraction" else 0.0  # the drive's sign
        _set(table, name, middle + factor * (values - middle))


VARIATIONS: dict[str, Fault] = {fault.name: fault for fault in _TABLE}
