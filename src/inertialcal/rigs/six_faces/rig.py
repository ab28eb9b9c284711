"""Rig of an IMU on its six faces: that of ``hand_held``, whose engineer knows which face is up and what he turns.

On each face twice, then turned once about each axis, and, laid anew, back: two records, of which the second is held
out. Beside each lies the protocol of its faces and turns. Each face is off by its own error, the same whenever the unit
is laid on it or turned about its axis, in both records; each laying by a further one; all alike by that of the
mounting.
"""

from __future__ import annotations

from ..hand_held.rig import FAULTS as BY_HAND
from ..hand_held.rig import Bench, build
from ..protocol import Rig, on_bench
from ..twin import Fault
from . import TITLE

__all__ = ["FAULTS", "RIG"]

SHARED = ("acc_in_g", "gyro_in_deg", "swapped_axes", "inverted_axis", "compressed_time", "identical")

FAULTS: dict[str, Fault] = {
    "knocked": Fault("the table was knocked on one face", "disturbed_position", {"knocked": True}),
    "face_missing": Fault("the unit was never laid with y down", "face_missing", {"left_out": "y-"}),
    "face_misnamed": Fault("the protocol swaps two faces", "position_misnamed", {"misnamed": True}),
    "wrong_sense": Fault("the protocol has the wrong sense of the turns", "turn_sense", {"sense": -1}),
    **{name: BY_HAND[name] for name in SHARED},
}


RIG = Rig("six_faces", TITLE, on_bench(build, Bench(variant="ferraris")), FAULTS, tests=("positions", "faces"))
