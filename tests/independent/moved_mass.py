"""An accelerometer that counts pulses while a mass is moved before it, and a known drive in drift.

A cycle is four dwells: the mass in the middle, near, in the middle, far: ``applied = a (0, 1, 0, -1)``. A row is a
dwell of 100 s of counting, then 20 s to move (Reinel 1969). What is counted::

    pulses = round(gate (S (applied + g tilt) + drift + noise))

``drift`` has a shape over the run, of unit range, times its size in responses ``S a``; most shapes repeat in every run.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import sawtooth

from .case import START, Array, Case, Table, toml

G = 9.80665
UG = 1e-6 * G
DWELL, GATE = 120.0, 100.0

SHAPES = (
    "none", "line", "exp3", "exp10", "exp30", "cubic", "sine3", "sine6.7", "sine5", "kink", "sqrt", "sawtooth",
    "smooth", "walk",
)  # fmt: skip


@dataclass(frozen=True)
class Bench:
    """Truth of the instrument and its test; responses and noise in counts a second."""

    scale_factor: float = 10.2  # [count/s/ug]
    applied: float = 0.023  # amplitude [ug]
    noise: float = 0.056  # white, of a dwell
    walk: float = 0.0  # step of a random walk from dwell to dwell
    shape: str = "none"  # of the drift
    size: float = 0.0  # its range over the run, in responses
    repeats: bool = True  # the same in every run, but for "smooth" and "walk"
    scatter: float = 0.0  # standard deviation of the drift's size from run to run, as a part
    tilt: float = 0.0  # of the pad in phase with the drive [rad]
    tilt_wander: float = 0.0  # step of its walk from dwell to dwell [rad]
    meter: float = 0.0  # noise of the tilt meter [rad]; 0: no meter
    spread: float = 0.0  # standard deviation of the scale factor from run to run, as a part
    worse: float = 1.0  # noise of the first run over that of the others
    u_applied: float = 0.002  # stated, relative; the error is drawn


@dataclass(frozen=True)
class Schedule:
    """How it was run."""

    runs: int = 4
    dwells: int = 100
    starts: tuple[int, ...] = (0,)  # by how much the drives start ahead [deg], which runs take one after the other
    lost: tuple[int, ...] = ()  # dwells that were not read, in every run


def shape(name: str, n: int, rng: np.random.Generator) -> Array:
    """Return a drift over n dwells, of unit range (a sine: amplitude 1/2)."""
    x = (np.arange(n) + 0.5) / n
    if name.startswith("exp"):
        values = np.exp(-x * float(name[3:]))
    elif name.startswith("sine"):
        values = np.sin(2.0 * np.pi * np.arange(n) / (4.0 * 3.0 if name == "sine3" else float(name[4:])) + 0.7)
    elif name == "smooth":  # integrated walk, seen through its slowest tenth
        steps = np.cumsum(np.cumsum(rng.standard_normal(n)))
        values = steps - np.polyval(np.polyfit(x, steps, 1), x)
    else:
        values = np.asarray(
            {
                "none": 0.0 * x,
                "line": x,
                "cubic": (x - 0.4) ** 3 - 0.1 * x,
                "kink": np.abs(x - 0.43),
                "sqrt": np.sqrt(x),
                "sawtooth": sawtooth(2.0 * np.pi * x * 7.3),
                "walk": np.cumsum(rng.standard_normal(n)),
            }[name]
        )
    span = float(np.ptp(values))
    return np.asarray(values / span if span else values)


def moved(
    seed: int, bench: Bench | None = None, schedule: Schedule | None = None, tilt: str = "known", again: int = 0
) -> Case:
    """Return runs with a moved mass: a table a run, and the schedule. ``tilt``: how the command uses the meter.

    ``again``: the test is made once more, with the same mass.
    """
    bench, schedule = bench or Bench(), schedule or Schedule()
    rng = np.random.default_rng([5, seed])
    n = schedule.dwells
    response = bench.scale_factor * bench.applied
    true_applied = bench.applied * (1.0 + bench.u_applied * rng.standard_normal())
    rng = np.random.default_rng([5, seed, 1, again]) if again else rng
    tables, texts, entries, schedules = {}, {}, {}, []
    fixed = shape(bench.shape, n, rng)
    for run in range(1, schedule.runs + 1):
        ahead = schedule.starts[(run - 1) % len(schedule.starts)]
        drive = np.sin(0.5 * np.pi * np.arange(n) + np.radians(ahead))
        noise = bench.noise * (bench.worse if run == 1 else 1.0)
        gain = bench.scale_factor * (1.0 + bench.spread * rng.standard_normal()) if bench.spread else bench.scale_factor
        drift = fixed if bench.repeats and bench.shape not in ("smooth", "walk") else shape(bench.shape, n, rng)
        drift = bench.size * response * (1.0 + bench.scatter * rng.standard_normal()) * drift
        pad = bench.tilt * drive + bench.tilt_wander * np.cumsum(rng.standard_normal(n))
        rate = gain * (true_applied * drive + pad / UG * G) + drift
        rate += bench.walk * np.cumsum(rng.standard_normal(n)) + noise * rng.standard_normal(n)
        columns = {
            "unix_s": START + 1e5 * run + DWELL * np.arange(n) + GATE / 2.0,
            "pulses [count]": np.rint(GATE * (150.0 + rate)).astype(np.int64),
        }
        if bench.meter:
            columns["tilt [rad]"] = pad + bench.meter * rng.standard_normal(n)
        table = Table(columns, ("pulses [count]",), "unix_s", form={"unix_s": "%.1f", "tilt [rad]": "%.4e"})
        keep = np.ones(n, dtype=bool)
        keep[list(schedule.lost)] = False
        table.taken(keep)
        tables[f"run{run}.csv"] = table
        name = f"schedule_{ahead}.csv" if ahead else "schedule.csv"
        schedules.append(name)
        texts[name] = schedule_text(bench, drive)
        channels: dict[str, object] = {"x": {"column": "pulses [count]", "unit": "count"}}
        if bench.meter:
            channels["tilt"] = {"column": "tilt [rad]", "unit": "rad"}
        entries[f"recordings.run{run}"] = {
            "sensor": "mesa", "file": f"run{run}.csv", "run": f"run{run}",
            "clock": {"column": "unix_s", "stamp": "middle", "interval": f"{DWELL} s", "averaging": f"{GATE} s"},
            "mass": {"schedule": name, "begin": START + 1e5 * run}, "channels": channels,
        }  # fmt: skip
    chain = {"kind": "pulse_rate", "gate": f"{GATE} s", "scale_factor": "10 count/s/ug"}
    test = {"id": "mass", "procedure": "mass_attraction", "recordings": [name[:-4] for name in tables]}
    plan = {"tilt": tilt if bench.meter else "ignored"}
    texts["campaign.toml"] = toml(
        {
            "schema": 2,
            "campaign": {"id": "mass"},
            "standards.source_mass": {"density": {"u": f"{100 * bench.u_applied} %"}},
        }
        | {"sensors.mesa": {"kind": "accelerometer", "axes": ["x"], "unit": "ug", "chain": chain}}
        | entries
        | {"tests": [test | {"plan": plan}]}
    )
    words = ["mass-attraction", *(f"@{name}" for name in tables), "--gate", f"{GATE} s"]
    for name in schedules if len(schedule.starts) > 1 else schedules[:1]:
        words += ["--schedule", f"@{name}"]
    words += ["--column", "x=pulses [count]", "--scale-factor", "10 count/s/ug", "--tilt", plan["tilt"]]
    words += ["--standard", f"source_mass.density={100 * bench.u_applied} %", "--unit", "acc=count"]
    words += ["--column", "tilt=tilt [rad]"] if bench.meter else []
    truth = {"scale_factor x": bench.scale_factor}
    case = Case(
        "mass_attraction", tables, words, truth, texts, noise=GATE * bench.noise, rate=1.0 / DWELL, rng_seed=seed
    )
    white = float(np.hypot(bench.noise, 1.0 / GATE / np.sqrt(12.0))) * np.sqrt(2.0 / n / schedule.runs)
    each = np.full(schedule.runs, white * np.sqrt(schedule.runs) / response)
    each[0] *= bench.worse
    best = float(np.sqrt(1.0 / np.sum(1.0 / (each**2 + bench.spread**2))))  # of runs weighted as they deserve
    case.ideal = {"scale_factor x": bench.scale_factor * float(np.hypot(best, bench.u_applied))}
    return case


def schedule_text(bench: Bench, drive: Array) -> str:
    """Return the schedule as a file: a row a dwell, from the start of the run."""
    start = DWELL * np.arange(len(drive))
    rows = [
        f"{a:.1f},{a + GATE:.1f},{0.3 - 0.15 * s:.4f},{bench.applied * UG * s:.9e}"
        for a, s in zip(start, drive, strict=True)
    ]
    return "\n".join(["start [s],stop [s],position [m],applied [m/s^2]", *rows]) + "\n"


def lock_in(case: Case) -> float:
    """Return the mean response over the runs [count/s]: regression on the drive, its quadrature and a cubic."""
    found = []
    for table in case.tables.values():
        t = np.rint((table.columns["unix_s"] - table.columns["unix_s"][0]) / DWELL)
        x = np.column_stack(
            [np.sin(np.pi * t / 2), np.cos(np.pi * t / 2), *(np.polynomial.legendre.legvander(t / t[-1], 3).T)]
        )
        found.append(np.linalg.lstsq(x, table.columns["pulses [count]"] / GATE, rcond=None)[0][0])
    return float(np.mean(found))


def driven(
    seed: int, amplitude: float = 23.0, period: float = 4.0, n: int = 4000, rate: float = 1.0, noise: float = 10.0,
    averaging: float = 0.0, drift: float = 5.0, words: tuple[str, ...] = (),
) -> Case:  # fmt: skip
    """Return a record under a sinusoidal drive [ng], in noise and a slow drift; samples are points, or means."""
    rng = np.random.default_rng([6, seed])
    time = np.arange(n) / rate
    seen = amplitude * float(np.sinc(averaging / period))
    y = seen * np.sin(2.0 * np.pi * time / period) + noise * rng.standard_normal(n)
    y += drift * np.cumsum(rng.standard_normal(n)) / np.sqrt(n)
    table = Table({"time [s]": time, "acc_x [ng]": y}, ("acc_x [ng]",), "time [s]", form={"time [s]": "%.4f"})
    command = ["sine", "@driven.csv", "--period", f"{period} s", "--phase", "0 deg", *words]
    return Case(
        "sine", {"driven.csv": table}, command, {"amplitude x": amplitude}, noise=noise, rate=rate, rng_seed=seed
    )
