"""Test rigs whose truth is known: the one dict name -> module.

Each module has ``TITLE``, ``FAULTS`` (name -> `Fault`) and ``twin(seed, fault="")``, which gives the recordings
of one campaign, the campaign file that its engineer would have written, and the truth behind both. A new rig
adds itself here and nowhere else.
"""

from __future__ import annotations

from types import ModuleType

from .hand_held import rig as hand_held
from .mesa import rig as mesa
from .npsat1 import rig as npsat1
from .rate_table import rig as rate_table
from .sams_tsh import rig as sams_tsh
from .sams_tsh_model import rig as sams_tsh_model
from .six_faces import rig as six_faces
from .still_gyro import rig as still_gyro

RIGS: dict[str, ModuleType] = {
    "rate_table": rate_table,
    "sams_tsh": sams_tsh,
    "sams_tsh_model": sams_tsh_model,
    "npsat1": npsat1,
    "still_gyro": still_gyro,
    "mesa": mesa,
    "hand_held": hand_held,
    "six_faces": six_faces,
}
