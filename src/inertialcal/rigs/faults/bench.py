"""What the bench, the standards and the surroundings do: temperature, power-ups, drift, faces, labels."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ...core.constants import STANDARD_GRAVITY
from ...core.estimate import Array
from ...core.key import AXES
from ...core.units import parse_quantity
from ..parts.noise import flicker
from ..twin import TrueValue
from .scene import Act, Place, Scene

WRONG = 10  # temperatures in a row
AT_REST = 0.05  # of a gyro, from its usual reading, while the unit lies still [rad/s]
FLOOR = 1.3863  # 2 ln 2: Allan variance of flicker noise over its h
UG = 1e-6 * STANDARD_GRAVITY.value  # [m/s^2]


def impossible_temperature(scene: Scene, size: float) -> None:
    """Put ten temperatures where no sensor can be [degC]."""
    place = scene.chosen()
    at = scene.somewhere(place, WRONG)
    for column in scene.columns(place, "temperature"):
        values = scene.values(place.file, column)
        values[at : at + WRONG] = size * _counts_per_degree(scene, place, column)
        scene.put(place.file, column, values)


def _counts_per_degree(scene: Scene, place: Place, column: str) -> float:
    unit = next(one["unit"] for one in place.entry["channels"].values() if one["column"] == column)
    if unit != "count":
        return 1.0
    chain = scene.document["sensors"][place.entry["sensor"]]["chain"]
    slope = parse_quantity(chain["thermometer"]["slope"]).to("V/degC")
    return slope / parse_quantity(str(chain["lsb"])).to("V")


def stuck_temperature(scene: Scene, size: float) -> None:
    """Let the thermometers stick for the last part of a recording."""
    place = scene.chosen()
    for role in ("temperature", "temperature_reference"):
        for column in scene.columns(place, role):
            values = scene.values(place.file, column)
            first = round((1.0 - size / 100.0) * len(values))
            values[first:] = values[first]
            scene.put(place.file, column, values)


def zero_uncertainty(scene: Scene, size: float) -> None:
    """State an uncertainty of zero for the first standard."""
    scene.edit(r'(^\[standards\.[^\]]*\]\n\w+ = \{ (?:u|half_width) = ")[^" ]+', lambda found: f"{found[1]}0")


def turn_on(scene: Scene, size: float) -> None:
    """Give each power-up a bias of its own, normally distributed [deg/s]."""
    runs: dict[tuple[str, str], Array] = {}
    for place in scene.places:
        scene.note(place)
        offsets = runs.setdefault((place.procedure, place.run), np.radians(size) * scene.rng.standard_normal(3))
        for signal, offset in zip(place.signals, offsets.tolist(), strict=True):
            scene.shift(signal, offset * signal.per_si)


def gyro_flicker(scene: Scene, size: float) -> None:
    """Add flicker noise to the gyros: its Allan deviation at the floor [deg/h].

    The bias of a test is then its mean while the unit rests.
    """
    h = np.radians(size / 3600.0) ** 2 / FLOOR
    added: dict[str, list[tuple[Array, int]]] = {}
    for place in scene.places:
        scene.note(place)
        gyros = [one for one in place.signals if one.kind == "gyro"]
        slow = flicker(h, len(scene.recordings[place.file]), len(gyros), scene.rng)
        rates = [scene.values(place.file, one.column) / one.per_si for one in gyros]
        still = np.all([np.abs(one - np.median(one)) < AT_REST for one in rates], axis=0)
        added.setdefault(place.test, []).append((slow[still].sum(axis=0), int(still.sum())))
        for signal, own in zip(gyros, slow.T, strict=True):
            scene.shift(signal, own * signal.per_si)
    means = {test: np.sum([one for one, _ in own], axis=0) / sum(n for _, n in own) for test, own in added.items()}
    scene.truth = tuple(one for true in scene.truth for one in _at_rest(true, means))


def _at_rest(true: TrueValue, means: Mapping[str, Array]) -> list[TrueValue]:
    """Return the bias of a gyro in each test, in the last as the next record of another; other truths as they are."""
    if true.sensor != "gyro" or true.quantity not in ("bias", "bias_next_record"):
        return [true]
    k = AXES.index(true.axis)
    if true.quantity == "bias_next_record":
        return [replace(true, value=true.value + float(list(means.values())[-1][k]))]
    wanted = means if not true.test else {true.test: means.get(true.test, np.zeros(3))}
    return [replace(true, value=true.value + float(mean[k]), test=test) for test, mean in wanted.items()]


def face_error(scene: Scene, size: float) -> None:
    """Tilt each face by an angle of its own, the same whenever the unit is laid on it [deg]; what it feels turns."""
    tilts: dict[str, Array] = {}
    matrix, bias = np.eye(3), np.zeros(3)
    for one in scene.truth:
        if one.sensor == "accelerometer":
            i, j = AXES.index(one.axis[0]), AXES.index(one.axis[-1])
            if one.quantity == "bias":
                bias[i] = one.value
            elif one.quantity in ("scale_factor_error", "misalignment"):
                matrix[i, j] = one.value + (i == j)
    own_gain = np.diag(matrix).copy()
    matrix = np.where(np.eye(3) > 0.0, matrix, matrix * own_gain[:, np.newaxis])
    for place in scene.places:
        scene.note(place)
        accelerometers = [one for one in place.signals if one.kind == "accelerometer"]
        per_si = np.array([one.per_si for one in accelerometers])
        stored = np.column_stack([scene.values(place.file, one.column) for one in accelerometers])
        vectors = (stored / per_si - bias) @ np.linalg.inv(matrix).T
        for part in scene.extras[place.entry["sections"]].content:  # type: ignore[attr-defined]
            if part.angle is not None:
                continue
            tilt = tilts.setdefault(part.label, np.radians(size) * scene.rng.standard_normal(3))
            rows = slice(int(part.start), int(part.stop))
            angle = float(np.linalg.norm(tilt))
            axis = tilt / angle
            own = vectors[rows]
            across, along = np.cross(axis, own), np.outer(own @ axis, axis)
            vectors[rows] = along + (own - along) * np.cos(angle) + across * np.sin(angle)
        for signal, values in zip(accelerometers, ((vectors @ matrix.T + bias) * per_si).T, strict=True):
            scene.put(place.file, signal.column, np.ascontiguousarray(values))


def ambient_drift(scene: Scene, size: float) -> None:
    """Let the ambient acceleration change steadily in all axes [ug/h]."""
    for place in scene.fitted():
        scene.note(place)
        hours = (scene.seconds(place.file) - scene.seconds(place.file).mean()) / 3600.0
        turned = _cosine_of_turn(scene, place)
        for signal in place.signals:
            felt = size * UG * hours * (1.0 if signal.axis == "x" else turned)
            scene.shift(signal, felt * signal.per_si)


def _cosine_of_turn(scene: Scene, place: Place) -> Array:
    """Return +1 where the head stands at 0 and -1 where it stands at 180 deg, by the nearest window, shape (n,)."""
    parts = scene.used(place)
    signs = [np.cos(parse_quantity(one["angle"]).to("rad")) for one in place.entry["positions"]]
    middles = np.array([0.5 * (part.start + part.stop) for part in parts])
    rows = np.arange(len(scene.recordings[place.file]))
    nearest = np.abs(rows[:, None] - middles).argmin(axis=1)
    return np.asarray(np.array(signs)[nearest], dtype=np.float64)


def wrong_label(scene: Scene, size: float) -> None:
    """Give one window the angle of the other position."""
    (place,) = scene.fitted()
    scene.note(place)
    at = int(scene.rng.integers(len(place.entry["positions"])))
    numbers = iter(range(len(place.entry["positions"])))

    def renamed(found: re.Match[str]) -> str:
        wrong = next(numbers) == at
        return f'angle = "{180 - int(found[1]) if wrong else found[1]} deg"'

    scene.edit(r'angle = "(0|180) deg"', renamed, 0)


# ---- moved mass: sizes are amplitudes of the signal ---------------------------------------------------------------


def repeating_exponential(scene: Scene, size: float) -> None:
    """Add to every run the same drift that dies away within a tenth of the run."""
    _repeat(scene, size, lambda u: np.exp(-10.0 * u))


def repeating_cubic(scene: Scene, size: float) -> None:
    """Add the same cubic drift to every run."""
    _repeat(scene, size, lambda u: 4.0 * (2.0 * u - 1.0) ** 3 - 3.0 * (2.0 * u - 1.0))


def repeating_wave(scene: Scene, size: float) -> None:
    """Add the same three waves of a thermostat to every run."""
    _repeat(scene, size, lambda u: np.sin(6.0 * np.pi * u))


def jump(scene: Scene, size: float) -> None:
    """Let the level jump at the same dwell of every run."""
    at = scene.rng.uniform(0.2, 0.8)
    _repeat(scene, size, lambda u: np.where(u >= at, 1.0, 0.0))


def _repeat(scene: Scene, size: float, shape: Act) -> None:
    for place in scene.places:
        scene.note(place)
        (signal,) = place.signals
        seconds = scene.seconds(place.file)
        drift = size * _response(scene, place) * shape(seconds / seconds[-1])
        scene.shift(signal, drift)


def _response(scene: Scene, place: Place) -> float:
    """Return the amplitude of the signal of the moved mass [stored units]."""
    schedule = scene.extras[place.entry["mass"]["schedule"]].content
    return 0.5 * float(np.ptp(schedule.applied)) * place.signals[0].per_si  # type: ignore[attr-defined]


def gain_change(scene: Scene, size: float) -> None:
    """Let the gain of one run change in the middle, by a factor."""
    place = scene.chosen()
    _gain(scene, place, size, scene.middle(place))


def repeating_gain_change(scene: Scene, size: float) -> None:
    """Let the gain change at the same dwell of every run, by a factor."""
    at = scene.rng.uniform(0.4, 0.7)
    for place in scene.places:
        scene.note(place)
        _gain(scene, place, size, round(at * len(scene.recordings[place.file])))


def _gain(scene: Scene, place: Place, size: float, first: int) -> None:
    (signal,) = place.signals
    middle = float(np.mean(scene.values(place.file, signal.column)))
    scene.change(signal, lambda values: middle + size * (values - middle), slice(first, None))
