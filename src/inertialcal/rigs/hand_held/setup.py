"""The bench of an IMU that is laid by hand, and the unit on it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from ...core.estimate import Array
from ...core.influence import Influence
from ...core.key import AXES

RIG_NAMES = {"tumble": "hand_held", "ferraris": "six_faces"}


@dataclass(frozen=True, eq=False)
class Unit:
    """The unit as it is."""

    # row: sensor; column: body axis, (3, 3) [1]
    acc_matrix: Array
    gyro_matrix: Array
    # (3,) [m/s2], [rad/s]
    acc_bias: Array
    gyro_bias: Array
    g_sensitivity: Array  # (3, 3) [(rad/s)/(m/s2)]
    # by a degree: (3, 3) [1/degC], (3,) [m/s2/degC]
    acc_matrix_slope: Array = field(default_factory=lambda: np.zeros((3, 3)))
    acc_bias_slope: Array = field(default_factory=lambda: np.zeros(3))


@dataclass(frozen=True)
class Bench:
    """The test as it is made."""

    # {"tumble", "ferraris"}: many positions, or six faces and three turns
    variant: Literal["tumble", "ferraris"] = "tumble"
    positions: int = 26  # positions of a tumble
    rounds: int = 2  # times that each face is laid and each turn made, there and back
    records: int = 2  # recordings, where no temperatures are given
    held_out: int = 1  # of several recordings, the last ones
    # one recording at each, with a thermometer on the unit [degC]; empty: one temperature, and no thermometer
    temperatures: tuple[float, ...] = ()
    # first position; minimum of the others; minimum turn [s]; up to half as long again
    first: float = 20.0
    dwell: float = 5.0
    turn: float = 1.6
    sample_rate: float = 100.0  # [Hz]
    # scatter of orientations about the intended one, by hand [rad]
    spread: float = 0.15
    lift: float = 2.0  # acceleration while the unit is moved [m/s2]
    # noise of a sample [m/s2], [rad/s]
    acc_noise: float = 0.02
    gyro_noise: float = 2e-3
    repeatability: float = 2e-4  # scatter of each laying about that of its face, and of each turn about its axis [rad]
    # scatter between positions [m/s2], [rad/s]
    acc_between: float = 1e-3
    gyro_between: float = 1e-4
    # scatter of the errors from unit to unit [1], [rad]
    scale: float = 0.01
    misalignment: float = 0.01
    # and of these [m/s2], [rad/s], [(rad/s)/(m/s2)]
    acc_bias: float = 0.2
    gyro_bias: float = 0.01
    g_sensitivity: float = 1.5e-4
    # of changes over temperature [1/degC], [m/s2/degC]; temperature that the unit is stated at [degC]
    matrix_slope: float = 1e-4
    bias_slope: float = 2e-3
    reference_temperature: float = 20.0
    # site [rad]; as stated [m/s2]
    latitude: float = 0.8
    gravity: float = 9.807
    # uncertainty of local gravity, a known turn, one face at each use, all faces and turns in common, the
    # logger's clock, the thermometer
    gravity_error: Influence = field(default=Influence(3e-4, "m/s^2", certificate="gravity map"))
    angle: Influence = field(default=Influence(2e-3, "rad", certificate="square block"))
    orientation: Influence = field(default=Influence(2e-3, "rad", certificate="square block"))
    mounting: Influence = field(default=Influence(1e-3, "rad", certificate="square block"))
    clock: Influence = field(default=Influence(2e-5, "1", certificate="data sheet of the logger"))
    thermometer: Influence = field(default=Influence(0.2, "degC", certificate="data sheet of the thermometer"))
    wiring: tuple[str, str, str] = AXES  # gyro that each gyro channel holds
    sign: tuple[int, int, int] = (1, 1, 1)  # sign of each of these channels
    flat: bool = False  # whether all positions have the z axis level
    knocked: bool = False  # whether the table is knocked in one position; of six faces, on one of them
    left_out: str = ""  # face that is never laid down, such as ``"y-"``
    misnamed: bool = False  # whether the protocol swaps two faces
    sense: int = 1  # sign of the angles in the protocol
    # true unit of a sensor's channels where the campaign states another one
    said: Mapping[str, str] = field(default_factory=dict)
    pace: float = 1.0  # stamp interval over sample interval
    copies: int = 1  # copies of each record in the campaign

    @property
    def rig(self) -> str:
        """Name of the rig whose bench it is."""
        warm = "_over_temperature" if self.variant == "ferraris" and self.temperatures else ""
        return f"{RIG_NAMES[self.variant]}{warm}"

    @property
    def laid(self) -> int:
        """Recordings made."""
        return len(self.temperatures) or self.records

    @property
    def apart(self) -> int:
        """Recordings held out."""
        return self.held_out if self.laid > 1 and self.copies == 1 else 0
