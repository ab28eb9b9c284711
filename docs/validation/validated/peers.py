"""The same data given to libraries of others, in one process."""

from __future__ import annotations

import warnings
from importlib.metadata import version

import numpy as np
from scipy.signal import welch

from inertialcal.physics.attraction.bodies import G, Prism
from inertialcal.signals.spectrum.psd import psd

from .found import Line, Table


def tables() -> list[Table]:
    """Return what agrees, and how far."""
    return [_agreement()]


def _agreement() -> Table:
    lines = [_prisms(), _welch()]
    text = (
        "Largest relative difference of what both give for the same data: of a field to its largest value, of a "
        "density to each. pyyeti has no counterpart here yet: it is for vibration."
    )
    heads = ("figure", "peer", "figures", "largest relative difference", "allowed")
    return Table("Libraries of others", text, heads, (0, 0, 0, 2, 1), tuple(lines))


def _line(what: str, peer: str, own: np.ndarray, theirs: np.ndarray, allowed: float, to: float | None = None) -> Line:
    size = np.abs(theirs) if to is None else to
    off = float(np.max(np.abs(own - theirs) / size))
    return Line((what, peer, int(own.size), off, allowed), off <= allowed)


def _prisms() -> Line:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of libraries behind it, when they are compiled for the first time
        import harmonica  # noqa: PLC0415
    rng = np.random.default_rng(1)
    low, density = rng.uniform(-1.0, 1.0, (20, 3)), rng.uniform(1e3, 8e3, 20)
    high, points = low + rng.uniform(0.2, 1.0, (20, 3)), rng.uniform(-3.0, 3.0, (2000, 3))
    own = G * np.sum(
        [Prism(tuple(a), tuple(b), float(c)).field(points) for a, b, c in zip(low, high, density, strict=True)], axis=0
    )
    ends, at = np.stack([low, high], axis=2).reshape(-1, 6), tuple(points.T.copy())
    parts = [
        sign * harmonica.prism_gravity(at, ends, density, field=name)
        for name, sign in (("g_e", 1), ("g_n", 1), ("g_z", -1))
    ]
    theirs = 1e-5 * np.stack(parts, axis=1)
    name = f"harmonica {version('harmonica')}"
    return _line("attraction of 20 prisms at 2,000 points", name, own, theirs, 1e-12, float(np.abs(theirs).max()))


def _welch() -> Line:
    x = np.random.default_rng(1).normal(size=200_000)
    found = psd(x, 1.0)
    order = np.rint(found.frequency * found.segment).astype(np.int64)
    theirs = welch(x, 1.0, nperseg=found.segment, noverlap=found.segment // 2)[1][order]
    return _line(
        "spectral density of white noise, Welch's method",
        f"scipy {version('scipy')}",
        found.density[:, 0],
        theirs,
        1e-11,
    )
