"""A gyro and a magnetometer in a circular orbit, made without any code of the package.

The field is that of ``ppigrf`` by geodetic coordinates (the estimator takes it by spherical ones), turned to axes
that do not turn through the local level. The attitude is a product of three rotations whose angles are smooth
functions of time, evaluated ten times as often as it is recorded: rates are the rotation vectors between two of
these."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]
EARTH = 7.292115e-5  # [rad/s]
GM, A, F = 3.986004418e14, 6378137.0, 1.0 / 298.257223563
DEG = np.pi / 180.0
FINE = 4  # attitudes a sample
DATE = datetime(2026, 3, 1)


@dataclass
class Orbit:
    """What was recorded, and what is true."""

    time: Array  # [s]
    rates: Array  # (n, 3) [rad/s]
    field: Array  # (n, 3) [T]
    position: Array  # (n, 3) earth-fixed [m]
    geodetic: Array  # (n, 3) latitude, longitude [rad], height [m]
    bias: Array  # [rad/s]
    offset: Array  # [T]
    true_rates: Array  # [rad/s]

    def write(self, path: Path, geodetic: bool = False, **columns: Any) -> Path:
        """Write it as a table, earth-fixed in km or geodetic in degrees."""
        head = ["time [s]", "gx [deg/s]", "gy [deg/s]", "gz [deg/s]", "mx [uT]", "my [uT]", "mz [uT]"]
        if geodetic:
            head += ["lat [deg]", "lon [deg]", "alt [km]"]
            place = np.column_stack([self.geodetic[:, :2] / DEG, self.geodetic[:, 2] / 1e3])
        else:
            head += ["ecef_x [km]", "ecef_y [km]", "ecef_z [km]"]
            place = self.position / 1e3
        table = np.column_stack([self.time, self.rates / DEG, self.field * 1e6, place, *columns.values()])
        lines = [",".join([*head, *columns])]
        lines += [",".join("" if np.isnan(value) else f"{value:.10g}" for value in row) for row in table]
        path.write_text("\n".join(lines) + "\n", encoding="utf-8", newline="\n")
        return path


def recorded(
    rng: np.random.Generator,
    seconds: float = 5740.0,
    step: float = 1.0,
    motion: str = "tumbling",
    noise_field: float = 50e-9,
    noise_rate: float = 0.004 * DEG,
    bias: Array | None = None,
    offset: Array | None = None,
    drift: float = 0.0,
    gyro: Array | None = None,
    magnetometer: Array | None = None,
    extra: Array | None = None,
    late: float = 0.0,
    track: Array | None = None,
) -> Orbit:
    """Return one record.

    ``gyro`` and ``magnetometer``: matrices that the triads read through; ``drift``: of the bias of x from first to last
    sample [rad/s]; ``extra``: field beyond the model in axes that do not turn [T]; ``late``: the position is that of so
    much earlier [s]; ``track``: earth-fixed positions in place of a circular orbit [m].
    """
    n = int(seconds / step)
    fine = (np.arange((n + 1) * FINE) - FINE // 2) * step / FINE
    time = np.asarray(np.arange(n) * step, dtype=np.float64)
    attitude = _attitude(rng, fine, motion)
    turned = (attitude[:-1] * attitude[1:].inv()).as_rotvec() / (step / FINE)
    rates = turned[: n * FINE].reshape(n, FINE, 3).mean(axis=1)
    inclination, node, start = np.arccos(rng.uniform(-0.3, 0.7)), rng.uniform(0, 6.28), rng.uniform(0, 6.28)
    now = _track(time, inclination, node, start) if track is None else track
    geodetic = _geodetic(now)
    reference = _field(geodetic, time) + (0.0 if extra is None else extra)
    body = attitude[FINE // 2 : FINE // 2 + n * FINE : FINE].apply(reference)
    bias = rng.normal(0.0, 0.05 * DEG, 3) if bias is None else bias
    offset = rng.normal(0.0, 300e-9, 3) if offset is None else offset
    seen = rates @ (np.eye(3) if gyro is None else gyro).T + bias + np.outer(np.linspace(0, drift, n), [1.0, 0.0, 0.0])
    read = body @ (np.eye(3) if magnetometer is None else magnetometer).T + offset
    told = _track(time - late, inclination, node, start) if late else now
    return Orbit(
        time,
        seen + rng.normal(0.0, noise_rate, (n, 3)),
        read + rng.normal(0.0, noise_field, (n, 3)),
        told,
        _geodetic(told) if late else geodetic,
        bias,
        offset,
        rates,
    )


def _attitude(rng: np.random.Generator, t: Array, motion: str) -> Rotation:
    """Return body from axes that do not turn."""
    begin = Rotation.from_rotvec(rng.normal(0.0, 1.5, 3))
    if motion == "tumbling":
        spin, wobble, slow = rng.uniform(0.15, 0.4), rng.uniform(0.3, 1.0), rng.uniform(200.0, 900.0)
        angles = np.column_stack([
            spin * DEG * t, wobble * np.sin(2 * np.pi * t / slow), rng.uniform(0.05, 0.2) * DEG * t
        ])  # fmt: skip
        return Rotation.from_euler("ZXZ", angles).inv() * begin
    rate = 0.063 * DEG  # once an orbit about y, with some tenths of a degree of libration
    angles = np.column_stack([
        rate * t + 0.01 * np.sin(2 * np.pi * t / 700.0),
        0.01 * np.sin(2 * np.pi * t / 1100.0 + 1.0),
        0.01 * np.sin(2 * np.pi * t / 900.0),
    ])  # fmt: skip
    return Rotation.from_euler("YXZ", angles).inv() * begin


def _track(t: Array, inclination: float, node: float, start: float) -> Array:
    """Return earth-fixed positions of a circular orbit at 560 km [m]."""
    radius = A + 560e3
    u = start + np.sqrt(GM / radius**3) * t
    plane = np.column_stack([np.cos(u), np.sin(u) * np.cos(inclination), np.sin(u) * np.sin(inclination)])
    return np.asarray(radius * Rotation.from_euler("z", (node - EARTH * t)[:, None]).apply(plane))


def _geodetic(position: Array) -> Array:
    """Return latitude, longitude [rad] and height [m] over the ellipsoid, by iteration."""
    x, y, z = position.T
    level, e2 = np.hypot(x, y), F * (2.0 - F)
    latitude = np.arctan2(z, level * (1.0 - e2))
    for _ in range(8):
        across = A / np.sqrt(1.0 - e2 * np.sin(latitude) ** 2)
        height = level / np.cos(latitude) - across
        latitude = np.arctan2(z, level * (1.0 - e2 * across / (across + height)))
    return np.column_stack([latitude, np.arctan2(y, x), height])


def _field(geodetic: Array, t: Array) -> Array:
    """Return the field in the earth's axes at the first instant, which do not turn [T]."""
    import ppigrf

    latitude, longitude, height = geodetic.T
    east, north, up = (np.ravel(one) * 1e-9 for one in
                       ppigrf.igrf(longitude / DEG, latitude / DEG, height / 1e3, DATE))  # fmt: skip
    local = Rotation.from_euler("ZY", np.column_stack([longitude, -latitude]))  # up, east, north to earth-fixed
    return np.asarray(
        Rotation.from_euler("z", (EARTH * t)[:, None]).apply(local.apply(np.column_stack([up, east, north])))
    )
