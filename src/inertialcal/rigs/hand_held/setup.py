"""The bench of an IMU that is laid by hand, and the unit on it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from ...core.axes import AXES
from ...core.estimate import Array
from ...core.influence import Influence

RIG_NAMES = {"tumble": "hand_held", "ferraris": "six_faces"}


@dataclass(frozen=True, eq=False)
class Unit:
    """The unit as it is.

    Parameters
    ----------
    acc_matrix, gyro_matrix : ndarray, shape (3, 3)
        Row: sensor; column: axis of the body [1].
    acc_bias, gyro_bias : ndarray, shape (3,)
        [m/s2], [rad/s]
    g_sensitivity : ndarray, shape (3, 3)
        [(rad/s)/(m/s2)]
    """

    acc_matrix: Array
    gyro_matrix: Array
    acc_bias: Array
    gyro_bias: Array
    g_sensitivity: Array


@dataclass(frozen=True)
class Bench:
    """The test as it is made.

    Parameters
    ----------
    variant : {"tumble", "ferraris"}
        Many positions, or six faces and three turns.
    positions : int
        Of a tumble.
    rounds : int
        How often each of six faces is laid, and each turn made, there and back.
    records : int
        Recordings; of several the last is held out.
    first, dwell, turn : float
        The first position, the others at least, and a turn at least [s]; up to half as long again.
    sample_rate : float
        [Hz]
    spread : float
        Scatter of an orientation about the one that was meant: of a hand, or of a face that is not square [rad].
    lift : float
        Acceleration while the unit is moved [m/s2].
    acc_noise, gyro_noise : float
        Of a sample [m/s2], [rad/s].
    acc_between, gyro_between : float
        Between positions [m/s2], [rad/s].
    scale, misalignment : float
        Sizes of the unit's errors, from unit to unit [1], [rad].
    acc_bias, gyro_bias, g_sensitivity : float
        The same [m/s2], [rad/s], [(rad/s)/(m/s2)].
    latitude, gravity : float
        Of the site [rad]; as it is told [m/s2].
    gravity_error, angle, orientation, mounting, clock : Influence
        Uncertainties of local gravity, of a known turn, of a face, of all faces and turns alike, of the logger's clock.
    wiring : tuple of str
        Which gyro each channel of the gyros holds.
    sign : tuple of int
        Sign of each of these channels.
    flat : bool
        Whether all positions have the z axis level.
    knocked : bool
        Whether the table is knocked in one position; of six faces, on one of them.
    left_out : str
        Face on which it is never laid: ``"y-"``.
    misnamed : bool
        Whether two faces are written down for one another.
    sense : int
        Sign of the angles that are written down of turns.
    said : mapping
        Unit that a sensor is truly recorded in, where it is not the one that is said.
    pace : float
        Stamps are this much closer than the samples.
    copies : int
        How often the same record is handed over.
    """

    variant: Literal["tumble", "ferraris"] = "tumble"
    positions: int = 26
    rounds: int = 2
    records: int = 2
    first: float = 20.0
    dwell: float = 5.0
    turn: float = 1.6
    sample_rate: float = 100.0
    spread: float = 0.15
    lift: float = 2.0
    acc_noise: float = 0.02
    gyro_noise: float = 2e-3
    acc_between: float = 1e-3
    gyro_between: float = 1e-4
    scale: float = 0.01
    misalignment: float = 0.01
    acc_bias: float = 0.2
    gyro_bias: float = 0.01
    g_sensitivity: float = 1.5e-4
    latitude: float = 0.8
    gravity: float = 9.807
    gravity_error: Influence = field(default=Influence(3e-4, "m/s^2", certificate="gravity map"))
    angle: Influence = field(default=Influence(2e-3, "rad", certificate="square block"))
    orientation: Influence = field(default=Influence(2e-3, "rad", certificate="square block"))
    mounting: Influence = field(default=Influence(1e-3, "rad", certificate="square block"))
    clock: Influence = field(default=Influence(2e-5, "1", certificate="data sheet of the logger"))
    wiring: tuple[str, str, str] = AXES
    sign: tuple[int, int, int] = (1, 1, 1)
    flat: bool = False
    knocked: bool = False
    left_out: str = ""
    misnamed: bool = False
    sense: int = 1
    said: Mapping[str, str] = field(default_factory=dict)
    pace: float = 1.0
    copies: int = 1
