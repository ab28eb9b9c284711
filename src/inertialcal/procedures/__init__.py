"""Tests that turn readings into results: the one dict name -> module.

Each module has ``Plan``, ``Readings``, ``Result`` and a pure ``reduce(plan, readings)``.
"""

from __future__ import annotations

from types import ModuleType

from . import flip, mass_attraction, positions, rate_table, static_noise, thermal

PROCEDURES: dict[str, ModuleType] = {
    "rate_table": rate_table,
    "flip": flip,
    "thermal": thermal,
    "static_noise": static_noise,
    "mass_attraction": mass_attraction,
    "positions": positions,
}
