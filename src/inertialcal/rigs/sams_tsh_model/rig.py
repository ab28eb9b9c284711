"""Rig of a head with its ground model: that of ``sams_tsh``, whose engineer has the polynomials of his head.

Two tests of the same recording: with the bias that the model predicts left in, and with it taken off. What the model
is off, and what the truth means, stands in ``sams_tsh_ground``.
"""

from __future__ import annotations

from ..protocol import Rig, on_bench
from ..sams_tsh.rig import FAULTS, build
from ..sams_tsh.setup import Bench
from . import TITLE

__all__ = ["FAULTS", "RIG"]


RIG = Rig("sams_tsh_model", TITLE, on_bench(build, Bench(ground="jointly")), FAULTS, tests=("flip",))
