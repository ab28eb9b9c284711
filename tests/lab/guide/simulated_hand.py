"""A hand that obeys a guide, badly, and the IMU in it: written from the physics, shares nothing with the product."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

G = 9.807
NS = 1_000_000_000


@dataclass(frozen=True)
class Habits:
    """How well a hand does what it is told; probabilities are of a position."""

    angle: tuple[float, float] = (3.0, 10.0)  # error of what it lays [deg]
    rest: tuple[float, float] = (4.0, 6.0)  # from laying to the next move, at least [s]
    turn: tuple[float, float] = (1.2, 2.5)  # [s]
    repeats: float = 0.05  # lays a position that it laid before
    wrong: float = 0.05  # lays any other
    early: float = 0.05  # takes it up after a second or two
    shakes: float = 0.05  # holds it in the hand for a while
    drops: float = 0.02
    unplugs: float = 0.02
    warm_up: float = 0.0  # bias at switching on, that goes away [m/s2]
    warm_time: float = 200.0  # with this time constant [s]


@dataclass
class Imu:
    """A triad of accelerometers and one of gyros, as they are."""

    rng: np.random.Generator
    rate: float = 100.0
    acc_noise: float = 0.02
    gyro_noise: float = 2e-3
    between: float = 1.5e-3
    M: Any = field(init=False)
    b: Any = field(init=False)
    W: Any = field(init=False)
    c: Any = field(init=False)

    def __post_init__(self) -> None:
        draw = self.rng.standard_normal
        self.M = np.tril(np.eye(3) + 0.01 * draw((3, 3)))
        self.b = 0.2 * draw(3)
        self.W = np.eye(3) + 0.01 * draw((3, 3))
        self.c = 0.01 * draw(3)

    def gyro_truth(self) -> dict[str, float]:
        """Return the figures of the gyros whose truth no frame changes, SI."""
        return {f"bias_{a}": float(self.c[i]) for i, a in enumerate("xyz")} | {
            f"scale_factor_error_{a}": float(self.W[i, i] - 1.0) for i, a in enumerate("xyz")
        }

    def truth(self) -> dict[str, float]:
        """Return the figures by name, SI."""
        M = self.M
        return {
            **{f"bias_{a}": float(self.b[i]) for i, a in enumerate("xyz")},
            **{f"scale_factor_error_{a}": float(M[i, i] - 1.0) for i, a in enumerate("xyz")},
            **{f"misalignment_{'xyz'[i]}{'xyz'[j]}": float(M[i, j] / M[i, i]) for i, j in ((1, 0), (2, 0), (2, 1))},
        }


@dataclass
class Hand:
    """Moves the IMU; each call of ``batch`` gives what came in half a second, after what the guide said."""

    seed: int
    habits: Habits = Habits()
    step: float = 0.5
    rate: float = 100.0

    def __post_init__(self) -> None:
        unit, self.rng = np.random.default_rng(self.seed).spawn(2)
        self.imu = Imu(unit, self.rate)
        self.pose = Rotation.random(random_state=int(self.rng.integers(2**31)))  # body to space
        self.t, self.shift = 0.0, self.imu.between * self.rng.standard_normal(3)
        self.queue: list[tuple[np.ndarray, np.ndarray]] = []  # samples that will come: (f, w), NaN rows are silence
        self.laid: list[np.ndarray] = []
        self.did: list[str] = []
        self._stay(3.0)

    @property
    def up(self) -> np.ndarray:
        """Up, in body axes."""
        return np.asarray(self.pose.inv().apply([0.0, 0.0, 1.0]))

    def batch(self, code: str, target: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
        """Return stamps [ns], specific force, rate; and the time now [s]."""
        many = round(self.step * self.imu.rate)
        while sum(len(one[0]) for one in self.queue) < many:
            self._decide(code, target)
        f, w = (np.vstack([one[k] for one in self.queue]) for k in (0, 1))
        self.queue = [(f[many:], w[many:])]
        at = self.t + np.arange(1, many + 1) / self.imu.rate
        self.t = float(at[-1])
        there = np.isfinite(f[:many, 0])
        return np.round(at[there] * NS).astype(np.int64), f[:many][there], w[:many][there], self.t

    def _decide(self, code: str, target: Any) -> None:
        habits, rng = self.habits, self.rng
        if code in {"hold_still", "lay_down"} or target is None:
            self._stay(self.step)
            return
        if code not in {"turn", "repeated", "held_in_hand"}:
            self._stay(self.step)
            return
        wish = np.asarray(target, dtype=float)
        p, chance = np.cumsum([habits.repeats, habits.wrong, habits.drops, habits.unplugs, habits.shakes]), rng.random()
        what = int(np.searchsorted(p, chance))
        if what == 0 and self.laid:
            wish = self.laid[int(rng.integers(len(self.laid)))]
            self.did.append("repeats")
        elif what == 1:
            wish = rng.standard_normal(3)
            self.did.append("wrong")
        elif what == 2:
            self._drop()
            self.did.append("drops")
        elif what == 3:
            if rng.random() < 0.5:  # and is turned meanwhile
                self.pose = self.pose * Rotation.from_rotvec(rng.uniform(-2.0, 2.0, 3))
            self._stay(float(rng.uniform(2.0, 10.0)), silent=True)
            self.did.append("unplugs")
        self._lay(wish)
        if what == 4:
            self._shake(float(rng.uniform(4.0, 9.0)))
            self.did.append("shakes")
        if rng.random() < habits.early:
            self._stay(float(rng.uniform(1.0, 2.5)))
            self.did.append("early")
            self._lay(rng.standard_normal(3))
        self.laid.append(self.up)
        self._stay(float(rng.uniform(*habits.rest)))

    def _lay(self, wish: np.ndarray) -> None:
        rng = self.rng
        off = np.radians(rng.uniform(*self.habits.angle))
        wish = wish / np.linalg.norm(wish)
        side = np.cross(wish, rng.standard_normal(3))
        wish = np.cos(off) * wish + np.sin(off) * side / np.linalg.norm(side)
        a, b = self.up, wish
        axis = np.cross(b, a)
        if np.linalg.norm(axis) < 1e-6:
            axis = np.cross(a, rng.standard_normal(3))
        angle = np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b)
        turn = Rotation.from_rotvec(angle * axis / np.linalg.norm(axis))
        about = Rotation.from_rotvec(rng.uniform(-0.6, 0.6) * a)
        self._turn((about * turn).as_rotvec(), float(rng.uniform(*self.habits.turn)))
        self.shift = self.imu.between * rng.standard_normal(3)

    def _turn(self, vector: np.ndarray, seconds: float) -> None:
        n = round(seconds * self.imu.rate)
        share = np.linspace(0.0, 1.0, n + 1)
        share = share - np.sin(2.0 * np.pi * share) / (2.0 * np.pi)
        w = np.diff(share)[:, None] * vector * self.imu.rate
        middle = 0.5 * (share[1:] + share[:-1])
        poses = self.pose * Rotation.from_rotvec(middle[:, None] * vector)
        lift = np.sin(2.0 * np.pi * np.arange(n) / n)[:, None] * np.sin(np.pi * np.arange(n) / n)[:, None] ** 2
        f = poses.inv().apply([0.0, 0.0, G]) + lift * self.rng.uniform(-2.0, 2.0, 3)
        self.pose = self.pose * Rotation.from_rotvec(vector)
        self._read(f, w)

    def _stay(self, seconds: float, silent: bool = False) -> None:
        n = round(seconds * self.imu.rate)
        if silent:
            self.queue.append((np.full((n, 3), np.nan), np.full((n, 3), np.nan)))
        else:
            self._read(np.tile(G * self.up, (n, 1)), np.zeros((n, 3)))

    def _shake(self, seconds: float) -> None:
        n = round(seconds * self.imu.rate)
        t = np.arange(n)[:, None] / self.imu.rate
        tremor = 0.4 * np.sin(2.0 * np.pi * (8.0 * t + self.rng.random(3))) + 0.15 * self.rng.standard_normal((n, 3))
        self._read(G * self.up + tremor, 0.1 * np.sin(2.0 * np.pi * (6.0 * t + self.rng.random(3))) * 0.3)

    def _drop(self) -> None:
        n = round(0.3 * self.imu.rate)
        fall = 0.2 * self.rng.standard_normal((n, 3))
        hit = np.zeros((6, 3))
        hit[:, int(self.rng.integers(3))] = [60.0, 45.0, -30.0, 20.0, -10.0, 5.0]
        self._read(np.vstack([fall, hit + G * self.up]), np.zeros((n + 6, 3)))

    def _read(self, f: np.ndarray, w: np.ndarray) -> None:
        imu, n = self.imu, len(f)
        waiting = sum(len(one[0]) for one in self.queue)
        at = self.t + (waiting + np.arange(n)) / imu.rate
        warm = self.habits.warm_up * np.exp(-at / self.habits.warm_time)[:, None]
        acc = f @ imu.M.T + imu.b + self.shift + warm + imu.acc_noise * self.rng.standard_normal((n, 3))
        gyro = w @ imu.W.T + imu.c + imu.gyro_noise * self.rng.standard_normal((n, 3))
        self.queue.append((acc, gyro))


CLEAN = Habits(repeats=0.0, wrong=0.0, early=0.0, shakes=0.0, drops=0.0, unplugs=0.0)


def only(mistake: str, chance: float) -> Habits:
    """Return a hand that makes one mistake only."""
    one: dict[str, Any] = {mistake: chance}
    return replace(CLEAN, **one)


def guided(
    guide: Any, hand: Hand, longest: float = 1200.0, gyros: bool = True
) -> Iterator[tuple[Any, np.ndarray, np.ndarray, np.ndarray]]:
    """Yield the state after each batch, and the samples that were accepted, until nobody asks for more."""
    code, target = "lay_down", None
    while hand.t < longest:
        stamps, f, w, now = hand.batch(code, target)
        state = guide.add(stamps, f, w if gyros else None) if len(stamps) else guide.silent(round(now * NS))
        kept = state.accepted if len(stamps) else slice(0)
        yield state, stamps[kept], f[kept], w[kept]
        code, target = state.code, state.target
