"""Simulated test rigs: name -> `Rig`, loaded on demand.

A built-in rig is a folder with ``rig.py``, which holds one ``RIG``, and a name in `BUILT_IN`; its ``__init__.py`` holds
the ``TITLE``, for lists. Installed packages add theirs by the entry point ``inertialcal.rigs``.
"""

from __future__ import annotations

from importlib import import_module

from ..core.registry import Registry
from .protocol import Rig

BUILT_IN = (
    "rate_table",
    "sams_tsh",
    "sams_tsh_model",
    "npsat1",
    "still_gyro",
    "mesa",
    "hand_held",
    "six_faces",
    "six_faces_over_temperature",
    "climate",
    "shaker",
    "turned_mass",
    "satellite",
    "station",
    "flights",
    "flights_recorded",
    "heads",
    "alignment",
)
DEMONSTRATED = "npsat1"  # where none is named

RIGS = Registry("rig", Rig, "inertialcal.rigs", {name: f"{__name__}.{name}.rig:RIG" for name in BUILT_IN})


def titles() -> dict[str, str]:
    """Return one line on each rig, by name, without loading any; of an installed one, the package that adds it."""
    own = {name: str(import_module(f"{__name__}.{name}").TITLE) for name in BUILT_IN}
    return own | {name: f"of the package {package}" for name, package in RIGS.packages().items()}
