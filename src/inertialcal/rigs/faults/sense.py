"""Units, signs, gains and axes: of a run, or changing within a record."""

from __future__ import annotations

import numpy as np

from ...core.estimate import Array
from ...core.key import AXES
from .scene import Place, Scene, Signal


def unit_change(scene: Scene, size: float) -> None:
    """Let all axes be stored in rad/s, or in g, from the middle on."""
    place = scene.chosen()
    rest = slice(scene.middle(place), None)
    for signal in place.signals:
        to = np.pi / 180.0 if signal.kind == "gyro" else 1.0 / 9.80665
        scene.scale(signal, to, rest)


def sign_change(scene: Scene, size: float) -> None:
    """Turn the sign of all axes from the middle on."""
    place = scene.chosen()
    rest = slice(scene.middle(place), None)
    for signal in place.signals:
        scene.scale(signal, -1.0, rest)


def axes_change(scene: Scene, size: float) -> None:
    """Exchange the columns of x and y from the middle on, with all that belongs to them."""
    place = scene.chosen()
    rest = slice(scene.middle(place), None)
    for x, y in _pairs(scene, place):
        first, second = scene.values(place.file, x), scene.values(place.file, y)
        first[rest], second[rest] = second[rest].copy(), first[rest].copy()
        scene.put(place.file, x, first)
        scene.put(place.file, y, second)


def _pairs(scene: Scene, place: Place) -> list[tuple[str, str]]:
    """Return the columns of x and y of one sensor, role by role; those of the gyros where there are several."""
    kinds = [scene.document["sensors"][scene.document["recordings"][name]["sensor"]]["kind"] for name in place.names]
    name = place.names[kinds.index("gyro") if "gyro" in kinds else 0]
    channels = {role: one["column"] for role, one in scene.document["recordings"][name]["channels"].items()}
    stems = {role.removesuffix("_x") for role in channels if role.endswith("_x")}
    return [(channels["x"], channels["y"]), *((channels[f"{s}_x"], channels[f"{s}_y"]) for s in sorted(stems))]


def sensor_change(scene: Scene, size: float) -> None:
    """Read another unit from the middle on: axes in another order, levels off."""
    place = scene.chosen()
    rest = slice(scene.middle(place), None)
    for kind in dict.fromkeys(one.kind for one in place.signals):
        own = [one for one in place.signals if one.kind == kind]
        above = [_above(scene, one) for one in own]
        for signal, other in zip(own, [*above[1:], above[0]], strict=True):
            level = size * scene.sigma(signal)
            scene.shift(signal, other[rest] + level - _above(scene, signal)[rest], rest)


def _above(scene: Scene, signal: Signal) -> Array:
    values = scene.values(signal.file, signal.column)
    return values - scene.values(signal.file, signal.zero) if signal.zero else values


def run_in_rad_s(scene: Scene, size: float) -> None:
    """Store one power-up in rad/s, stated in deg/s."""
    for place in scene.chosen_run():
        for signal in place.signals:
            scene.change(signal, np.radians)


def run_sign(scene: Scene, size: float) -> None:
    """Turn the sign of all readings of one power-up; of pulses, about their mean."""
    for place in scene.chosen_run():
        for signal in place.signals:
            pulses = place.procedure == "mass_attraction"
            scene.change(signal, (lambda values: 2.0 * values.mean() - values) if pulses else (lambda values: -values))


def run_gain(scene: Scene, size: float) -> None:
    """Let one power-up read too much [%]."""
    for place in scene.chosen_run():
        for signal in place.signals:
            scene.scale(signal, 1.0 + size / 100.0)


def dwell_off(scene: Scene, size: float) -> None:
    """Put one dwell off in the axis that is turned [deg/s]."""
    place = scene.chosen()
    signal = scene.signal(place, own=True)
    (applied,) = scene.columns(place, "applied")
    rates = scene.values(place.file, applied)
    rate = float(scene.rng.choice(np.unique(rates[np.append(np.diff(rates) == 0.0, False)])))
    inside = np.flatnonzero(rates == rate)
    breaks = np.flatnonzero(np.diff(inside) > 1)
    rows = inside[: breaks[0] + 1] if len(breaks) else inside
    scene.shift(signal, signal.per_si * float(np.radians(size)), rows)


def copy_of_applied(scene: Scene, size: float) -> None:
    """Put the rates of the table in place of the readings of the axis that is turned."""
    for place in scene.fitted():
        scene.note(place)
        (applied,) = scene.columns(place, "applied")
        sensor = scene.document["sensors"][place.entry["sensor"]]
        (signal,) = [one for one in place.signals if one.axis == place.entry["axis"]]
        at = AXES.index(signal.axis)
        sign = sensor.get("mounting", np.eye(3))[at][at]
        new = sign * signal.per_si * np.radians(scene.values(place.file, applied))
        zero = scene.values(place.file, signal.zero) if signal.zero else 0.0
        scene.put(place.file, signal.column, new + zero)
