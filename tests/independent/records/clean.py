"""Clean records of every kind, simulated and real: of these at most 9 in 900 may bring a remark of the gate.

A record is what one command is given: a file or a campaign, with all of its channels and runs. Its size, sample rate
and terms are drawn from the seed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import h5py
import numpy as np

from .. import flip, moved_mass, positions, rate_table, static, thermal
from ..case import START, Array, Case, Table
from ..static import Noise
from . import bases, variations
from .bases import SHARED

MOST = 9  # of 900 (issue 20)
# Remarks and refusals of issue 20. Those of the files (gaps, clocks) stood before it and count here too.
CODES = {
    "glitch", "disturbed", "saturated", "stuck", "repeated", "repeated_samples", "missing", "level_step",
    "noise_change", "slow_wave", "not_at_rest", "unscreened", "unscreened_refused",
    "gaps", "time_backwards", "stamps_not_used", "sample_rate_disagrees",
    "sample_rate_suspect", "clock_disagrees", "grouped_digits", "header_repeated", "zero_uncertainty",
    "impossible_temperature", "impossible_acceleration", "impossible_rate", "impossible_pressure", "impossible_voltage",
    "impossible_frequency", "beyond_range", "implausible_acceleration", "unit_changed", "sign_changed",
    "scale_changed", "axes_changed", "gain_changed", "jump", "odd_scatter",
    "sign_disagrees", "unit_disagrees", "axes_disagree", "gain_disagrees", "reading_disagrees", "recording_differs",
    "run_differs", "runs_differ", "runs_disagree", "gate_disagrees", "copy_of_applied", "duplicate_recording",
}  # fmt: skip


@dataclass(frozen=True)
class Kind:
    """Records of one kind: how many of the 900, and what makes one of a seed."""

    name: str
    number: int
    case: Callable[[int], Case]


def _still(noise: Noise, rounded: float = 0.0, noun: str = "allan") -> Callable[[int], Case]:
    """Return records at rest of 2,000 to 60,000 samples at 10 to 400 samples a second, one to three axes."""

    def made(seed: int) -> Case:
        rng = np.random.default_rng([10, seed])
        n, rate = round(float(np.exp(rng.uniform(np.log(2e3), np.log(6e4))))), float(rng.choice([10, 25, 50, 100, 400]))
        scale = np.sqrt(50.0 / rate)  # the terms keep their place in the record, in samples
        terms = Noise(
            white=noise.white * scale, flicker=noise.flicker, walk=noise.walk / scale, ramp=noise.ramp / scale**2,
            rounded_angle=noise.rounded_angle * scale**2, corner=noise.corner / scale**2, order=noise.order,
            bias=float(rng.normal(scale=0.05)),
        )  # fmt: skip
        step = rounded * terms.white * np.sqrt(rate)
        axes = dict.fromkeys("xyz"[: int(rng.integers(1, 4))], terms)
        case = static.still(seed, axes, n, rate, step=step)
        case.words[0] = noun
        return case

    return made


@cache
def _gyro() -> Array:
    return bases.real(0).tables["real.csv"].columns["gyro_x [deg/s]"]


def _gyro_piece(seed: int) -> Case:
    """Return 2,500 samples of the real gyro: the n-th piece."""
    n = 2500
    values = _gyro()[(seed - 1) * n : seed * n]
    columns = {"unix_s": START + np.arange(n) / 100.0, "gyro_x [deg/s]": values}
    return _at_rest(columns, 100.0, "%.5f")


def _at_rest(columns: dict[str, Array], rate: float, form: str) -> Case:
    signals = tuple(name for name in columns if name != "unix_s")
    table = Table(columns, signals, "unix_s", form={"unix_s": "%.4f"} | dict.fromkeys(signals, form))
    return Case("allan", {"still.csv": table}, ["allan", "@still.csv"], {}, rate=rate)


@cache
def _xsens(sensor: str) -> Array:
    return np.loadtxt(SHARED / f"imu_tk_xsens_mti/xsens_{sensor}.mat")[:4800]


def _xsens_piece(seed: int) -> Case:
    """Return 600 samples of an MTi before it is picked up: accelerometers, then gyros, in counts about mid-scale."""
    sensor, piece = ("acc", "gyro")[(seed - 1) // 8], (seed - 1) % 8
    values = _xsens(sensor)[600 * piece : 600 * (piece + 1), 1:] - 32768.0
    unit, gain = ("m/s^2", 414.0) if sensor == "acc" else ("deg/s", 4770.0 * np.pi / 180.0)
    columns = {"unix_s": START + np.arange(600) / 100.0}
    columns |= {f"{sensor}_{axis} [{unit}]": values[:, i] / gain for i, axis in enumerate("xyz")}
    return _at_rest(columns, 100.0, "%.6f")


def _archive_piece(seed: int) -> Case:
    """Return a quarter of the real pair of the archive, for info: the station vibrates, so it is not at rest."""
    case = variations.archive(0)
    case.words = ["info", "@"]
    case.tables["still.csv"].taken(slice(2090 * (seed - 1), 2090 * seed))
    return case


STILL_MPU = (
    "set-1__unmoved-x-pointing-forward", "set-1__unmoved-z-pointing-left", "set-2__unmoved-with-x-pointing-forward",
    "set-2__unmoved-with-z-pointing-front-and-x-up", "set-2__unmoved-with-z-pointing-front-and-y-down",
)  # fmt: skip


def _mpu(seed: int) -> Case:
    """Return an MPU-6050 that nobody moves, the first 60 s.

    The record that its author calls disturbed is left out; after 62.8 s one of the others is padded with zeros.
    """
    with h5py.File(SHARED / "sunsided_mpu6050_static" / STILL_MPU[seed - 1] / "mpu6050_gyroscope.mat") as file:
        values = np.asarray(next(one for one in file.values() if isinstance(one, h5py.Dataset))[()], dtype=float)
    values = values if values.shape[0] > values.shape[1] else values.T
    values = values[:6000]
    columns = {"unix_s": START + np.arange(len(values)) / 100.0}
    columns |= {f"gyro_{axis} [deg/s]": values[:, i - 3] for i, axis in enumerate("xyz")}
    return _at_rest(columns, 100.0, "%.6f")


def _table(seed: int) -> Case:
    rng = np.random.default_rng([11, seed])
    top = float(rng.choice([5.0, 20.0, 100.0]))
    protocol = rate_table.Protocol(
        rates=tuple(float(rate) for rate in np.array([-1.0, -0.5, -0.2, 0.2, 0.5, 1.0]) * top),
        axes=str(rng.choice(["x", "xy", "xyz"])), runs=int(rng.integers(1, 6)), samples=int(rng.integers(60, 250)),
        rate=float(rng.choice([10.0, 20.0, 50.0])), shuffled=bool(rng.random() < 0.5),
    )  # fmt: skip
    gyros = rate_table.Gyros(turn_on=float(rng.choice([0.0, 0.003, 0.05])), limit=3.0 * top, sample=0.02)
    return rate_table.recorded(seed, gyros, protocol, held_out=int(rng.integers(0, 2)))


def _means(seed: int) -> Case:
    rng = np.random.default_rng([12, seed])
    top = float(rng.choice([10.0, 90.0, 300.0]))
    protocol = rate_table.Protocol(
        rates=tuple(float(rate) for rate in np.array([-1.0, -0.5, -0.2, 0.2, 0.5, 1.0]) * top),
        runs=int(rng.integers(1, 6)), shuffled=bool(rng.random() < 0.5),
    )  # fmt: skip
    gyros = rate_table.Gyros(
        turn_on=float(rng.choice([0.0, 0.003, 0.05])), dwell=float(rng.choice([0.0, 0.002])), asymmetry=(1e-3, 0.0, 0.0)
    )
    return rate_table.reduced(seed, gyros, protocol)


def _chamber(seed: int) -> Case:
    rng = np.random.default_rng([13, seed])
    unit = thermal.Unit(
        hysteresis=float(rng.choice([0.0, 0.004])), lag=float(rng.choice([0.0, 60.0])),
        turn_on=float(rng.choice([0.001, 0.003, 0.01])), warm_up=float(rng.choice([0.0, 0.01])),
    )  # fmt: skip
    return thermal.ramped(seed, unit, thermal.Chamber(runs=int(rng.integers(2, 6))), str(rng.choice(["x", "xyz"])))


def _mass(seed: int) -> Case:
    rng = np.random.default_rng([14, seed])
    bench = moved_mass.Bench(
        shape=str(rng.choice(["none", "line", "exp3", "walk"])), size=float(rng.choice([1.0, 5.0])),
        noise=float(rng.choice([0.03, 0.056, 0.1])),
    )  # fmt: skip
    return moved_mass.moved(
        seed, bench, moved_mass.Schedule(runs=int(rng.integers(2, 6)), dwells=4 * int(rng.integers(15, 40)))
    )


def _turned(seed: int) -> Case:
    rng = np.random.default_rng([15, seed])
    head = flip.Head(white=float(rng.choice([5.0, 20.0, 60.0])), slow=float(rng.choice([0.0, 1.0])))
    return flip.turned(seed, head, flip.Programme(dwells=int(rng.integers(4, 8)), dwell=(240.0, 300.0), rate=10.0))


def _hand(seed: int) -> Case:
    rng = np.random.default_rng([16, seed])
    unit = positions.Unit(upper_triangular=True, gyro_flicker=float(rng.choice([0.0, 2e-4])))
    return positions.by_hand(seed, unit, int(rng.integers(14, 26)), rate=float(rng.choice([50.0, 100.0])), rest=5.0)


SIMULATED = (
    Kind("white", 45, _still(Noise(white=4e-3))),
    Kind("flicker", 45, _still(Noise(white=4e-3, flicker=3e-3))),
    Kind("random walk", 45, _still(Noise(white=4e-3, walk=3e-4))),
    Kind("flicker and walk", 45, _still(Noise(white=4e-3, flicker=5e-3, walk=1e-4))),
    Kind("flicker alone", 20, _still(Noise(flicker=3e-3))),
    Kind("ramp", 30, _still(Noise(white=4e-3, ramp=5e-5))),
    Kind("quantised 0.3 sigma", 20, _still(Noise(white=4e-3), 0.3)),
    Kind("quantised 1 sigma", 20, _still(Noise(white=4e-3), 1.0)),
    Kind("quantised 4 sigma", 20, _still(Noise(white=4e-3), 4.0)),
    Kind("quantised angle", 25, _still(Noise(white=2e-3, rounded_angle=1e-4))),
    Kind("filtered at 1/10", 25, _still(Noise(white=4e-3, corner=5.0))),
    Kind("filtered at 1/25", 25, _still(Noise(white=4e-3, corner=2.0, order=2))),
    Kind("info, flicker and walk", 40, _still(Noise(white=4e-3, flicker=3e-3, walk=1e-4), 0.3, "info")),
    Kind("rate table, recordings", 65, _table),
    Kind("rate table, means", 60, _means),
    Kind("thermal", 60, _chamber),
    Kind("positions, by hand", 35, _hand),
    Kind("positions, six faces", 15, positions.six_faces),
    Kind(
        "positions, tumble", 15, lambda seed: positions.tumbled(seed, positions=14, condition=(0.0, 60.0), cone=180.0)
    ),
    Kind("flip", 55, _turned),
    Kind("mass attraction", 70, _mass),
)
REAL = (
    Kind("real gyro (l3g)", 95, _gyro_piece),
    Kind("real MTi at rest", 16, _xsens_piece),
    Kind("real archive", 4, _archive_piece),
    Kind("real MPU-6050", 5, _mpu),
)
KINDS = SIMULATED + (REAL if SHARED.is_dir() else ())
