"""Accelerometer heads on one rigid body in orbit, made without any code of the package.

The body keeps its local vertical (x up, y against the orbit's normal) but for small turns, sums of sines; its rate and
angular acceleration are their derivatives. Each head feels what its place feels: the acceleration of the body's middle
(drag and vibration, sums of sines), the turn of the body by the velocity of the place, differentiated in time, and the
difference of the attraction of a point earth between its place and the middle, not the gradient. Samples are means
by three points of Gauss; a clock that is ahead by dt stamps the instant t with t + dt.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]
GM, RADIUS = 3.986004418e14, 6371e3 + 400e3
ORBIT = float(np.sqrt(GM / RADIUS**3))  # [rad/s]
UG = 9.80665e-6  # [m/s^2]


@dataclass
class Placed:
    """A head as it truly is, and what is stated of it."""

    name: str
    place: tuple[float, float, float]  # stated [m]
    calibrated: bool = True
    turned: tuple[float, float, float] = (0.0, 0.0, 0.0)  # stated rotation vector, head from body [rad]
    ahead: float = 0.0  # of its clock [s]
    gain: Array = field(default_factory=lambda: np.zeros((3, 3)))  # scale factor errors and misalignment
    moved: tuple[float, float, float] = (0.0, 0.0, 0.0)  # true less stated place [m]
    tilted: tuple[float, float, float] = (0.0, 0.0, 0.0)  # true after stated orientation [rad]


@dataclass
class Scene:
    """What happens on the body."""

    heads: tuple[Placed, ...]
    seconds: float = 2400.0
    step: float = 2.0
    noise: float = 1.0 * UG  # of a sample, white
    slow: float = 0.3 * UG  # standard deviation of a part with a memory
    memory: float = 60.0  # [s]
    vibration: float = 50.0 * UG  # of each axis
    drag: float = 0.3 * UG
    turning: float = 3e-5  # standard deviation of small rates about each axis [rad/s]
    bias: float = 50.0 * UG  # standard deviation of what is drawn
    position_u: float = 1e-3
    orientation_u: float = 1e-3
    bias_u: float = 0.1 * UG
    lines: int = 20


@dataclass
class Made:
    """What was recorded, and what is true."""

    times: Array  # [s]
    read: dict[str, Array]  # (n, 3) in axes of the head [m/s^2]
    gyro: Array  # (n, 3) [rad/s]
    bias: dict[str, Array]  # (3,) [m/s^2]
    said: dict[str, Array]  # bias of calibrated heads as it is stated
    scene: Scene

    def toml(self, biases: bool, motion: str = "", gyro: str = "") -> str:
        """Return the file of the body."""
        lines = []
        for one in self.scene.heads:
            turn = Rotation.from_rotvec(one.turned).as_matrix()
            lines += [f"[heads.{one.name}]", f"position = {[f'{x} m' for x in one.place]}",
                      f'position_u = "{self.scene.position_u} m"', f"orientation = {turn.tolist()}",
                      f'orientation_u = "{self.scene.orientation_u} rad"']  # fmt: skip
            if one.calibrated and biases:
                lines += [f"bias = {[f'{x!r} m/s^2' for x in self.said[one.name].tolist()]}",
                          f"bias_u = {[f'{self.scene.bias_u!r} m/s^2'] * 3}"]  # fmt: skip
            elif one.calibrated:
                lines.append("calibrated = true")
        return "\n".join([*lines, motion, gyro, ""])

    def write(self, folder: Path) -> list[Path]:
        """Write a table a head."""
        paths = []
        for name, read in self.read.items():
            table = np.column_stack([self.times, read / UG])
            rows = [",".join(f"{value:.10g}" for value in row) for row in table.tolist()]
            path = folder / f"{name}.csv"
            head = "time [s],ax [ug],ay [ug],az [ug]"
            path.write_text("\n".join([head, *rows]) + "\n", encoding="utf-8", newline="\n")
            paths.append(path)
        return paths


def on_line(third: float = 0.5, **changes: Any) -> Scene:
    """Return three heads on a line, the third a part of the way."""
    heads = (Placed("a", (0.0, 0.0, 0.0)), Placed("b", (0.0, 2.0, 0.0)), Placed("c", (0.0, 2.0 * third, 0.0), False))
    return replace(Scene(heads), **changes)


def made(scene: Scene, rng: np.random.Generator) -> Made:
    """Return what the heads of a scene read."""
    times = np.arange(0.0, scene.seconds, scene.step) + 0.5 * scene.step
    shake = _sines(rng, scene.lines, 0.004, 0.2 / scene.step, scene.vibration)
    turn = _sines(rng, 8, 0.001, 0.05 / scene.step, scene.turning)
    drag = _sines(rng, 1, ORBIT / 6.3, ORBIT / 6.28, scene.drag)
    bias, said, read = {}, {}, {}
    for one in scene.heads:
        own = times - one.ahead
        at = np.array(one.place) + one.moved
        clean = sum(
            weight * _felt(own + dt * scene.step, at, shake, turn, drag)
            for dt, weight in ((-0.5 * np.sqrt(0.6), 5.0 / 18.0), (0.0, 8.0 / 18.0), (0.5 * np.sqrt(0.6), 5.0 / 18.0))
        )
        tilt = Rotation.from_rotvec(rng.normal(0.0, scene.orientation_u, 3) + one.tilted)
        moved = np.asarray((tilt * Rotation.from_rotvec(one.turned)).apply(clean))
        bias[one.name] = rng.normal(0.0, scene.bias, 3)
        said[one.name] = bias[one.name] + rng.normal(0.0, scene.bias_u, 3)
        keep = np.exp(-scene.step / scene.memory)
        drawn = rng.normal(0.0, scene.slow * np.sqrt(1.0 - keep**2), (len(times) + 200, 3))
        slow = lfilter([1.0], [1.0, -keep], drawn, axis=0)[200:]
        noise = rng.normal(0.0, scene.noise, (len(times), 3)) + slow
        read[one.name] = moved @ (np.eye(3) + one.gain).T + bias[one.name] + noise
    rates = turn(times)[0] + np.array([0.0, -ORBIT, 0.0]) + rng.normal(0.0, 1e-6, (len(times), 3))
    return Made(times, read, rates, bias, said, scene)


def _sines(rng: np.random.Generator, count: int, low: float, high: float, size: float):  # type: ignore[no-untyped-def]
    """Return a function of time that gives sums of sines and their derivatives, (n, 3) each."""
    pace = 2.0 * np.pi * np.exp(rng.uniform(np.log(low), np.log(high), (count, 3)))
    phase = rng.uniform(0.0, 2.0 * np.pi, (count, 3))
    amplitude = size * np.sqrt(2.0 / count)

    def at(times: Array) -> tuple[Array, Array]:
        angle = times[:, None, None] * pace + phase
        return amplitude * np.sin(angle).sum(axis=1), amplitude * (pace * np.cos(angle)).sum(axis=1)

    return at


def _felt(times: Array, place: Array, shake, turn, drag) -> Array:  # type: ignore[no-untyped-def]
    """Return the specific force at a place of the body, in its axes, (n, 3)."""
    small, change = turn(times)
    spin = small + np.array([0.0, -ORBIT, 0.0])
    velocity = np.cross(spin, place)
    felt = np.cross(change, place) + np.cross(spin, velocity)
    middle = np.array([RADIUS, 0.0, 0.0])
    there = middle + place
    pull = -GM * (there / np.linalg.norm(there) ** 3 - middle / RADIUS**3)
    return np.asarray(shake(times)[0] + drag(times)[0] + np.array([0.0, 0.0, -1e-6]) + felt - pull)
