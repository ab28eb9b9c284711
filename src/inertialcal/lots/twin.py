"""Twin of a lot: a population of three-axis gyros, the stations that test them, and what goes wrong on a line.

Each unit has scale factors, misalignments, a bias over temperature and noise of its own, drawn from a population. Each
station has its own errors of rate and of temperature, one draw each of what `[standards]` state; each unit is mounted
anew. A unit is tested as the reduced suite of a line: the chamber up and down, a rate table in five power-ups, a record
at rest. Some units are tested again at every station, for the gauge.

What is written: LOT.toml, the campaign that is its template, units.csv, three Parquet files that hold all units, and
``.truth/``, which `lot` does not read.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from ..core.campaign_text import FILE, Noted, toml_text
from ..core.errors import UsageError
from ..core.estimate import Array
from ..core.key import AXES
from ..core.show.tables import Block, Table, html, text
from ..files.write.atomic import sync, work_folder
from ..physics.earth import earth_rate, level_to_table

DEG, LATITUDE = math.pi / 180.0, 45.0
STAND = (0.0, 30.0)  # tilt and azimuth of the chamber [deg]
RATES = (0.0, 100.0, -100.0, 60.0, -60.0, 30.0, -30.0, 10.0, -10.0, 5.0, -5.0, 80.0, -80.0, 0.0)  # [deg/s]
RUNS, RAMP, STILL = 5, 2_000, 20_000  # power-ups on the table, samples of a ramp, and at rest
RAMP_STEP, STILL_STEP = 2.0, 0.01  # [s]
COLDEST, WARMEST, REFERENCE = -20.0, 60.0, 20.0  # [degC]
AT_ONCE = 25  # tests in a row group: a block of a lot reads one
U_RATE, U_TEMPERATURE, U_MOUNTING = 0.03e-2, 0.1, 0.5e-3  # of a station: 1, degC; of a mounting: rad
DAY = 86_400 * 10**9
START = 1_790_000_000 * 10**9  # 2026-09-21
EACH = 180 * 10**9  # from unit to unit at a station [ns]
Content = dict[str, object]  # of a table of TOML
TESTS = ("chamber", "rates", "still")


@dataclass(frozen=True)
class Quantity:
    """A parameter of the population: mean and standard deviation over units, in the unit of the results."""

    mean: float
    scatter: float
    unit: str


POPULATION = {
    "scale_factor_error": Quantity(0.1, 0.2, "%"),
    "misalignment": Quantity(0.0, 1.5e-3, "rad"),
    "bias": Quantity(0.01, 0.03, "deg/s"),  # at 20 degC
    "bias_temperature_1": Quantity(2e-4, 3e-4, "deg/s/degC"),
    "bias_temperature_2": Quantity(0.0, 3e-6, "deg/s/degC^2"),
    "angle_random_walk": Quantity(0.3, 0.03, "deg/sqrt(h)"),
}
LIMITS = {"scale_factor_error": "0.8 %", "bias": "0.1 deg/s", "angle_random_walk": "0.4 deg/sqrt(h)"}


@dataclass(frozen=True)
class LineFault:
    """A mistake of a line: what it is, the size where none is given, and what that is in."""

    what: str
    size: float
    unit: str


FAULTS = {
    "bad_station": LineFault("the table of one station turns faster than its certificate says", 10.0, "times u"),
    "odd_units": LineFault("units of another kind: scale factor and bias off together", 0.005, "of the units"),
    "stuck_axis": LineFault("the x axis reads one value in the record at rest", 0.005, "of the units"),
    "lost_file": LineFault("no dwells on the table were delivered", 0.005, "of the units"),
    "wrong_unit": LineFault("the dwells were saved in rad/s", 0.005, "of the units"),
    "drift": LineFault("the scale factor drifts along the lot", 2.0, "standard deviations"),
    "understated": LineFault("mountings scatter more than is stated", 4.0, "times u"),
}


@dataclass(frozen=True)
class Line:
    """A line as it is.

    Parameters
    ----------
    n : int
        Units.
    stations : int
        That test them, in turn.
    repeated : int
        Units that every station tests twice.
    faults : mapping of str to float
        Size of each mistake that is in it.
    """

    n: int
    stations: int = 4
    repeated: int = 10
    faults: Mapping[str, float] = field(default_factory=dict[str, float])


@dataclass(frozen=True, eq=False)
class Drawn:
    """What a line draws.

    Parameters
    ----------
    scale, bias, slope, square, noise : ndarray, shape (n, 3)
        Of each unit: errors of the scale factors [1], bias at 20 degC [deg/s] and its powers of the temperature, angle
        random walk [deg/sqrt(h)].
    misalignment : ndarray, shape (n, 3, 3)
        Row the sensor that reads [rad]; zero on the diagonal.
    station_rate, station_temperature : ndarray, shape (stations,)
        Error of its rate [1] and of its temperature [degC].
    odd : ndarray of int
        Units that are of another kind.
    broken : mapping of str to ndarray of int
        Tests that each mistake is in.
    unit, station, again : ndarray of int, shape (tests,)
        Of each test in the order of time: the unit, where, and the how manieth of this unit it is.
    """

    scale: Array
    bias: Array
    slope: Array
    square: Array
    noise: Array
    misalignment: Array
    station_rate: Array
    station_temperature: Array
    odd: NDArray[np.intp]
    broken: Mapping[str, NDArray[np.intp]]
    unit: NDArray[np.intp]
    station: NDArray[np.intp]
    again: NDArray[np.intp]


@dataclass(frozen=True)
class WrittenLot:
    """A simulated lot on disk."""

    folder: Path
    units: int
    tests: int
    seal: str
    faults: tuple[str, ...]

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown."""
        rows = [("units", str(self.units)), ("tests of them", str(self.tests)), ("truth, SHA-256", self.seal)]
        rows += [("mistake put in", one) for one in self.faults]
        caption = f"simulated lot in {self.folder}"
        return (Table(("what", ""), rows, caption), f"next: ic.lot({str(self.folder / 'LOT.toml')!r}, ...)")

    def __str__(self) -> str:
        """Return what is shown as text."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return what is shown for a notebook."""
        return html(self.parts())


def line_of(n: int, fault: str = "") -> Line:
    """Return a line with the mistakes that are asked for: ``"bad_station"``, ``"stuck_axis=0.02 drift"``, ``"all"``.

    Raises
    ------
    UsageError
        For a mistake that there is not, or fewer than one unit.
    """
    if n < 1:
        raise UsageError(f"{n} units: need 1 or more", code="wrong_value")
    asked = {} if fault != "all" else {name: one.size for name, one in FAULTS.items()}
    for word in fault.replace(",", " ").split() if fault != "all" else ():
        name, _, size = word.partition("=")
        if name not in FAULTS:
            raise UsageError(
                f"a lot has no mistake {name!r}", do=f"There are: {', '.join(FAULTS)}, all", code="unknown_name"
            )
        try:
            asked[name] = float(size) if size else FAULTS[name].size
        except ValueError:
            raise UsageError(f"{name}={size}: the size is a number", code="wrong_value") from None
        share = FAULTS[name].unit == "of the units"
        if not (math.isfinite(asked[name]) and (0.0 <= asked[name] <= 1.0 or not share)):
            raise UsageError(f"{name}={size}: need a share from 0 to 1", code="wrong_value")
    return Line(n, stations=min(4, n), repeated=min(10, n // 20), faults=asked)


def draw(line: Line, seed: int) -> Drawn:
    """Return units, stations and tests of a line."""
    of_units, of_stations, of_faults = np.random.default_rng(seed).spawn(3)
    n, sizes = line.n, line.faults

    def population(name: str, shape: tuple[int, ...] = (3,)) -> Array:
        one = POPULATION[name]
        return one.mean + one.scatter * of_units.standard_normal((n, *shape))

    scale, bias = population("scale_factor_error") / 100.0, population("bias")
    slope, square = population("bias_temperature_1"), population("bias_temperature_2")
    noise = np.maximum(population("angle_random_walk"), 0.05)
    misalignment = population("misalignment", (3, 3)) * (1.0 - np.eye(3))
    odd = np.flatnonzero(of_faults.random(n) < sizes.get("odd_units", 0.0))
    own = POPULATION["scale_factor_error"], POPULATION["bias"]
    scale[odd] += 6.0 * own[0].scatter / 100.0 * np.array([1.0, -1.0, 1.0])
    bias[odd] += 6.0 * own[1].scatter
    if "drift" in sizes:
        scale += (sizes["drift"] * own[0].scatter / 100.0 * (np.arange(n) / max(n - 1, 1) - 0.5))[:, np.newaxis]
    rate = U_RATE * of_stations.standard_normal(line.stations)
    if "bad_station" in sizes:
        rate[line.stations // 2] += sizes["bad_station"] * U_RATE
    temperature = U_TEMPERATURE * of_stations.standard_normal(line.stations)
    unit, station, again = _tests(line)
    broken = {
        name: np.flatnonzero(of_faults.random(unit.size) < sizes.get(name, 0.0))
        for name in ("stuck_axis", "lost_file", "wrong_unit")
    }
    return Drawn(scale, bias, slope, square, noise, misalignment, rate, temperature, odd, broken, unit, station, again)


def _tests(line: Line) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.intp]]:
    """Return unit, station and count of each test: units in turn, those of the gauge at every station twice."""
    chosen = set(np.linspace(0, line.n - 1, line.repeated).astype(int).tolist()) if line.repeated else set()
    rows = []
    for k in range(line.n):
        places = [s for s in range(line.stations) for _ in range(2)] if k in chosen else [k % line.stations]
        rows += [(k, place, count) for count, place in enumerate(places)]
    return tuple(np.array(column) for column in zip(*rows, strict=True))  # type: ignore[return-value]


def write_lot(folder: str | Path, line: Line, seed: int, tell: Callable[[int, int], None] | None = None) -> WrittenLot:
    """Write a lot into a new folder, all or nothing.

    Parameters
    ----------
    folder : path
        New, or empty.
    line : Line
        As it is.
    seed : int
        All draws follow from it.
    tell : callable, optional
        Called with (tests written, tests in all).

    Raises
    ------
    UsageError
        If something is in the folder, or the seed is negative.
    StoreError
        If it cannot be written; nothing is left behind.
    """
    target = Path(folder)
    if seed < 0:
        raise UsageError(f"seed {seed}: need 0 or more")
    if target.exists() and (not target.is_dir() or any(target.iterdir())):
        raise UsageError(f"{target} exists and is not empty", do="Name a new folder: -o DIR", code="exists")
    drawn = draw(line, seed)
    truth = truth_text(line, drawn, seed)
    seal = hashlib.sha256(truth.encode()).hexdigest()
    target.parent.mkdir(parents=True, exist_ok=True)
    with work_folder(target.parent) as aside:
        root = aside / "lot"
        (root / "recordings").mkdir(parents=True)
        (root / ".truth").mkdir()
        _write_text(root / "LOT.toml", lot_text(seed, seal))
        _write_text(root / FILE, campaign_text(seed, seal))
        _write_text(root / "units.csv", units_text(drawn))
        _write_text(root / ".truth" / "truth.json", truth)
        _write_recordings(root / "recordings", drawn, line, seed, tell)
        for path in [*root.rglob("*"), root]:
            sync(path)
        if target.exists():
            target.rmdir()
        os.replace(root, target)
    names = tuple(f"{name} {size:g} {FAULTS[name].unit}" for name, size in line.faults.items())
    return WrittenLot(target, line.n, drawn.unit.size, seal, names)


def _write_text(path: Path, content: str) -> None:
    path.write_text(content, encoding="utf-8", newline="\n")


def _write_recordings(root: Path, drawn: Drawn, line: Line, seed: int, tell: Callable[[int, int], None] | None) -> None:
    total, writers = drawn.unit.size, dict[str, pq.ParquetWriter]()
    lost = set(drawn.broken["lost_file"].tolist())
    try:
        for first in range(0, total, AT_ONCE):
            tables: dict[str, list[pa.Table]] = {name: [] for name in TESTS}
            for k in range(first, min(first + AT_ONCE, total)):
                for name, table in recordings_of(drawn, line, k, seed).items():
                    if not (name == "rates" and k in lost):
                        tables[name].append(table)
            for name, every in tables.items():
                if every:
                    table = pa.concat_tables(every)
                    if name not in writers:
                        coded = [one.name for one in table.schema if not pa.types.is_floating(one.type)]
                        writers[name] = pq.ParquetWriter(
                            root / f"{name}.parquet", table.schema, compression="lz4", use_dictionary=coded
                        )  # noise has nothing to be found twice in
                    writers[name].write_table(table, row_group_size=table.num_rows)
            if tell is not None:
                tell(min(first + AT_ONCE, total), total)
    finally:
        for one in writers.values():
            one.close()


def recordings_of(drawn: Drawn, line: Line, k: int, seed: int) -> dict[str, pa.Table]:
    """Return the recordings of test k, each with the columns serial and test."""
    rng = np.random.default_rng([seed, k])
    unit, place = int(drawn.unit[k]), int(drawn.station[k])
    matrix = (np.eye(3) + np.diag(drawn.scale[unit])) @ (np.eye(3) + drawn.misalignment[unit])
    times = line.faults.get("understated", 1.0)
    laid = U_MOUNTING * times * rng.standard_normal((3, 3)) * (1.0 - np.eye(3))  # column: where a turned axis points
    sigma = drawn.noise[unit] / 60.0 / math.sqrt(STILL_STEP)  # of a sample at rest [deg/s]
    earth = level_to_table(STAND[0] * DEG, STAND[1] * DEG) @ earth_rate(LATITUDE * DEG) / DEG
    felt = matrix @ earth
    made = {}
    true = np.concatenate([np.linspace(COLDEST, WARMEST, RAMP), np.linspace(WARMEST, COLDEST, RAMP)])
    off = (true - REFERENCE)[:, np.newaxis]
    law = drawn.bias[unit] + off * drawn.slope[unit] + off**2 * drawn.square[unit]
    slow = drawn.noise[unit] / 60.0 / math.sqrt(RAMP_STEP)
    shown = true + drawn.station_temperature[place] + 0.01 * rng.standard_normal(true.size)
    columns = {"time_s": RAMP_STEP * np.arange(true.size), "temperature_degC": shown.astype(np.float32)}
    made["chamber"] = columns | _axes(law + felt + slow * rng.standard_normal((true.size, 3)))
    applied, axis, run, readings = [], [], [], []
    for number in range(RUNS):
        off_run = drawn.bias[unit] + 2e-4 * rng.standard_normal(3)
        for at, letter in enumerate(AXES):
            turned = (np.eye(3) + laid)[:, at]
            rates = np.array(RATES)
            true = np.outer(rates * (1.0 + drawn.station_rate[place]), turned)
            dwell = drawn.noise[unit] / 60.0 / math.sqrt(20.0)
            readings.append(true @ matrix.T + off_run + dwell * rng.standard_normal((rates.size, 3)))
            applied.append(rates)
            axis += [letter] * rates.size
            run += [f"{number + 1}"] * rates.size
    read = np.concatenate(readings)
    if k in drawn.broken["wrong_unit"]:
        read = read * DEG
    made["rates"] = {"rate_dps": np.concatenate(applied), "axis": np.array(axis), "run": np.array(run)} | _axes(
        read, np.float64
    )
    still = drawn.bias[unit] + felt + sigma * rng.standard_normal((STILL, 3))
    if k in drawn.broken["stuck_axis"]:
        still[:, 0] = still[0, 0]
    made["still"] = {"time_s": STILL_STEP * np.arange(STILL)} | _axes(still)
    serial, again = serial_of(unit), int(drawn.again[k])
    return {name: _table(serial, again, columns) for name, columns in made.items()}


def _axes(readings: Array, kind: type = np.float32) -> dict[str, Array]:
    return {f"gyro_{letter}_dps": readings[:, at].astype(kind) for at, letter in enumerate(AXES)}


def _table(serial: str, again: int, columns: Mapping[str, Array]) -> pa.Table:
    n = len(next(iter(columns.values())))
    head = {
        "serial": pa.DictionaryArray.from_arrays(pa.array(np.zeros(n, np.int32)), pa.array([serial])).cast(pa.string()),
        "again": pa.array(np.full(n, again, np.int64)),
    }
    return pa.table(head | {name: pa.array(one) for name, one in columns.items()})


def serial_of(unit: int) -> str:
    """Return the serial number of a unit."""
    return f"G{unit:05d}"


def units_text(drawn: Drawn) -> str:
    """Return units.csv: a row a test."""
    rows = ["serial,again,station,position,tested"]
    counts = np.zeros(int(drawn.station.max()) + 1, dtype=int)
    for unit, station, again in zip(drawn.unit, drawn.station, drawn.again, strict=True):
        at = START + int(counts[station]) * EACH
        stamp = np.datetime64(at, "ns").astype("datetime64[s]")
        rows.append(f"{serial_of(int(unit))},{again},S{station + 1},{counts[station] % 8 + 1},{stamp}Z")
        counts[station] += 1
    return "\n".join(rows) + "\n"


def lot_text(seed: int, seal: str) -> str:
    """Return LOT.toml."""
    shared = {"serial": "serial", "match": {"again": "again"}}
    files = {name: {"file": f"recordings/{name}.parquet"} | shared for name in TESTS}
    content: Content = {
        "schema": 1, "id": f"simulated-lot-{seed}",
        "title": f"A simulated lot, seed {seed}; truth sealed with SHA-256 {seal}",
        "campaign": FILE, "units": "units.csv", "files": files,
        "line": {"station": "station", "place": "tested", "factors": ["position"]},
    }  # fmt: skip
    return toml_text(content)


def campaign_text(seed: int, seal: str) -> str:
    """Return the campaign that is the template of all units."""
    axes: Content = {letter: {"column": f"gyro_{letter}_dps", "unit": "deg/s"} for letter in AXES}
    stand = {"tilt": f"{STAND[0]:g} deg", "u": "0.05 deg", "azimuth": f"{STAND[1]:g} deg", "u_azimuth": "0.05 deg"}

    def recorded(file: str, more: Content | None = None, **words: str) -> Content:
        return {"sensor": "gyro", "file": f"{file}.parquet", **words, "clock": {"column": "time_s"},
                "channels": axes | (more or {})}  # fmt: skip

    warm: Content = {"temperature": {"column": "temperature_degC", "unit": "degC"}}
    content: Content = {
        "schema": 2,
        "campaign": {"id": f"lot-{seed}", "title": "Reduced suite of a line", "source": f"simulated, truth {seal}"},
        "item": {"maker": "inertialcal", "part": "simulated rate gyro", "serial": "of each unit"},
        "site": {"latitude": f"{LATITUDE:g} deg"},
        "standards": Noted(
            {
                "rate_table": {
                    "rate": {"u": f"{100 * U_RATE:g} %", "certificate": "of the station"},
                    "mounting": {"u": f"{U_MOUNTING:g} rad"},
                },
                "thermometer": {"temperature": {"u": f"{U_TEMPERATURE:g} degC", "certificate": "of the station"}},
                "site": {"latitude": {"u": "0.0001 rad"}},
            },
            above="Each station has one unknown error of each; a unit is mounted anew.",
        ),
        "sensors": {"gyro": {"kind": "gyro", "axes": list(AXES), "unit": "deg/s"}},
        "recordings": {
            "chamber": recorded("chamber", warm),
            "still": recorded("still"),
            "rates": {
                "sensor": "gyro", "file": "rates.parquet",
                "rows": {"axis": "axis", "applied": "rate_dps", "run": "run", "unit": "deg/s",
                         "reading": {letter: f"gyro_{letter}_dps" for letter in AXES}},
            },
        },
        "tests": [
            {"id": "thermal", "procedure": "thermal", "use": "fit", "recordings": ["chamber"],
             "plan": {"at": ["0 degC", "20 degC", "40 degC"], "reference_temperature": "20 degC", "attitude": stand}},
            {"id": "rate", "procedure": "rate_table", "use": "fit", "recordings": ["rates"],
             "plan": {"zero_reference": True}},
            {"id": "noise", "procedure": "static_noise", "use": "report_only", "recordings": ["still"]},
        ],
        "model": {"terms": {"scale_factor": ["rate"], "misalignment": ["rate"], "bias": ["thermal"]}},
        "requirements": [
            {"id": f"R{number}", "text": name.replace("_", " "), "quantity": name, "limit": limit}
            | ({"tests": ["thermal"]} if name == "bias" else {})
            for number, (name, limit) in enumerate(LIMITS.items(), 1)
        ],
    }  # fmt: skip
    return toml_text(content)


def truth_text(line: Line, drawn: Drawn, seed: int) -> str:
    """Return truth.json: the population, each unit, each station, and where the mistakes are."""
    content = {
        "schema": 1, "seed": seed, "n": line.n, "faults": dict(line.faults),
        "population": {name: asdict(one) for name, one in POPULATION.items()},
        "stations": {f"S{k + 1}": {"rate": float(a), "temperature": float(b)}
                     for k, (a, b) in enumerate(zip(drawn.station_rate, drawn.station_temperature, strict=True))},
        "odd_units": [serial_of(int(k)) for k in drawn.odd],
        "broken": {name: [[serial_of(int(drawn.unit[k])), int(drawn.again[k])] for k in at]
                   for name, at in drawn.broken.items()},
        "units": {serial_of(k): {
            "scale_factor_error": (100.0 * drawn.scale[k]).tolist(), "bias": drawn.bias[k].tolist(),
            "bias_temperature_1": drawn.slope[k].tolist(), "bias_temperature_2": drawn.square[k].tolist(),
            "angle_random_walk": drawn.noise[k].tolist(), "misalignment": drawn.misalignment[k].tolist(),
        } for k in range(line.n)},
    }  # fmt: skip
    return json.dumps(content) + "\n"
