"""Samples that are no readings, and what comes on top of readings: glitches, steps, waves, noise, filters."""

from __future__ import annotations

import numpy as np

from ...core.estimate import Array
from .scene import Place, Scene, Signal

BURST = 3  # samples in a row
SPIKED, BURSTS = 1e-4, 5e-5  # parts of the samples
THERMOSTAT = 600.0  # period [s]
STOP_BAND = 120.0  # of a sharp filter [dB]


def glitch(scene: Scene, size: float) -> None:
    """Put one sample far below the others."""
    place = scene.chosen()
    _offset(scene, scene.signal(place), -size, slice(at := scene.somewhere(place), at + 1))


def spikes(scene: Scene, size: float) -> None:
    """Put single samples far off, up or down, in each axis."""
    place = scene.chosen()
    for signal in place.signals:
        at = np.unique([scene.somewhere(place) for _ in range(_few(scene, place, SPIKED))])
        _offset(scene, signal, size * scene.rng.choice([-1.0, 1.0], len(at)), at)


def bursts(scene: Scene, size: float) -> None:
    """Put some samples in a row far off, some times in each axis."""
    place = scene.chosen()
    for signal in place.signals:
        for _ in range(max(BURST, _few(scene, place, BURSTS))):
            at = scene.somewhere(place, BURST)
            _offset(scene, signal, size * scene.rng.standard_normal(BURST), slice(at, at + BURST))


def level_step(scene: Scene, size: float) -> None:
    """Let the level of one axis step once."""
    place = scene.chosen()
    _offset(scene, scene.signal(place), size, slice(scene.middle(place), None))


def thermostat(scene: Scene, size: float) -> None:
    """Let all axes follow a thermostat; the size is the amplitude of the wave."""
    place = scene.chosen()
    seconds = scene.seconds(place.file)
    for signal in place.signals:
        _offset(scene, signal, size * np.sin(2.0 * np.pi * (seconds / THERMOSTAT + scene.rng.random())))


def noise_change(scene: Scene, size: float) -> None:
    """Let one axis be noisier from the middle on: its noise times the size."""
    place = scene.chosen()
    signal, first = scene.signal(place), scene.middle(place)
    n = len(scene.values(place.file, signal.column)) - first
    _offset(scene, signal, np.sqrt(max(size**2 - 1.0, 0.0)) * scene.rng.standard_normal(n), slice(first, None))


def low_pass(scene: Scene, size: float) -> None:
    """Pass each axis through a filter of first order; its noise at low frequency stays as it was."""
    from scipy.signal import lfilter  # noqa: PLC0415 - starts slowly

    for place, signal, values, interval in _records(scene):
        kept = np.exp(-2.0 * np.pi * size * interval)
        new, _ = lfilter([1.0 - kept], [1.0, -kept], values, zi=[kept * values[0]])
        scene.put(place.file, signal.column, np.asarray(new))


def sharp_filter(scene: Scene, size: float) -> None:
    """Pass each axis through a filter that lets nothing through above its corner, and store 32-bit numbers."""
    from scipy.signal import cheby2, sosfilt, sosfilt_zi  # noqa: PLC0415 - starts slowly

    for place, signal, values, interval in _records(scene):
        corner = min(1.5 * size * interval, 0.45)
        sos = cheby2(12, STOP_BAND, corner, fs=1.0, output="sos")
        new, _ = sosfilt(sos, values, zi=sosfilt_zi(sos) * values[0])
        scene.put(place.file, signal.column, np.asarray(new, dtype=np.float32).astype(np.float64))


def _records(scene: Scene) -> list[tuple[Place, Signal, Array, float]]:
    """Return every axis of every file with its values and its sample interval [s]; all are noted as spoiled."""
    found = []
    for place in scene.fitted():
        scene.note(place)
        interval = float(np.median(np.diff(scene.seconds(place.file))))
        found += [(place, one, scene.values(place.file, one.column), interval) for one in place.signals]
    return found


def _few(scene: Scene, place: Place, part: float) -> int:
    return max(1, round(part * len(scene.recordings[place.file])))


def _offset(scene: Scene, signal: Signal, size: float | Array, rows: slice | Array = slice(None)) -> None:
    """Add to readings, in standard deviations of a sample."""
    scene.shift(signal, scene.sigma(signal) * size, rows)
