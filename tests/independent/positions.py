"""Accelerometers and gyros at rest in many orientations: six faces, a tumble, a hand.

Specific force at rest points up, of length g (IEEE Std 1293, multipoint tumble)::

    a = A (g d + noise) + b           d: up, in body axes
    w = W (rate + earth) + b + flicker + G f

Six faces: face i lies as ``exp([e_i]) d_i`` with one small rotation ``e_i`` for the face, the same at each use: the
cosine takes g e^2 / 2 off its own axis. By hand: rests, and between them turns about a fixed axis of the body by a
smooth angle ``theta(t)``, so that attitude and rate follow in closed form: ``C(t) = exp(-theta a) C_0``
and ``w = theta' a``.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.optimize import least_squares

from .case import START, Array, Case, Table, turned
from .static import flicker, walk

AXES = "xyz"
G = 9.81
EARTH = 7.292115e-5  # [rad/s]
LATITUDE = np.radians(48.0)
FACES = {"x+": (1, 0, 0), "x-": (-1, 0, 0), "y+": (0, 1, 0), "y-": (0, -1, 0), "z+": (0, 0, 1), "z-": (0, 0, -1)}


@dataclass(frozen=True)
class Unit:
    """How large the errors are that a seed draws (standard deviations), and the noise. m/s^2, rad/s, rad."""

    bias: float = 0.1
    scale: float = 0.01
    misalignment: float = 0.005
    gyro_bias: float = 0.005
    gyro_scale: float = 0.01
    gyro_misalignment: float = 0.005
    g_sensitivity: float = 0.0  # [rad/s / (m/s^2)]
    sample: float = 0.01
    gyro_sample: float = 0.002
    gyro_flicker: float = 0.0  # B
    gyro_walk: float = 0.0  # K [rad/s / sqrt(s)]
    gyro_drift: float = 0.0  # [rad/s / s]: temperature, the same again in the next record
    acc_flicker: float = 0.0  # B
    position: float = 0.0005  # what differs between positions beyond the noise inside
    limit: float = np.inf  # of the gyros
    upper_triangular: bool = False  # accelerometer frame as the command defines it where positions are unknown


@dataclass
class Drawn:
    """Matrices and biases."""

    A: Array
    b: Array
    W: Array
    c: Array
    G: Array

    @property
    def truth(self) -> dict[str, float]:
        """As the command prints it."""
        truth = {}
        for name, m, bias in (("accelerometer", self.A, self.b), ("gyro", self.W, self.c)):
            for i, axis in enumerate(AXES):
                truth[f"bias {axis} {name}"] = bias[i]
                truth[f"scale_factor_error {axis} {name}"] = 100.0 * (m[i, i] - 1.0)
                for j, other in enumerate(AXES):
                    if i != j:
                        truth[f"misalignment {axis}{other} {name}"] = m[i, j] / m[i, i]
        return truth


def drawn(rng: np.random.Generator, unit: Unit) -> Drawn:
    """Draw the unit."""
    A = np.eye(3) + np.diag(unit.scale * rng.standard_normal(3))
    A += unit.misalignment * rng.standard_normal((3, 3)) * (1.0 - np.eye(3))
    if unit.upper_triangular:  # x along the first input axis, y in the plane of the first two
        A = np.tril(A)
    W = np.eye(3) + np.diag(unit.gyro_scale * rng.standard_normal(3))
    W += unit.gyro_misalignment * rng.standard_normal((3, 3)) * (1.0 - np.eye(3))
    b, c = unit.bias * rng.standard_normal(3), unit.gyro_bias * rng.standard_normal(3)
    return Drawn(A, b, W, c, unit.g_sensitivity * rng.standard_normal((3, 3)))


def six_faces(
    seed: int,
    unit: Unit | None = None,
    face_error: float = 0.5,
    repeats: int = 2,
    samples: int = 500,
    stated: bool = True,
    again: int = 0,
    certificate: str = "",
) -> Case:
    """Return a table of rests on six faces; ``face_error``: standard deviation of each angle of a face [deg].

    ``again``: the test is made once more, on the same unit and fixture.
    """
    unit = unit or Unit()
    rng = np.random.default_rng([4, seed])
    truth = drawn(rng, unit)
    errors = {face: turned(np.radians(face_error) * rng.standard_normal(3)) for face in FACES}
    rng = np.random.default_rng([4, seed, 1, again]) if again else rng
    words, means, scatters = [], [], []
    for face in list(FACES) * repeats:
        up = errors[face] @ np.array(FACES[face], dtype=float)
        noise = unit.position * rng.standard_normal(3) + unit.sample / np.sqrt(samples) * rng.standard_normal(3)
        words.append(face)
        means.append(truth.A @ (G * up) + truth.b + noise)
        scatters.append(unit.sample * np.sqrt(rng.chisquare(samples - 1, 3) / (samples - 1)))
    y, s = np.array(means), np.array(scatters)
    columns = {"position": np.array(words, dtype=object)}
    columns |= {f"acc_{a}": y[:, i] for i, a in enumerate(AXES)}
    columns |= {f"acc_{a}_std": s[:, i] for i, a in enumerate(AXES)}
    columns["samples"] = np.full(len(words), samples)
    signals = tuple(f"acc_{a}" for a in AXES)
    table = Table(columns, signals, run="position", kind="reduced", form=dict.fromkeys(signals, "%.8f"))
    command = ["positions", "@faces.csv", "--unit", "acc=m/s2", "--gravity", f"{G} m/s2", "-o", "@model.json"]
    if stated:
        entry = f'{{ u = "{face_error} deg", certificate = "{certificate}" }}' if certificate else f"{face_error} deg"
        command += ["--standard", f"fixture.orientation={entry}"]
    keep = {key: value for key, value in truth.truth.items() if key.endswith("accelerometer")}
    return Case("positions", {"faces.csv": table}, command, keep, noise=unit.position, rng_seed=seed)


def by_hand(
    seed: int,
    unit: Unit | None = None,
    positions: int = 24,
    *,
    condition: tuple[float, float] = (0.0, 40.0),
    cone: float = 180.0,
    rest: float = 6.0,
    turn: float = 1.5,
    rate: float = 100.0,
    first_rest: float = 15.0,
    peak: float = np.inf,
) -> Case:
    """Return one recording by hand: rests in random orientations, turns between them, both triads.

    Orientations are drawn within ``cone`` degrees of the first one until the condition number of the fit lies in
    ``condition``.
    ``peak``: largest rate of a turn [rad/s]; a slower turn takes longer.
    """
    unit = unit or Unit(upper_triangular=True)
    rng = np.random.default_rng([4, seed])
    truth = drawn(rng, unit)
    ups, turns = orientations(rng, positions, condition, cone)
    dt = 1.0 / rate
    earth = EARTH * np.array([np.cos(LATITUDE), 0.0, np.sin(LATITUDE)])  # north, west, up
    C = aligned(ups[0], rng)
    force, rates, still = [], [], []
    for k in range(positions):
        n = round((rest if k else first_rest) / dt)
        lying = G * C[:, 2] + unit.position * rng.standard_normal(3)
        force.append(np.tile(lying, (n, 1)))
        rates.append(np.tile(C @ earth, (n, 1)))
        still.append(np.ones(n, dtype=bool))
        if k == positions - 1:
            break
        angle = float(np.linalg.norm(turns[k]))
        axis = turns[k] / angle
        steps = round(max(turn, 2.0 * angle / peak) / dt)
        s = (np.arange(steps) + 0.5) / steps
        theta = angle * (s - np.sin(2.0 * np.pi * s) / (2.0 * np.pi))
        speed = angle / (steps * dt) * (1.0 - np.cos(2.0 * np.pi * s))
        Ct = np.array([turned(-t * axis) @ C for t in theta])
        force.append(G * Ct[:, :, 2])
        rates.append(np.outer(speed, axis) + Ct @ earth)
        still.append(np.zeros(steps, dtype=bool))
        C = turned(-angle * axis) @ C
    f, w, quiet = np.concatenate(force), np.concatenate(rates), np.concatenate(still)
    slow, lazy = wandering(rng, unit, len(f), dt)
    acc = f @ truth.A.T + truth.b + unit.sample * rng.standard_normal(f.shape)
    acc += lazy[: len(f)]
    gyro = w @ truth.W.T + truth.c + slow[: len(w)] + f @ truth.G.T + unit.gyro_sample * rng.standard_normal(w.shape)
    gyro = np.clip(gyro, -unit.limit, unit.limit)
    columns = {"unix_s": START + dt * np.arange(len(f))}
    columns |= {f"acc_{a} [m/s^2]": acc[:, i] for i, a in enumerate(AXES)}
    columns |= {f"gyro_{a} [rad/s]": gyro[:, i] for i, a in enumerate(AXES)}
    signals = tuple(name for name in columns if name != "unix_s")
    table = Table(columns, signals, "unix_s", form={"unix_s": "%.3f"} | dict.fromkeys(signals, "%.6f"))
    words = ["positions", "@hand.csv", "--gravity", f"{G} m/s2", "--latitude", "48 deg", "-o", "@model.json"]
    found = truth.truth
    for name, bias, own in (("gyro", truth.c, slow), ("accelerometer", truth.b, lazy)):
        here, onward = (bias + one.mean(axis=0) for one in (own[: len(f)][quiet], own[len(f) :]))
        found |= {f"bias of these rests {a} {name}": float(here[i]) for i, a in enumerate(AXES)}
        found |= {f"bias_next_record that follows {a} {name}": float(onward[i]) for i, a in enumerate(AXES)}
    if not (unit.gyro_walk or unit.gyro_drift):  # the bias of a record some time later, as long as this one
        later = [flicker(rng, unit.gyro_flicker, 2 * len(w))[len(w) :].mean() for _ in AXES]
        found |= {f"bias_next_record {a} gyro": truth.c[i] + float(later[i]) for i, a in enumerate(AXES)}
    case = Case("positions", {"hand.csv": table}, words, found, noise=unit.gyro_sample, rate=rate, rng_seed=seed)
    case.truth["condition"] = condition_number(ups)
    return case


def turned_block(
    seed: int,
    unit: Unit | None = None,
    axes: tuple[tuple[float, float, float], ...] = ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
    *,
    rest: float = 4.0,
    turn: float = 6.0,
    wobble: float = 0.5,
    rate: float = 50.0,
) -> tuple[Drawn, Array, list[tuple[int, int, str, Array]]]:
    """Return a unit in a block: twelve rests on its faces, then a turn about each of some axes, there and back, twice.

    In each turn the block leans by ``wobble`` [deg] (standard deviation), which the gyros feel and nobody states.

    Returns
    -------
    truth : Drawn
        Of the unit.
    samples : ndarray, shape (n, 6)
        Accelerometers [m/s^2], gyros [rad/s].
    sections : list of (first, stop, name, vector)
        A face with its direction, or a turn with its vector. [rad]
    """
    unit = unit or Unit()
    rng = np.random.default_rng([5, seed])
    truth, dt = drawn(rng, unit), 1.0 / rate
    earth = EARTH * np.array([np.cos(LATITUDE), 0.0, np.sin(LATITUDE)])
    force, rates, sections, at = [], [], [], 0
    for name in list(FACES) * 2:
        C = aligned(np.array(FACES[name], dtype=float), rng)
        lying = G * C[:, 2] + unit.position * rng.standard_normal(3)
        n = round(rest / dt)
        force.append(np.tile(lying, (n, 1)))
        rates.append(np.tile(C @ earth, (n, 1)))
        sections.append((at, at + n, name, np.array(FACES[name], dtype=float)))
        at += n
    for sense in (1.0, -1.0, 1.0, -1.0):
        for axis in axes:
            about = np.array(axis, dtype=float) / np.linalg.norm(axis)
            lean = turned(np.radians(wobble) * rng.standard_normal(3)) @ about
            C, steps = aligned(about, rng), round(turn / dt)
            s = (np.arange(steps) + 0.5) / steps
            theta = sense * 2.0 * np.pi * (s - np.sin(2.0 * np.pi * s) / (2.0 * np.pi))
            speed = sense * 2.0 * np.pi / turn * (1.0 - np.cos(2.0 * np.pi * s))
            Ct = np.array([turned(-t * about) @ C for t in theta])
            force.append(G * Ct[:, :, 2])
            rates.append(np.outer(speed, lean) + Ct @ earth)
            sections.append((at, at + steps, "turn", sense * 2.0 * np.pi * about))
            at += steps
    f, w = np.concatenate(force), np.concatenate(rates)
    acc = f @ truth.A.T + truth.b + unit.sample * rng.standard_normal(f.shape)
    gyro = w @ truth.W.T + truth.c + f @ truth.G.T + unit.gyro_sample * rng.standard_normal(w.shape)
    return truth, np.hstack([acc, np.clip(gyro, -unit.limit, unit.limit)]), sections


def wandering(rng: np.random.Generator, unit: Unit, n: int, dt: float) -> tuple[Array, Array]:
    """Return the slow noise of gyros and accelerometers over a record and the one that follows, shape (2 n, 3) each."""
    slow, lazy = (
        np.column_stack([flicker(rng, size, 2 * n) for _ in AXES]) if size else np.zeros((2 * n, 3))
        for size in (unit.gyro_flicker, unit.acc_flicker)
    )
    if unit.gyro_walk:
        slow += np.column_stack([walk(rng, unit.gyro_walk, 2 * n, dt) for _ in AXES])
    slow += unit.gyro_drift * dt * np.tile(np.arange(n), 2)[:, None]
    return slow, lazy


def orientations(
    rng: np.random.Generator, number: int, condition: tuple[float, float], cone: float
) -> tuple[Array, list[Array]]:
    """Draw directions of up in body axes (number, 3), and the rotation vectors of the body between them."""
    for _ in range(20_000):
        first = rng.standard_normal(3)
        first /= np.linalg.norm(first)
        ups = [first]
        while len(ups) < number:
            d = rng.standard_normal(3)
            d /= np.linalg.norm(d)
            if d @ first >= np.cos(np.radians(cone)) and np.degrees(np.arccos(np.clip(d @ ups[-1], -1, 1))) > min(
                20.0, cone / 3.0
            ):
                ups.append(d)
        found = np.array(ups)
        if condition[0] <= condition_number(found) <= condition[1]:
            break
    else:
        raise ValueError(f"no {number} positions of condition {condition} in a cone of {cone} degrees")
    turns = []
    for before, now in pairwise(found):
        axis = np.cross(now, before)
        axis /= np.linalg.norm(axis)
        tilt = float(np.arccos(np.clip(before @ now, -1.0, 1.0)))
        about = rotation_vector(turned(rng.uniform(-1.5, 1.5) * now) @ turned(tilt * axis).T)
        turns.append(about)
    return found, turns


def rotation_vector(C: Array) -> Array:
    """Return v with exp(-[v]) = C, of an angle below pi."""
    angle = float(np.arccos(np.clip((np.trace(C) - 1.0) / 2.0, -1.0, 1.0)))
    axis = np.array([C[1, 2] - C[2, 1], C[2, 0] - C[0, 2], C[0, 1] - C[1, 0]])
    values: Array = angle / (2.0 * np.sin(angle)) * axis
    return values


def aligned(up: Array, rng: np.random.Generator) -> Array:
    """Return a rotation from local to body axes whose third column is ``up``, of random heading."""
    north = np.cross(up, rng.standard_normal(3))
    north /= np.linalg.norm(north)
    return np.column_stack([north, np.cross(up, north), up])


def condition_number(ups: Array) -> float:
    """Return the condition number of the nine-parameter fit of lengths, bias in units of g."""
    x, y, z = ups.T
    rows = np.column_stack([x * x, y * y, z * z, x * y, x * z, y * z, x, y, z])
    return float(np.linalg.cond(rows)) if len(ups) >= 9 else float("inf")


def tumbled(
    seed: int, unit: Unit | None = None, positions: int = 10, *, condition: tuple[float, float] = (50.0, 1300.0),
    cone: float = 100.0, samples: int = 500,
) -> Case:  # fmt: skip
    """Return a table of rests of accelerometers in orientations that nobody knows."""
    unit = unit or Unit(upper_triangular=True)
    rng = np.random.default_rng([9, seed])
    truth = drawn(rng, unit)
    ups, _ = orientations(rng, positions, condition, cone)
    y = G * ups @ truth.A.T + truth.b + unit.position * rng.standard_normal(ups.shape)
    y += unit.sample / np.sqrt(samples) * rng.standard_normal(ups.shape)
    columns = {f"acc_{a}": y[:, i] for i, a in enumerate(AXES)}
    columns |= {f"acc_{a}_std": np.full(len(y), unit.sample) for a in AXES}
    columns["samples"] = np.full(len(y), samples)
    signals = tuple(f"acc_{a}" for a in AXES)
    table = Table(columns, signals, kind="reduced", form=dict.fromkeys(signals, "%.8f"))
    command = ["positions", "@rests.csv", "--unit", "acc=m/s2", "--gravity", f"{G} m/s2", "-o", "@model.json"]
    keep = {key: value for key, value in truth.truth.items() if key.endswith("accelerometer")}
    keep["condition"] = condition_number(ups)
    return Case("positions", {"rests.csv": table}, command, keep, noise=unit.position, rng_seed=seed)


def with_prior(y: Array, sd: float, matrix: float = 0.02, bias: float = 0.5) -> tuple[Array, Array]:
    """Return matrix (lower triangular) and bias from lengths alone, with a prior on both: a reference."""

    def built(p: Array) -> tuple[Array, Array]:
        A = np.eye(3)
        A[np.tril_indices(3)] += p[:6]
        return A, p[6:]

    def residuals(p: Array) -> Array:
        A, b = built(p)
        lengths = np.linalg.norm(np.linalg.solve(A, (y - b).T), axis=0) - G
        return np.concatenate([lengths / sd, p[:6] / matrix, p[6:] / bias])

    return built(least_squares(residuals, np.zeros(9)).x)


def fitted(case: Case) -> tuple[Array, Array]:
    """Return matrix and bias of a table of faces by least squares in twelve numbers."""
    table = case.tables["faces.csv"]
    d = np.array([FACES[word] for word in table.columns["position"]], dtype=float)
    y = np.column_stack([table.columns[name] for name in table.signals])
    found = np.linalg.lstsq(np.column_stack([G * d, np.ones(len(d))]), y, rcond=None)[0]
    return found[:3].T, found[3]
