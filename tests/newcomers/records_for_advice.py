"""More files that messages give advice on: models by condition, levels, faces, sections, heads that are turned."""

from __future__ import annotations

import json
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from itertools import pairwise, product
from pathlib import Path

import numpy as np
from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import rsa
from cryptography.x509.oid import NameOID
from files_for_advice import CAMPAIGN, csv
from logger_files import dataflash_text, ros_1
from made_records import add, content, figure
from newcomer_boards import FACES, Board, G, board_at_rest, board_of, six_faces
from newcomer_tables import rounded
from newcomer_truths import BIASES, NOISE, at_rest, chamber

from independent.orbit.aligned import Bench as Aligned
from independent.orbit.aligned import made as aligned
from independent.orbit.heads import made as on_one_body
from independent.orbit.heads import on_line
from independent.orbit.magnetometer import recorded as in_orbit
from independent.shaking.shaker import Mode, recorded
from independent.shaking.shaker import Run as Sweep
from independent.vibration.random_run import Run, simulate
from independent.warm.warm_up import Chamber, power_ups, starts
from inertialcal.archive import open_archive
from inertialcal.core.estimate import Component, Estimate
from inertialcal.core.key import Key
from inertialcal.core.units import factor
from inertialcal.files.models.model_json import write_model
from inertialcal.rigs.flights.rig import Bench as Flights
from inertialcal.rigs.flights.rig import build as flights
from inertialcal.rigs.sams_tsh.campaign import FILE
from inertialcal.rigs.sams_tsh.rig import build
from inertialcal.sensors.model.assemble import model_from
from inertialcal.sensors.model.model_set import ModelSet
from inertialcal.sensors.model.sensor_model import SensorModel
from pad_pairs_made import BENCH, START, flip_records, header, pair, records, stamp, systems

BIAS = {"air": 0.3, "vacuum": -0.2}  # deg/s
PRESSURE = {"air": 101325.0, "vacuum": 1e-6}  # Pa
PER_VOLT = {"x": 0.4, "y": -0.2, "z": 0.1}  # deg/s/V
PER_TORR = 1e-3  # of these
DRIFT = 0.3  # deg/s over a record
LATE = 1500.0  # s: from then on a head reads otherwise
HEAD_BIAS = {"x": -840.0, "y": 980.0, "z": -1256.0}  # ug, x with what lies along the turn
AMBIENT = {"x": 0.0, "y": -3.0, "z": 4.0}  # ug, of the turn
CERTIFICATE = """[item]
maker = "Maker"
part = "G1"
serial = "7"
[certificate]
number = "2026-014"
issued = "2026-11-28"
received = "2026-11-02"
performed = ["2026-11-03", "2026-11-20"]
item_condition = "no damage"
methods = ["IEEE Std 1431-2004"]
environment = "(23 +- 1) degC"
deviations = "none"
laboratory = { name = "Laboratory", city = "Monterey", country = "US" }
customer = { name = "Customer", city = "Monterey", country = "US" }
signatures = [{ name = "A. Person", function = "head" }]
"""
GROUND = """schema = 2
[campaign]
id = "ground"
[sensors.head]
kind = "accelerometer"
axes = ["x", "y", "z"]
unit = "m/s^2"
chain = {{ kind = "none", model = "heads.json" }}
[recordings.rest]
sensor = "head"
file = "{file}"
channels = {{ {channels} }}
[[tests]]
id = "noise"
procedure = "static_noise"
recordings = ["rest"]
"""
CUBES = """[motion]
stroke = ["10 cm", "40 cm"]
rig = ["0 cm", "60 cm"]
direction = "along"
[body]
stand_off = "7.6 cm"
cubes = [{{ count = {large}, edge = "10 cm" }}, {{ count = {count}, edge = "{edge} cm" }}]
"""
STANDARD = """[standards.rate_table]
rate = { u = "0.1 %" }
"""
KALIBR_NOISE = """imu0:
  accelerometer_noise_density: 1.0e-3
  gyroscope_noise_density: 1.0e-4
  model: calibrated
  rostopic: /imu0
  update_rate: 200.0
"""
KALIBR_SCALED = """imu0:
  T_i_b:
  - [1.0, 0.0, 0.0, 0.0]
  - [0.0, 1.0, 0.0, 0.0]
  - [0.0, 0.0, 1.0, 0.0]
  - [0.0, 0.0, 0.0, 1.0]
  accelerometers:
    M:
    - [1.01, 0.0, 0.0]
    - [0.0, 1.0, 0.0]
    - [0.0, 0.0, 1.0]
  gyroscopes:
    A:
    - [0.0, 0.0, 0.0]
    - [0.0, 0.0, 0.0]
    - [0.0, 0.0, 0.0]
    C_gyro_i:
    - [1.0, 0.0, 0.0]
    - [0.0, 1.0, 0.0]
    - [0.0, 0.0, 1.0]
    M:
    - [1.25, 0.0, 0.0]
    - [0.0, 1.0, 0.0]
    - [0.0, 0.0, 1.0]
  model: scale-misalignment
  rostopic: /imu0
  update_rate: 200.0
"""
START_OF_SECOND = stamp(START, 1.0)


def _archived(folder: Path) -> None:
    """Seven tests of a unit that nobody says was adjusted after the fourth."""
    values = [0.02 * k + 0.001 * (-1) ** k + 0.5 * (k > 3) for k in range(7)]
    add(open_archive(folder / "jumped.db"), *(content("A", k, [figure(one, 0.03)]) for k, one in enumerate(values)))


def write_records(folder: Path) -> None:
    """Write every file into a folder."""
    _orbits(folder)
    _archived(folder)
    _flown(folder)
    _body(folder)
    aligned(Aligned(seconds=120.0), np.random.default_rng(5)).write(folder / "aligned.csv")
    write_model(folder / "both.json", ModelSet(tuple(_model(one) for one in BIAS)))
    keys = tuple(Key("angle_random_walk", axis) for axis in "xyz")
    scatter = Component("scatter", "A", np.diag([1e-16] * 3), 7.0)
    noise = Estimate(
        keys, np.full(3, factor("deg/s", "rad/s") * NOISE / np.sqrt(50.0)), ("rad/sqrt(s)",) * 3, (scatter,)
    )
    write_model(folder / "noisy.json", replace(_model("air"), noise=noise, condition="", pressure_range=None))
    warm = replace(_model("air"), condition="", pressure_range=None, bias_temperature=np.full((1, 3), 1e-5),
                   reference_temperature=np.full(3, 20.0))  # fmt: skip
    write_model(folder / "no_range.json", warm)
    for text in (
        _series(),
        _commas(),
        _pressures(),
        _temperatures(),
        _levels(),
        _faces(),
        _others(),
        _shaken(),
        _moved(),
    ):
        for name, written in text.items():
            (folder / name).write_text(written)
    _pads(folder)
    _heads(folder)
    _campaigns(folder)
    _ground_campaigns(folder)
    _warm_ups(folder)
    (folder / "shaker.csv").write_text(_shaker())
    (folder / "tall.toml").write_text(CUBES.format(large=12, count=60, edge="1"))
    (folder / "fine.toml").write_text(CUBES.format(large=40, count=1200, edge="0.5"))
    _keys(folder)
    ros_1(folder / "drive.bag")
    dataflash_text(folder / "flown.log")


def _model(condition: str) -> SensorModel:
    """Return a model of a gyro that has nothing but a bias, in a condition."""
    scatter = Component("scatter", "A", np.diag([1e-10] * 3), 7.0)
    bias = np.full(3, BIAS[condition] * factor("deg/s", "rad/s"))
    estimate = Estimate(tuple(f"bias_{axis}" for axis in "xyz"), bias, ("rad/s",) * 3, (scatter,))
    between = {"air": (90e3, 110e3), "vacuum": (0.0, 1e-2)}[condition]
    made = model_from(estimate, "gyro", ("x", "y", "z"), 1.0, "rad/s", judged=True)
    return replace(made, condition=condition, pressure_range=between)


def _head_model(condition: str = "", bias: float = 1e-3) -> SensorModel:
    """Return a model of accelerometers that has nothing but a bias [m/s^2], in a condition."""
    scatter = Component("scatter", "A", np.diag([1e-16] * 3), 7.0)
    estimate = Estimate(tuple(f"bias_{axis}" for axis in "xyz"), np.full(3, bias), ("m/s^2",) * 3, (scatter,))
    made = model_from(estimate, "accelerometer", ("x", "y", "z"), 1.0, "m/s^2", judged=True)
    between = {"air": (90e3, 110e3), "vacuum": (0.0, 1e-2), "": None}[condition]
    return replace(made, condition=condition, pressure_range=between)


def _gyro(rng: np.random.Generator, values: dict[str, np.ndarray]) -> dict[str, list[float]]:
    return {f"gyro_{axis} [deg/s]": rounded(one + NOISE * rng.standard_normal(len(one)), 6)
            for axis, one in values.items()}  # fmt: skip


def _commas() -> dict[str, str]:
    """Return logs whose commas can be the decimal sign, or group digits."""
    log = at_rest(minutes=0.2)
    stamps = [int(t) for t in np.rint(1e3 * log.time)]
    cells = [f"{value:.3f}".replace(".", ",") for value in log.readings["x"] + 1.0]
    whole = [*cells[:7], "2", *cells[8:]]
    return {name: "time_ms;gyro_x [deg/s]\n" + "".join(f"{t};{one}\n" for t, one in zip(stamps, some, strict=True))
            for name, some in (("comma.csv", cells), ("comma_whole.csv", whole))}  # fmt: skip


def _series() -> dict[str, str]:
    """Return series of a drive of 3 at 800 s, 100 s apart, as the programme of 1969 takes them, or does not."""
    rng, n = np.random.default_rng(51), 96

    def wave(time: np.ndarray, period: float = 800.0) -> list[float]:
        return rounded(1000.0 + 3.0 * np.sin(2.0 * np.pi * time / period) + 0.02 * rng.standard_normal(len(time)), 4)

    time = 100.0 * np.arange(n)
    uneven, long = time + np.where(np.arange(n) % 2, 17.0, 0.0), 100.0 * np.arange(4100)
    even = {"time_s": rounded(time, 1), "pulses": wave(time)}
    return {
        "two.cards": _deck(),
        "series.csv": csv(even),
        "series_tilt.csv": csv({**even, "tilt": rounded(0.01 * rng.standard_normal(n), 5)}),
        "series_no_time.csv": csv({"pulses": even["pulses"]}),
        "series_uneven.csv": csv({"time_s": rounded(uneven, 1), "pulses": wave(uneven)}),
        "series_other.csv": csv({"time_s": rounded(time, 1), "pulses": wave(time, 750.0)}),
        "scope.csv": csv(
            {
                "time [s]": rounded(np.arange(3000) / 50.0, 2),
                "CH1 [V]": rounded(2.5 + 0.004 * rng.standard_normal(3000), 6),
            }
        ),
        "series_long.csv": csv({"time_s": rounded(long, 1), "pulses": wave(long)}),
    }


def _moved() -> dict[str, str]:
    """Return a sensor of 1000 V/g beside a mass of 100 ng, in volts stamped at the end of 10 s, and its schedule."""
    rng, n = np.random.default_rng(52), 40
    order = np.tile([0.0, 1.0, 0.0, -1.0], n // 4)
    start, applied = 120.0 * np.arange(n), 1e-7 * G * order
    time = np.arange(10.0, 120.0 * n, 10.0)
    felt = applied[np.minimum((time - 5.0) // 120.0, n - 1).astype(int)] + 2e-9 * G * rng.standard_normal(len(time))
    rows = "".join(f"{a:g},{a + 100.0:g},{0.25 + 0.25 * o:g},{b:.9e}\n" for a, o, b in zip(start, order, applied,
                                                                                       strict=True))  # fmt: skip
    return {
        "moved_volts.csv": csv({"time [s]": rounded(time, 1), "output [V]": rounded(2.5 + 1000.0 / G * felt, 9)}),
        "moved_schedule.csv": f"start [s],stop [s],position [m],applied [m/s2]\n{rows}",
    }


def _deck() -> str:
    """Return card images of two cases: a recorded drive of 23 at four samples, and one that the programme makes."""
    counts = np.rint(1700.0 + 23.0 * np.sin(0.5 * np.pi * np.arange(100))).astype(int)
    values = [f"   {one:6d} " for one in counts], [f"  {0:8d} " for _ in counts]  # accelerometer, tilt meter
    cards = ["".join(one[at : at + 5]) for one in values for at in range(0, 100, 5)]
    head = "".join(f"{one:4d}" for one in (100, 100, 100, 23, 0, 60, 50, 4, 7, 12))
    made = zip((100, 100, 60, 50, 23, 2, 40, 50, 7, 3, 4), (4, 4, 4, 4, 8, 4, 8, 4, 8, 4, 4), strict=True)
    second = "".join(f"{one:>{width}}" for one, width in made)
    return "\n".join(["   0", head, *cards, "   1", "   6", "   1", second, "   6", "  -1", ""])


def _pressures() -> dict[str, str]:
    """Return logs at rest in air, in vacuum, and in both."""
    rng, n = np.random.default_rng(31), 200
    time = {"time_s": rounded(np.arange(n) / 50.0, 3)}
    in_air = np.arange(n) < n // 2

    def log(bias: np.ndarray, **gauges: np.ndarray) -> str:
        named = {f"{name} [Pa]": [float(one) for one in values] for name, values in gauges.items()}
        return csv({**time, **_gyro(rng, dict.fromkeys("xyz", bias)), **named})

    steady = {name: np.full(n, one) for name, one in PRESSURE.items()}
    vacuum = np.full(n, BIAS["vacuum"])
    return {
        "in_vacuum.csv": log(vacuum, pressure=steady["vacuum"]),
        "two_gauges.csv": log(vacuum, gauge_1_pressure=steady["air"], gauge_2_pressure=steady["vacuum"]),
        "unsaid.csv": log(vacuum),
        "pumped.csv": log(np.where(in_air, BIAS["air"], BIAS["vacuum"]),
                          pressure=np.where(in_air, PRESSURE["air"], PRESSURE["vacuum"])),
    }  # fmt: skip


def _temperatures() -> dict[str, str]:
    """Return logs at rest at 20 degC, with no thermometer and with two."""
    log = at_rest(minutes=0.2)
    n = len(log.time)
    columns = {"time_s": rounded(log.time, 3)}
    columns |= {f"gyro_{axis} [deg/s]": rounded(values, 6) for axis, values in log.readings.items()}
    return {
        "rest_plain.csv": csv(columns),
        "abc_plain.csv": csv(
            {
                name if name == "time_s" else f"{'abc'['xyz'.index(name[5])]} [deg/s]": values
                for name, values in columns.items()
            }
        ),
        "rest_thermometers.csv": csv({**columns, "case [degC]": [20.0] * n, "board [degC]": [20.0] * n}),
    }


def _levels() -> dict[str, str]:
    """Return logs of a gyro at rest at levels of its supply or of pressure; 1 Hz."""
    rng, n = np.random.default_rng(21), 1200
    time = np.arange(n) * 1.0
    columns = {"time_s": rounded(time, 1)}
    volts = np.repeat(np.tile([5.0, 5.2, 4.8, 5.0, 4.8, 5.2], 2), 100)
    up = np.repeat([4.8, 5.0, 4.85, 5.05, 4.9, 5.1, 4.95, 5.15, 5.0, 5.2], 120)  # more and more: it goes with time
    torr = np.repeat([760.0, 400.0, 100.0, 1.0, 400.0, 760.0], 200)
    rate = np.tile(np.repeat([0.0, 20.0, 0.0, -20.0], 25), 12)

    def read(levels: np.ndarray, by: float = 1.0, more: np.ndarray | float = 0.0) -> dict[str, list[float]]:
        values = {axis: BIASES[axis] + by * PER_VOLT[axis] * levels + more for axis in "xyz"}
        return _gyro(rng, values)

    swung = {axis: share * rate + BIASES[axis] + PER_VOLT[axis] * (volts - 5.0)
             for axis, share in zip("xyz", (0.8, 0.6, 0.0), strict=True)}  # fmt: skip
    supply = {"supply [V]": rounded(volts, 4)}
    hpa = 600.0 + 500.0 * (volts - 5.0) / 0.2 + rng.standard_normal(n)

    def gauged(header: str) -> str:
        return csv({**columns, **read((hpa - 600.0) / 2500.0), header: rounded(hpa, 2)})

    return {
        "gauge_1.csv": gauged("pressure [hPa]"),
        "gauge_2.csv": gauged("pressure [hPa]"),
        "gauge.csv": gauged("gauge"),
        "levels.csv": csv({**columns, **read(volts - 5.0), **supply}),
        "levels_2.csv": csv({**columns, **read(volts - 5.0), **supply}),
        "levels_two.csv": csv({**columns, **read(volts - 5.0), "vcc [V]": supply["supply [V]"], "vdd [V]": [3.3] * n}),
        "levels_wrong.csv": csv({**columns, **read(volts - 5.0), "supply [mV]": supply["supply [V]"]}),
        "levels_micro.csv": csv({**columns, **read(volts - 5.0), "supply [uV]": rounded(1e3 * volts, 1)}),
        "levels_drift.csv": csv(
            {**columns, **read(up - 5.0, more=DRIFT * time / time[-1]), "supply [V]": rounded(up, 3)}
        ),
        "torr.csv": csv({**columns, **read(torr - 760.0, PER_TORR), "pressure [Pa]": rounded(torr, 3)}),
        "swung.csv": csv({**columns, "table_rate [deg/s]": rounded(rate, 2), **_gyro(rng, swung), **supply}),
    }


def _faces() -> dict[str, str]:
    """Return logs of a board on its faces, in other units than they say, or without a clock."""
    laid = six_faces()
    time, stamps = {"t [s]": rounded(laid.time, 3)}, {"t": [int(t) for t in np.rint(1e9 * laid.time)]}

    def columns(name: str, values: np.ndarray) -> dict[str, list[float]]:
        return {name.format(axis): rounded(values[:, i], 8) for i, axis in enumerate("xyz")}

    acc, gyro = columns("acc_{} [m/s2]", laid.acc), columns("gyro_{} [rad/s]", laid.gyro)
    return {
        "faces_gyro_wrong.csv": csv({**time, **acc, **columns("gyro_{} [deg/s]", laid.gyro)}),
        "faces_acc_wrong.csv": csv({**time, **columns("acc_{} [m/s2]", laid.acc / G)}),
        "faces_acc_ns.csv": csv({**stamps, **acc}),
        "faces_length.csv": csv(
            {**time, **{f"{name} [m]": rounded(laid.acc[:, i], 6) for i, name in enumerate("abc")}}
        ),
        "faces_gyro_ns.csv": csv({"t": stamps["t"][::2], **{name: one[::2] for name, one in gyro.items()}}),
        **_turns(),
    }


def _turns() -> dict[str, str]:
    """Return a board that is laid on its faces and turned clockwise about each axis, and one in an oven."""
    up = [np.tile(face, (200, 1)) for face in FACES]
    rates = [np.zeros((200, 3)) for _ in FACES]
    labels = ["?"] * len(FACES)
    turn = np.zeros(400)
    turn[50:350] = -(np.pi**2) / 6.0 * np.sin(np.pi * (np.arange(300) + 0.5) / 300.0)  # rad/s: one turn in 6 s
    for axis in np.tile(np.eye(3), (3, 1)):
        up.append(np.tile(axis, (400, 1)))
        rates.append(np.outer(turn, axis))
        labels.append(f"{'xyz'[int(axis.argmax())]}_rot")
    ends = np.cumsum([0, *map(len, up)])
    parts = "".join(f"{label},{a},{b}\n" for label, (a, b) in zip(labels, pairwise(ends), strict=True))

    def log(board: Board, **more: list[float]) -> str:
        acc = {f"acc_{axis} [m/s2]": rounded(board.acc[:, i], 6) for i, axis in enumerate("xyz")}
        gyro = {f"gyro_{axis} [rad/s]": rounded(board.gyro[:, i], 8) for i, axis in enumerate("xyz")}
        return csv({"t [s]": rounded(board.time, 2), **acc, **(gyro if board.gyro.any() else {}), **more})

    files = {"clockwise.csv": log(board_of(np.concatenate(up), np.concatenate(rates), 50.0, 8)),
             "parts.csv": f"section,start,end\n{parts}"}  # fmt: skip
    few = np.repeat(FACES[:7], 200, axis=0)
    laid = board_of(few, np.zeros_like(few), 50.0, 70)
    files["faces_few.csv"] = log(replace(laid, gyro=np.zeros_like(few)))  # No gyro: the turns are not in it
    still = np.repeat(FACES, 150, axis=0)
    for i, temperature in enumerate((0.0, 20.0, 40.0)):
        board = board_of(still, np.zeros_like(still), 50.0, 60 + i)
        board = replace(board, acc=board.acc + 0.002 * (temperature - 20.0), gyro=np.zeros_like(still))
        files[f"oven_{i}.csv"] = log(board, temperature=[temperature] * len(still))
    return files


def _others() -> dict[str, str]:
    """Return logs that allan, filter and sine do not take as they are."""
    board = board_at_rest(sample_rate=50.0, seconds=20.0)
    time = {"t [s]": rounded(board.time, 3)}
    acc = {f"acc_{axis}": rounded(board.acc[:, i], 6) for i, axis in enumerate("xyz")}
    warm, still = chamber(hours=0.4), at_rest(minutes=0.2)
    heated = {f"acc_{axis} [m/s2]": rounded(values + (G if axis == "z" else 0.0), 6)
              for axis, values in warm.readings.items()}  # fmt: skip
    rng = np.random.default_rng(3)
    walk = np.cumsum(3e-4 * rng.standard_normal(3000)) + NOISE * rng.standard_normal(3000)  # deg/s
    return {
        "walk.csv": csv({"time_s": rounded(np.arange(3000) / 50.0, 3), "gyro_x [deg/s]": rounded(walk, 6)}),
        "warm.csv": csv({**time, "warm [degC]": rounded(NOISE * np.random.default_rng(7).standard_normal(1000), 6)}),
        "acc_rest.csv": csv({**time, **{f"{name} [m/s2]": values for name, values in acc.items()}}),
        "acc_bare.csv": csv({**time, **acc}),
        "vibration.csv": csv({**time, **{name: rounded(np.array(one) / G, 7) for name, one in acc.items()}}),
        "chamber_two.csv": csv(
            {
                "time_s": rounded(warm.time, 1),
                **{f"gyro_{axis} [deg/s]": rounded(values, 6) for axis, values in warm.readings.items()},
                "case [degC]": rounded(warm.temperature, 2),
                "room [degC]": [23.0] * len(warm.time),
            }
        ),
        "volts_bare.csv": csv(
            {
                "time_s": rounded(still.time, 3),
                **{f"gyro_{axis} [V]": rounded(values, 7) for axis, values in still.volts().items()},
                "reference": [2.5] * len(still.time),
            }
        ),
        "acc_chamber.csv": csv(
            {"time_s": rounded(warm.time, 1), **heated, "temperature [degC]": rounded(warm.temperature, 2)}
        ),
        "no_terms.json": json.dumps({"sensors": []}),
        "kalibr_noise.yaml": KALIBR_NOISE,
        "kalibr_scaled.yaml": KALIBR_SCALED,
    }


SWEEP = Sweep(50.0, 200.0, 40.0, sample_rate=1000.0, quiet=0.2)


def _shaken() -> dict[str, str]:
    """Return a run on a shaker with a level density of 0.01 g^2/Hz from 20 to 200 Hz: 1.34 g, and its profile."""
    run = Run(nodes=((20.0, 0.01), (200.0, 0.01)), rate=1000.0, duration=8.0, error=0.0)
    table = rounded(simulate(run, 1)[0][:, 0] / G, 6)
    time = rounded(np.arange(len(table)) / run.rate, 3)
    driven, moved = recorded((Mode(100.0, 20.0),), SWEEP, np.random.default_rng(1))
    level = np.repeat([0.0, 2.0, 0.0], 1000) * np.random.default_rng(2).standard_normal(3000)
    reading = 1e-3 * level**2 + 1e-5 * np.random.default_rng(3).standard_normal(3000)
    at = rounded(np.arange(3000) / 100.0, 2)
    return {
        "one_level.csv": csv({"time_s": at, "gyro_x [deg/s]": rounded(reading, 9), "control [g]": rounded(level, 6)}),
        "shaken.csv": csv({"time_s": time, "table [g]": table}),
        "shaken_bare.csv": csv({"time_s": time, "ch1": table, "ch2": table}),
        "shaken_untimed.csv": csv({"table [g]": table}),
        "swept.csv": csv(
            {
                "time_s": rounded(np.arange(len(driven)) / SWEEP.sample_rate, 3),
                "table [g]": rounded(driven, 9),
                "acc_x [g]": rounded(moved, 9),
            }
        ),
        "level.csv": "frequency [Hz],density [g2/Hz]\n20,0.01\n200,0.01\n",
    }


def _pads(folder: Path) -> None:
    """Write pairs of the acceleration archive: of a head that is turned, and some that do not fit together."""
    flip_records(folder / "pads")
    drifting = records(2000)
    drifting[:, 0] = np.arange(2000) / 100.05
    second: dict[str, dict[str, str]] = {
        "pad_plain": {},
        "pad_drift": {},
        "pad_rates": {"rate": "50.00"},
        "pad_gain": {"more": "<Gain>100.0</Gain><CutoffFreq>6.00</CutoffFreq>"},
        "pad_frames": {"more": systems((0.0, 0.0, 90.0), (0.0, 0.0, 45.0)).replace("SSAnalysis", "Rack")},
    }
    for name, said in second.items():
        (folder / name).mkdir()
        text = header(more=systems((0.0, 0.0, 90.0))) if name == "pad_frames" else None
        pair(folder / name, drifting if name == "pad_drift" else records(100), text=text)
        if said:
            text = header(START_OF_SECOND, **said)
            pair(folder / name, records(100), start=START_OF_SECOND, sign="+", text=text)


def _heads(folder: Path) -> None:
    """Write the record of a head that is turned at 600 s and back at 1200 s, and tables of dwells."""
    readings = build(BENCH, 4).recordings[FILE].array("xyz")
    time = np.arange(len(readings)) / BENCH.rate
    amplified, converted = readings.copy(), readings.copy()
    amplified[time >= LATE, 2] *= 10.0
    converted[time >= LATE] *= G
    for name, values in {"head": readings, "head_gain": amplified, "head_unit": converted,
                         "head_steady": readings[time < 550.0]}.items():  # fmt: skip
        columns = {f"acc_{axis} [g]": rounded(values[:, i], 10) for i, axis in enumerate("xyz")}
        (folder / f"{name}.csv").write_text(csv({"time_s": rounded(time[: len(values)], 1), **columns}))
    rng = np.random.default_rng(41)
    text = "axis,flip,orientation,mean_ug\n"
    for axis, flip, (word, sign) in product("xyz", range(1, 6), (("forward", 1.0), ("reverse", -1.0))):
        mean = HEAD_BIAS[axis] + sign * AMBIENT[axis] + 0.5 * rng.standard_normal()
        text += f"{axis},{flip},{word},{mean:.3f}\n"
    (folder / "quarters.csv").write_text(_quarters())
    for name, column in (("halves", "mean_ug"), ("halves_bare", "mean"), ("halves_named", "read_out")):
        (folder / f"{name}.csv").write_text(text.replace("mean_ug", column, 1))


def _keys(folder: Path) -> None:
    """Write a private key and its certificate."""
    key = rsa.generate_private_key(public_exponent=65537, key_size=2048)
    name = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, "A. Person")])
    day = datetime(2026, 1, 1, tzinfo=UTC)
    made = x509.CertificateBuilder().subject_name(name).issuer_name(name).public_key(key.public_key())
    made = made.serial_number(1).not_valid_before(day).not_valid_after(day + timedelta(days=3650))
    form, plain = serialization.PrivateFormat.PKCS8, serialization.NoEncryption()
    (folder / "key.pem").write_bytes(key.private_bytes(serialization.Encoding.PEM, form, plain))
    certificate = made.sign(key, hashes.SHA256())
    (folder / "cert.pem").write_bytes(certificate.public_bytes(serialization.Encoding.PEM))


def _campaigns(folder: Path) -> None:
    """Write campaigns of a rate table: with what a certificate states, with a standard, of a head, and an empty one."""
    dwells = (folder / "dwells_units.csv").read_text()
    (folder / "other.xml").write_text("<other/>")
    _, turned = (folder / "turned_counts.csv").read_text().split("\n", 1)
    (folder / "part_counts.csv").write_text(f"time_s,table_rate [deg/s],gyro_x [count],b [count],c [count]\n{turned}")
    head, *rows = dwells.splitlines()
    cells = [row.split(",") for row in rows]
    again = [head, *(",".join([one[0], str(float(one[1]) + 0.002), *one[2:]]) for one in cells)]
    for name, text, table in (
        ("certified", f"{CAMPAIGN}{CERTIFICATE}", dwells),
        ("certified_2", f"{CAMPAIGN}{CERTIFICATE}", dwells),
        ("edited", CAMPAIGN, dwells),
        ("shared_1", f"{CAMPAIGN}{STANDARD}", dwells),
        ("shared_2", f"{CAMPAIGN}{STANDARD}".replace('"advised"', '"again"'), "\n".join(again) + "\n"),
        ("empty", "", dwells),
        ("taken", None, dwells),
        ("tables_alone", None, dwells),
    ):
        (folder / name).mkdir()
        if text is not None:
            (folder / name / "campaign.toml").write_text(text)
        (folder / name / "dwells_units.csv").write_text(table)


def _ground_campaigns(folder: Path) -> None:
    """Write campaigns of a head behind a ground model: of two conditions, and with a gain that changes."""
    for name, file, column, unit in (("ground", "acc_rest.csv", "acc_{} [m/s2]", "m/s^2"),
                                     ("gained", "head_gain.csv", "acc_{} [g]", "g")):  # fmt: skip
        (folder / name).mkdir()
        (folder / name / file).write_bytes((folder / file).read_bytes())
        channels = ", ".join(f'{axis} = {{ column = "{column.format(axis)}", unit = "{unit}" }}' for axis in "xyz")
        (folder / name / "campaign.toml").write_text(GROUND.format(file=file, channels=channels))
    write_model(folder / "ground/heads.json", ModelSet((_head_model("air"), _head_model("vacuum"))))
    write_model(folder / "gained/heads.json", _head_model())


def _warm_ups(folder: Path) -> None:
    """Write power-ups from several temperatures, whose amplitude goes with where they start."""
    truth = Chamber(by_start=3e-4, starts=starts(-20.0, 40.0, 6), length=900.0)
    time, readings, number, warmth = power_ups(1, truth)
    for run in range(len(truth.starts)):
        own = number == run
        columns = {f"gyro_{axis} [deg/s]": rounded(readings[own, i], 6) for i, axis in enumerate("xyz")}
        text = csv({"time_s": rounded(time[own], 1), **columns, "temperature [degC]": rounded(warmth[own, 0], 3)})
        (folder / f"warm_{run}.csv").write_text(text)


def _shaker() -> str:
    """Return the record of a gyro of 1.8 deg/h/g^2 on a shaker, between two rests, with two accelerometers."""
    rng = np.random.default_rng(72)
    front = np.repeat([0.0, 1.0, 2.0, 3.0, 0.0], 2000) * rng.standard_normal(10_000)
    gyro = 0.02 + 5e-4 * front**2 + 1e-3 * rng.standard_normal(10_000)
    back = 0.3 * front + 0.01 * rng.standard_normal(10_000)
    return csv({"time_s": rounded(np.arange(10_000) / 200.0, 3), "gyro_x [deg/s]": rounded(gyro, 6),
                "front [g]": rounded(front, 5), "back [g]": rounded(back, 5)})  # fmt: skip


def _quarters() -> str:
    """Return the record of a head that is turned by quarters about z, each for 100 s."""
    rng, at_each = np.random.default_rng(71), 1000
    angle = np.radians(np.repeat([0.0, 90.0, 180.0, 270.0, 0.0], at_each))
    turned = {"x": 500.0 * np.cos(angle) + 300.0 * np.sin(angle), "y": 300.0 * np.cos(angle) - 500.0 * np.sin(angle),
              "z": np.full(len(angle), 4.0)}  # fmt: skip
    acc = {f"acc_{axis} [ug]": rounded(HEAD_BIAS[axis] + values + 2.0 * rng.standard_normal(len(angle)), 3)
           for axis, values in turned.items()}  # fmt: skip
    return csv({"time_s": rounded(np.arange(len(angle)) / 10.0, 1), **acc})


def _orbits(folder: Path) -> None:
    """Write a gyro and a magnetometer in orbit: without a date, without names of its columns, with scale factors."""
    bias, offset = np.radians([0.03, -0.02, 0.01]), np.array([2e-7, -1e-7, 3e-7])
    made = in_orbit(np.random.default_rng(8), 3000.0, bias=bias, offset=offset)
    text = made.write(folder / "orbit_elapsed.csv", geodetic=True).read_text(encoding="utf-8")
    (folder / "orbit_bare.csv").write_text(text.replace("mx [", "b1 [").replace("my [", "b2 [").replace("mz [", "b3 ["))
    (folder / "orbit_where.csv").write_text(
        text.replace("lat [", "p1 [").replace("lon [", "p2 [").replace("alt [", "p3 [")
    )
    turned = np.diag([1.02, 0.99, 1.0])
    in_orbit(np.random.default_rng(8), 3000.0, bias=bias, offset=offset, magnetometer=turned).write(
        folder / "orbit_scale.csv"
    )


def _flown(folder: Path) -> None:
    """Write flips of several flights, with and without the unit of their biases, and the ground model of their head."""
    made = flights(Flights(), 1).extras
    text = made["flips.csv"].text
    (folder / "flown.json").write_text(made["ground.json"].text, encoding="utf-8")
    (folder / "flown.csv").write_text(text, encoding="utf-8")
    (folder / "flown_bare.csv").write_text(text.replace("bias [ug],u [ug]", "bias,u"), encoding="utf-8")


def _body(folder: Path) -> None:
    """Write three heads on a line, of which two are calibrated, and the file of their body."""
    made = on_one_body(on_line(), np.random.default_rng(5))
    for path in made.write(folder):
        path.replace(folder / f"body_{path.name}")
    (folder / "body.toml").write_text(made.toml(biases=True).replace("[heads.", "[heads.body_"), encoding="utf-8")
