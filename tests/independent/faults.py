"""What goes wrong in a laboratory, by name and size: each fault spoils the files of a case before they are written.

:data:`FAULTS` is the table: what the fault does, on which procedures it is tried, what the commands are to make of it:

``named``
    a remark or refusal with one of the codes, which names a spoiled recording (any, where the fault is in all);
``covered``
    nothing need be said: the stated intervals hold the truth;
``absent``
    no row of this quantity may appear: it would be false.

``codes`` are the few apt words for a fault, by the manual; any other remark or refusal does not count. ``issue`` is the
line of issue 20 that a fault stands for; faults without one belong to other issues.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .case import Array, Case, Table
from .moved_mass import shape
from .static import Noise, low_passed

Spoil = Callable[[Case, float, np.random.Generator], None]


@dataclass(frozen=True)
class Fault:
    """One line of the table."""

    name: str
    does: str
    size: float
    unit: str
    on: tuple[str, ...]  # procedures
    codes: tuple[str, ...]
    spoil: Spoil
    expects: str = "named"  # or covered, absent
    limit: str = ""  # what is known not to work
    issue: str = ""  # line of issue 20
    model: bool = True  # whether a model may be written all the same
    keeps: str = ""  # quantity that comes back as in the clean record, of a sensor at rest


def spoiled(case: Case, fault: Fault | str, size: float | None = None) -> Case:
    """Return a copy of the case with this fault in it; the place is drawn from the seed."""
    fault = FAULTS[fault] if isinstance(fault, str) else fault
    if case.procedure not in {one.split(":")[0] for one in fault.on}:
        raise ValueError(f"{fault.name} is for {', '.join(fault.on)}, not for {case.procedure}")
    found = case.copy()
    rng = np.random.default_rng([8, case.rng_seed, *fault.name.encode()])
    fault.spoil(found, fault.size if size is None else size, rng)
    return found


# Helpers: which table, which signal, which sample


def _table(case: Case, rng: np.random.Generator) -> Table:
    name = str(rng.choice(sorted(case.names)))
    case.spoiled = (name,)
    return case.tables[name]


def _signal(table: Table, rng: np.random.Generator) -> str:
    return str(rng.choice(list(table.signals)))


def _put(table: Table, name: str, values: Array) -> None:
    old = table.columns[name]
    table.columns[name] = np.rint(values).astype(old.dtype) if old.dtype.kind in "iu" else values.astype(old.dtype)


def _sigma(table: Table, name: str) -> float:
    """Return the standard deviation of a sample from second differences: what a glitch is measured by."""
    second = np.diff(np.asarray(table.columns[name], dtype=float), 2)
    return float(np.median(np.abs(second)) / 0.6745 / np.sqrt(6.0))


def _each(case: Case, act: Callable[[Table], None]) -> None:
    for name in case.names:
        act(case.tables[name])
    case.spoiled = case.names


# Single samples, levels, waves


def glitch(case: Case, size: float, rng: np.random.Generator) -> None:
    table = _table(case, rng)
    name = _signal(table, rng)
    values = np.asarray(table.columns[name], dtype=float)
    values[rng.integers(len(values) // 10, len(values) - len(values) // 10)] = case.rail or -size * _sigma(table, name)
    _put(table, name, values)


def spikes(case: Case, size: float, rng: np.random.Generator) -> None:
    table = _table(case, rng)
    for name in table.signals:
        values = np.asarray(table.columns[name], dtype=float)
        at = rng.choice(len(values), max(1, round(1e-4 * len(values))), replace=False)
        values[at] += size * _sigma(table, name) * rng.choice([-1.0, 1.0], len(at))
        _put(table, name, values)


def bursts(case: Case, size: float, rng: np.random.Generator) -> None:
    table = _table(case, rng)
    for name in table.signals:
        values = np.asarray(table.columns[name], dtype=float)
        for at in rng.choice(len(values) - 3, max(3, round(5e-5 * len(values))), replace=False):
            values[at : at + 3] += size * _sigma(table, name) * rng.standard_normal(3)
        _put(table, name, values)


def level_step(case: Case, size: float, rng: np.random.Generator) -> None:
    table = _table(case, rng)
    name = _signal(table, rng)
    values = np.asarray(table.columns[name], dtype=float)
    values[round(rng.uniform(0.25, 0.75) * len(values)) :] += size * _sigma(table, name)
    _put(table, name, values)


def thermostat(case: Case, size: float, rng: np.random.Generator) -> None:
    table = _table(case, rng)
    time = np.asarray(table.columns[table.time], dtype=float)
    for name in table.signals:
        wave = 0.5 * size * _sigma(table, name) * np.sin(2.0 * np.pi * ((time - time[0]) / 600.0 + rng.random()))
        _put(table, name, np.asarray(table.columns[name], dtype=float) + wave)


def noise_changed(case: Case, size: float, rng: np.random.Generator) -> None:
    table = _table(case, rng)
    name = _signal(table, rng)
    values = np.asarray(table.columns[name], dtype=float)
    half = len(values) // 2
    values[half:] += np.sqrt(size**2 - 1.0) * _sigma(table, name) * rng.standard_normal(len(values) - half)
    _put(table, name, values)


# Converter and logger


def clipping(case: Case, size: float, rng: np.random.Generator) -> None:
    """Saturate the signal of the widest range symmetrically, so that the part ``size`` of its samples is held."""
    table = _table(case, rng)
    gyros = [name for name in table.signals if "gyro" in name] or list(table.signals)
    name = max(gyros, key=lambda n: float(np.ptp(np.asarray(table.columns[n], dtype=float))))
    values = np.asarray(table.columns[name], dtype=float)
    middle = float(np.median(values))
    level = float(np.quantile(np.abs(values - middle), 1.0 - size))
    _put(table, name, np.clip(values, middle - level, middle + level))


def clipping_few(case: Case, size: float, rng: np.random.Generator) -> None:
    """Cut the largest samples of a signal, so that the value of the greatest one is held ``size`` times."""
    table = _table(case, rng)
    gyros = [name for name in table.signals if "gyro" in name] or list(table.signals)
    name = max(gyros, key=lambda n: float(np.ptp(np.asarray(table.columns[n], dtype=float))))
    values = np.asarray(table.columns[name], dtype=float)
    _put(table, name, np.minimum(values, np.sort(values)[-round(size)]))


def stuck(case: Case, size: float, rng: np.random.Generator) -> None:
    table = _table(case, rng)
    name, n = _signal(table, rng), round(size)
    first = int(rng.integers(len(table) // 4, len(table) // 2))
    table.columns[name][first : first + n] = table.columns[name][first]


def doubled(case: Case, size: float, rng: np.random.Generator) -> None:
    """Save every n-th sample again in place of the next one: stamps go on."""
    table = _table(case, rng)
    at = rng.choice(len(table) - 1, round(size * len(table)), replace=False)
    for name in table.signals:
        table.columns[name][at + 1] = table.columns[name][at]


def lost(case: Case, size: float, rng: np.random.Generator) -> None:
    table = _table(case, rng)
    table.taken(rng.random(len(table)) >= size)


def backwards(case: Case, size: float, rng: np.random.Generator) -> None:
    table = _table(case, rng)
    time = table.columns[table.time]
    time[len(time) // 2 :] -= size * (time[1] - time[0])


def backwards_unseen(case: Case, size: float, rng: np.random.Generator) -> None:
    """The column of time has a name that says nothing, so the sample rate is given."""
    backwards(case, size, rng)
    table = case.tables[case.spoiled[0]]
    table.renamed(table.time, "q1")
    case.words += ["--sample-rate", repr(case.rate)]


def wrong_rate(case: Case, size: float, rng: np.random.Generator) -> None:
    def act(table: Table) -> None:
        time = table.columns[table.time]
        table.columns[table.time] = time[0] + size * (time - time[0])

    _each(case, act)


# Units, signs, axes


def _part(case: Case, rng: np.random.Generator) -> tuple[Table, slice]:
    table = _table(case, rng)
    return table, slice(round(rng.uniform(0.4, 0.7) * len(table)), None)


def unit_mid(case: Case, size: float, rng: np.random.Generator) -> None:
    table, rest = _part(case, rng)
    for name in table.signals:
        values = np.asarray(table.columns[name], dtype=float)
        values[rest] *= size
        _put(table, name, values)


def axes_mid(case: Case, size: float, rng: np.random.Generator) -> None:
    """From the middle on, another sensor is read: axes in another order, another bias."""
    table, rest = _part(case, rng)
    old = {name: np.asarray(table.columns[name], dtype=float).copy() for name in table.signals}
    for name, other in zip(table.signals, (*table.signals[1:], table.signals[0]), strict=True):
        values = old[name].copy()
        values[rest] = old[other][rest] + size * _sigma(table, name)
        _put(table, name, values)


def _one_run(case: Case, rng: np.random.Generator, act: Callable[[Array], Array]) -> None:
    """Act on the readings of one run: of a recording, or of the rows of one run in a table of means."""
    table = _table(case, rng)
    rows = np.ones(len(table), dtype=bool)
    if table.kind == "reduced" and table.run:
        label = str(rng.choice(sorted({str(one) for one in table.columns[table.run]})))
        rows = np.array([str(one) == label for one in table.columns[table.run]])
        case.spoiled = (label,)
    for name in table.signals:
        values = np.asarray(table.columns[name], dtype=float)
        values[rows] = act(values[rows])
        _put(table, name, values)


def run_radians(case: Case, size: float, rng: np.random.Generator) -> None:
    _one_run(case, rng, lambda values: np.radians(values) * size)


def run_sign(case: Case, size: float, rng: np.random.Generator) -> None:
    """Turn the sign of the readings, of counted pulses that of the response."""
    pulses = case.procedure == "mass_attraction"
    _one_run(case, rng, lambda values: (2.0 * float(np.mean(values)) if pulses else 0.0) - size * values)


def run_gain(case: Case, size: float, rng: np.random.Generator) -> None:
    _one_run(case, rng, lambda values: (1.0 + size) * values)


def swapped_files(case: Case, size: float, rng: np.random.Generator) -> None:
    """The files of the first turn about x and about y have each other's names."""
    tables = case.tables
    tables["x1.csv"], tables["y1.csv"] = tables["y1.csv"], tables["x1.csv"]
    case.spoiled = ("x1.csv", "y1.csv")


def one_reading(case: Case, size: float, rng: np.random.Generator) -> None:
    table = _table(case, rng)
    name = _signal(table, rng)
    table.columns[name][int(rng.integers(len(table)))] = size


def equal_to_applied(case: Case, size: float, rng: np.random.Generator) -> None:
    """The readings along the axis that is turned are a copy of the commanded rates."""
    for name in case.names:
        table = case.tables[name]
        for signal in table.signals:
            axis = signal[1]
            rows = table.columns["axis"] == axis if "axis" in table.columns else np.full(len(table), name[0] == axis)
            table.columns[signal][rows] = table.columns[table.applied][rows]
    case.spoiled = case.names


# Copies


def copies(case: Case, size: float, rng: np.random.Generator) -> None:
    """Every other recording (of an axis) is the same file as the first one."""
    firsts: dict[str, str] = {}
    for name in case.names:
        first = firsts.setdefault(name[0], name)
        case.tables[name] = case.tables[first].copy()
    case.spoiled = tuple(name for name in case.names if name not in firsts.values())


def hold_out_copy(case: Case, size: float, rng: np.random.Generator) -> None:
    for name in case.held_out:
        source = next(other for other in case.names if other[0] == name[0])
        case.tables[name] = case.tables[source].copy()
    case.spoiled = case.held_out


def appended(case: Case, size: float, rng: np.random.Generator) -> None:
    """Append the recording to itself, so that it stands there ``size`` times; its clock goes on."""

    def act(table: Table) -> None:
        n, times = len(table), round(size)
        table.taken(np.tile(np.arange(n), times))
        if table.time:
            time = table.columns[table.time].reshape(times, n)
            step = (time[0, -1] - time[0, 0]) * n / (n - 1)
            table.columns[table.time] = (time + step * np.arange(times)[:, None]).ravel()

    if case.procedure == "flip":
        act(_table(case, rng))
    else:
        _each(case, act)


# Temperature


def temperature(case: Case, size: float, rng: np.random.Generator) -> None:
    table = _table(case, rng)
    first = int(rng.integers(len(table) // 4, len(table) // 2))
    table.columns[table.temperature][first : first + 10] = size


def temperature_stuck(case: Case, size: float, rng: np.random.Generator) -> None:
    table = _table(case, rng)
    values = table.columns[table.temperature]
    first = round((1.0 - size) * len(values))
    values[first:] = values[first]


# Text


def grouped(case: Case, size: float, rng: np.random.Generator) -> None:
    """Spreadsheet digits: in a file with semicolons every number from 1,000 on is written as "1,242"."""
    table = _table(case, rng)
    table.separator = ";"
    names = (*table.signals, table.applied) if table.applied else table.signals
    places = [list(table.columns).index(name) for name in names]

    def rows(cells: list[list[str]]) -> list[list[str]]:
        for row in cells[1:]:
            for i in places:
                row[i] = f'"{float(row[i]):,.0f}"'
        return cells

    table.rows = rows


def zero_u(case: Case, size: float, rng: np.random.Generator) -> None:
    text = case.texts["campaign.toml"]
    case.texts["campaign.toml"] = text + '\n[standards.rate_table]\nrate = { u = "0 %" }\n'


# Archive


def scaled(case: Case, size: float, rng: np.random.Generator) -> None:
    def act(table: Table) -> None:
        for name in table.signals:
            table.columns[name] = table.columns[name] * size

    _each(case, act)


def filtered(case: Case, size: float, rng: np.random.Generator) -> None:
    """Pass a record through a low pass of ``size`` Hz, 120 dB down in the stop band, and store 32-bit numbers."""
    from scipy.signal import cheby2, sosfilt

    def act(table: Table) -> None:
        sos = cheby2(12, 120.0, 1.5 * size, fs=case.rate, output="sos")
        for name in table.signals:
            values = sosfilt(sos, np.asarray(table.columns[name], dtype=float))
            table.columns[name] = values.astype(np.float32).astype(float)
        table.pad["cutoff"] = size

    _each(case, act)


# Positions and flips


def separate_stamps(case: Case, size: float, rng: np.random.Generator) -> None:
    """Save accelerometers and gyros in files of their own, as a phone does: one clock, stamps apart by a part."""
    table = case.tables.pop("hand.csv")
    n = len(table)
    for sensor, late in (("acc", 0.0), ("gyro", size)):
        signals = tuple(name for name in table.signals if name.startswith(sensor))
        stamps = table.columns[table.time] + (late + 0.02 * rng.standard_normal(n)) / case.rate
        columns = {table.time: stamps} | {name: table.columns[name] for name in signals}
        part = Table(columns, signals, table.time, form={**table.form, table.time: "%.6f"})
        if sensor == "gyro":
            part.taken(slice(3, n))
        case.tables[f"{sensor}.csv"] = part
    at = case.words.index("@hand.csv")
    case.words[at : at + 1] = ["acc=@acc.csv", "gyro=@gyro.csv"]
    case.spoiled = ("acc.csv", "gyro.csv")


def wrong_label(case: Case, size: float, rng: np.random.Generator) -> None:
    """Name the position of one dwell wrongly."""
    places = [i for i, word in enumerate(case.words) if word.endswith(" deg") and ".." in word]
    at = int(rng.choice(places))
    span, angle = case.words[at].split("=")
    case.words[at] = f"{span}={180 - int(angle.split()[0])} deg"
    case.spoiled = case.names


# Moved mass


def _response(case: Case) -> float:
    return 100.0 * case.truth["scale_factor x"] * 0.023  # counts a gate


def repeating_drift(case: Case, size: float, rng: np.random.Generator) -> None:
    def act(table: Table) -> None:
        name = table.signals[0]
        drift = size * _response(case) * shape("exp10", len(table), rng)
        _put(table, name, np.asarray(table.columns[name], dtype=float) + drift)

    _each(case, act)


def jump(case: Case, size: float, rng: np.random.Generator) -> None:
    at = int(rng.integers(20, 80))

    def act(table: Table) -> None:
        values = np.asarray(table.columns[table.signals[0]], dtype=float)
        values[at:] += size * _response(case)
        _put(table, table.signals[0], values)

    _each(case, act)


def gain_mid(case: Case, size: float, rng: np.random.Generator) -> None:
    table, rest = _part(case, rng)
    values = np.asarray(table.columns[table.signals[0]], dtype=float)
    middle = float(np.mean(values))
    values[rest] = middle + size * (values[rest] - middle)
    _put(table, table.signals[0], values)


def gain_mid_all(case: Case, size: float, rng: np.random.Generator) -> None:
    """Change the gain at the same dwell of every run."""
    at = int(rng.integers(40, 70))

    def act(table: Table) -> None:
        values = np.asarray(table.columns[table.signals[0]], dtype=float)
        middle = float(np.mean(values))
        values[at:] = middle + size * (values[at:] - middle)
        _put(table, table.signals[0], values)

    _each(case, act)


def slip(case: Case, size: float, rng: np.random.Generator) -> None:
    """From the middle on the mass is one dwell late: what was read belongs to the dwell before."""
    table = _table(case, rng)
    name, at = table.signals[0], len(table) // 2
    values = table.columns[name].copy()
    values[at + 1 :] = table.columns[name][at:-1]
    table.columns[name] = values


def turn_on(case: Case, size: float, rng: np.random.Generator) -> None:
    """Give each run an offset of its own."""
    for name in case.names:
        table = case.tables[name]
        labels = table.columns[table.run] if table.kind == "reduced" and table.run else np.zeros(len(table))
        offsets = {label: size * rng.standard_normal(len(table.signals)) for label in dict.fromkeys(labels.tolist())}
        for i, signal in enumerate(table.signals):
            table.columns[signal] = table.columns[signal] + np.array([offsets[label][i] for label in labels.tolist()])
    case.spoiled = case.names


def low_pass(case: Case, size: float, rng: np.random.Generator) -> None:
    """Replace the white noise by that behind a first-order filter of ``size`` Hz, of the same level at f = 0."""
    table = case.tables[case.names[0]]
    for name in table.signals:
        values = np.asarray(table.columns[name], dtype=float)
        white = case.noise / np.sqrt(case.rate)
        drawn = low_passed(rng, Noise(white=white, corner=size), len(values), 1.0 / case.rate)
        _put(table, name, drawn + float(np.mean(values)))
    case.spoiled = case.names


STILL, REAL, PAD = "allan", "allan:real", "allan:pad"
TABLE, MEANS, FAST, PLAIN = "rate_table", "rate_table:means", "rate_table:fast", "rate_table:unlabelled"
HAND, HOT, MASS, TURN = "positions", "thermal", "mass_attraction", "flip"
FILES = (STILL, TABLE, HAND, HOT, TURN)  # recordings of samples

GLITCH = ("glitch", "disturbed")
BACKWARDS = ("time_backwards",)
UNIT = ("unit_changed", "scale_changed")
RAIL = ("saturated",)
COPY = ("duplicate_recording",)
ARCHIVE = ("impossible_acceleration", "beyond_range", "implausible_acceleration")
ARW = "angle_random_walk"

_TABLE = (
    Fault(
        "glitch", "one sample of -32768 counts", 3000.0, "sigma", (*FILES, REAL), GLITCH, glitch,
        issue="one glitch of -32768", keeps=ARW,
    ),
    Fault(
        "spikes", "1e-4 of the samples", 50.0, "sigma", (*FILES, REAL), GLITCH, spikes,
        issue="1e-4 spikes of 50 sigma", keeps=ARW,
    ),
    Fault(
        "bursts", "3 samples in a row", 50.0, "sigma", (*FILES, REAL), GLITCH, bursts, issue="bursts", keeps=ARW,
    ),
    Fault(
        "level_step", "the level steps once", 1.1, "sigma", (STILL,), ("level_step",), level_step,
        issue="level step of 72 deg/h",
    ),
    Fault(
        "thermostat", "a wave of 10 min, six cycles", 0.3, "sigma", ("allan:hour",), ("slow_wave",), thermostat,
        issue="10 min thermostat, six cycles",
    ),
    Fault(
        "noise_changed", "noisier from the middle on", 2.0, "", (STILL,), ("noise_change",), noise_changed,
        issue="changes of noise level",
    ),
    Fault(
        "clipping", "saturated in this part of the samples", 0.05, "", (STILL, HAND), RAIL, clipping,
        issue="gyro clipped, 5 % of samples",
    ),
    Fault(
        "clipping_table", "saturated at its fastest rate", 0.1, "", (TABLE,), RAIL, clipping,
        issue="gyro clipped, 5 % of samples",
    ),
    Fault(
        "clipping_few", "held at the range's end", 4.0, "samples", (STILL, HAND, TABLE), RAIL, clipping_few,
        issue="saturation from 4 held samples",
    ),
    Fault(
        "stuck", "one code for so many samples", 400.0, "samples", (STILL, TABLE, HAND), ("stuck",), stuck,
        issue="stuck codes",
    ),
    Fault(
        "stuck_slow", "one code for so many samples", 60.0, "samples", (HOT,), ("stuck",), stuck, issue="stuck codes"
    ),
    Fault(
        "doubled", "this part of the samples is saved twice", 0.02, "", (STILL,), ("repeated_samples",), doubled,
        issue="missing and doubled samples",
    ),
    Fault(
        "lost", "this part of the samples is missing", 0.05, "", (STILL, TABLE, HAND), ("gaps", "missing"), lost,
        issue="missing and doubled samples",
    ),
    Fault(
        "backwards", "the clock jumps back", 50.0, "samples", FILES, BACKWARDS, backwards, issue="backward stamps"
    ),
    Fault(
        "backwards_unseen", "it jumps back in a column that is not taken for time", 50.0, "samples", (STILL,),
        BACKWARDS, backwards_unseen, issue="backward stamps where time is not recognised",
    ),
    Fault(
        "wrong_rate", "stamps too far apart by this factor", 2.0, "", (HAND,),
        ("sample_rate_suspect", "sample_rate_disagrees"), wrong_rate, issue="sample rate",
    ),
    Fault(
        "run_radians", "1 of the runs in rad/s, stated as deg/s", 1.0, "", (TABLE, MEANS, HOT), ("unit_disagrees",),
        run_radians, issue="1 of 5 runs in rad/s", model=False,
    ),
    Fault(
        "run_sign", "1 of the runs with its sign turned", 1.0, "", (TABLE, MEANS, HOT, MASS), ("sign_disagrees",),
        run_sign, issue="sign of a run flipped", model=False,
    ),
    Fault(
        "run_gain_2", "1 of the runs reads more by this", 0.02, "", (TABLE, MEANS), ("gain_disagrees",), run_gain,
        issue="gain of 2 % in one run", model=False,
    ),
    Fault(
        "run_gain_half", "1 of the runs reads more by this", 0.005, "", (TABLE, MEANS), ("gain_disagrees",), run_gain,
        limit="0 of 60 by the prototype",
    ),
    Fault(
        "swapped_files", "the files of x and y have each other's names", 0.0, "", (TABLE,), ("axes_disagree",),
        swapped_files, issue="x and y files swapped", model=False,
    ),
    Fault(
        "one_reading", "one reading of this", 100.0, "", (MEANS,), ("reading_disagrees",), one_reading,
        issue="one reading of +100", model=False,
    ),
    Fault(
        "equal_to_applied", "readings are a copy of the commanded rates", 0.0, "", (TABLE, MEANS),
        ("copy_of_applied",), equal_to_applied, issue="equal readings and applied rates", model=False,
    ),
    Fault(
        "copies", "runs from the second on are byte copies", 0.0, "", (TABLE, HOT, MASS), COPY, copies,
        issue="runs 2-5 byte copies of run 1", model=False,
    ),
    Fault(
        "hold_out_copy", "the recording held out is a byte copy of a fitted one", 0.0, "", (TABLE,),
        COPY, hold_out_copy, issue="hold-out a byte copy of the fit", model=False,
    ),
    Fault(
        "appended", "recordings are appended to themselves, four in all", 4.0, "", (STILL, TABLE, PLAIN),
        ("repeated", *COPY), appended, issue="a recording appended four times",
    ),
    Fault(
        "temperature_cold", "ten temperatures of this", -400.0, "degC", (HOT,), ("impossible_temperature",),
        temperature, issue="temperature of -400 or 50,000 degC",
    ),
    Fault(
        "temperature_hot", "ten temperatures of this", 50_000.0, "degC", (HOT,), ("impossible_temperature",),
        temperature, issue="temperature of -400 or 50,000 degC",
    ),
    Fault(
        "temperature_stuck", "this part of the temperatures is stuck", 0.5, "", (HOT,), ("stuck",), temperature_stuck,
        issue="half of the temperatures stuck",
    ),
    Fault(
        "unit_mid", "from deg/s to rad/s in mid-record", np.pi / 180.0, "", FILES, UNIT, unit_mid,
        issue="unit changing in mid-record", model=False,
    ),
    Fault(
        "sign_mid", "the sign turns in mid-record", -1.0, "", (TABLE, HAND, HOT, TURN), ("sign_changed",), unit_mid,
        issue="sign changing in mid-record", model=False,
    ),
    Fault(
        "axes_mid", "another sensor is read from the middle on", 20.0, "sigma", (TABLE, HAND, TURN), ("axes_changed",),
        axes_mid, issue="sensor changing in mid-record", model=False,
    ),
    Fault(
        "grouped", 'numbers from 1,000 on as "1,242"', 0.0, "", (MASS, FAST), ("grouped_digits",), grouped,
        issue='quoted "1,242" read as 1.242',
    ),
    Fault(
        "zero_u", 'the standard says rate = { u = "0 %" }', 0.0, "", (TABLE, MEANS), ("zero_uncertainty",), zero_u,
        issue='rate = { u = "0 %" }',
    ),
    Fault(
        "scaled_1e3", "archive data 1e3 times too large", 1e3, "", (PAD,), ARCHIVE, scaled,
        issue="archive data scaled by 1e3 or 1e6",
    ),
    Fault(
        "scaled_1e6", "archive data 1e6 times too large", 1e6, "", (PAD,), ARCHIVE, scaled,
        issue="archive data scaled by 1e3 or 1e6",
    ),
    Fault(
        "filtered", "archive data behind a filter of this", 6.0, "Hz", (PAD,), ("line_amplitude",), filtered,
        "absent", issue="archive files with a 6 Hz filter",
    ),
    Fault(
        "repeating_drift", "an exponential that every run repeats, in responses", 300.0, "", (MASS,), (),
        repeating_drift, "covered",
    ),
    Fault("jump", "a jump at the same dwell of every run, in responses", 5.0, "", (MASS,), ("jump",), jump),
    Fault("gain_mid", "the gain changes in mid-run", 1.5, "", (MASS,), ("scale_changed", "runs_differ"), gain_mid),
    Fault("gain_mid_all", "it changes alike in every run", 1.5, "", (MASS,), ("scale_changed",), gain_mid_all),
    Fault("slip", "the mass is a dwell late from the middle of a run on", 1.0, "", (MASS,), ("schedule_slip",), slip),
    Fault("turn_on", "each run has an offset of its own", 0.01, "deg/s", (TABLE, MEANS), (), turn_on, "covered"),
    Fault(
        "separate_stamps", "both sensors have files and stamps of their own, apart by this", 0.4, "samples", (HAND,),
        (), separate_stamps, "covered",
    ),
    Fault(
        "wrong_label", "the position of a dwell is misnamed", 180.0, "deg", (TURN,), ("not_turned_by_angle",),
        wrong_label,
    ),
    Fault("low_pass", "the white noise is behind a filter of this", 5.0, "Hz", (STILL,), (), low_pass, "covered"),
)  # fmt: skip
FAULTS: dict[str, Fault] = {fault.name: fault for fault in _TABLE}
