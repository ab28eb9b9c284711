"""Tests that turn readings into results: the one dict name -> module.

Each module has ``Plan``, ``Readings``, ``Result`` and a pure ``reduce(plan, readings)``.
"""

from __future__ import annotations

from types import ModuleType

from .flip import reduction as flip
from .mass_attraction import reduction as mass_attraction
from .positions import reduction as positions
from .rate_table import reduction as rate_table
from .static_noise import reduction as static_noise
from .thermal import reduction as thermal

PROCEDURES: dict[str, ModuleType] = {
    "rate_table": rate_table,
    "flip": flip,
    "thermal": thermal,
    "static_noise": static_noise,
    "mass_attraction": mass_attraction,
    "positions": positions,
}
