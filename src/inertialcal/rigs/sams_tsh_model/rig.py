"""Rig of a head with its ground model: that of ``sams_tsh``, whose engineer has the polynomials of his head.

Two tests of the same recording: with the bias that the model predicts left in, and with it taken off. What the model
is off, and what the truth means, stands in ``sams_tsh_ground``.
"""

from __future__ import annotations

from dataclasses import replace

from ..protocol import Twin, with_fault
from ..sams_tsh.faults import FAULTS
from ..sams_tsh.rig import build
from ..sams_tsh.setup import Bench

TITLE = "a triaxial accelerometer head with its ground model, turned by half a turn, and back, in orbit"
__all__ = ["FAULTS", "TITLE", "twin"]


def twin(seed: int, fault: str = "") -> Twin:
    """Return the campaign of a seed, with one mistake in it if asked.

    Raises
    ------
    UsageError
        If there is no mistake of that name.
    """
    return replace(with_fault(build, Bench(ground="jointly"), FAULTS, seed, fault), rig="sams_tsh_model")
