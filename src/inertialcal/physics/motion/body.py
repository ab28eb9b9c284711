"""The file of a body: position, orientation, clock and bias of each head, and how the body moves.

Positions are in axes of the body; an orientation takes components in the body to those in the head; a clock is what a
head's stamps are ahead of the others'.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
from pydantic import Field, ValidationError

from ...core.errors import PlanError, Problem
from ...core.estimate import Array
from ...core.schema.problems import model_problems
from ...core.schema.quantities import Acceleration, Angle, AngularRate, Duration, Length, Relative, Strict, quantity
from ...core.schema.toml import At, key_lines, nearest_line, parse_toml
from ...physics.orbit import orbital_rate

DAY = 86400.0  # [s]
ORTHOGONAL = 1e-3  # of an orientation, from which it is no rotation
Three = Field(min_length=3, max_length=3)
Matrix = Annotated[list[Annotated[list[float], Three]], Three]
if TYPE_CHECKING:
    AngularAcceleration = float
else:
    AngularAcceleration = quantity("rad/s^2")


class HeadTable(Strict):
    """[heads.NAME]."""

    position: Annotated[list[Length], Three]
    position_u: Length = 0.0
    orientation: Matrix | None = None
    orientation_u: Angle = 0.0
    clock: Duration | None = None
    clock_u: Duration = 0.0
    clock_rate: Relative = 0.0
    scale_factor_u: Relative = 0.0
    calibrated: bool = False
    bias: Annotated[list[Acceleration], Three] | None = None
    bias_u: Annotated[list[Acceleration], Three] | None = None
    bias_correlation: Matrix | None = None
    bias_age: Duration | None = None
    drift_u: Acceleration | None = None  # a day


class MotionTable(Strict):
    """[motion]: what is known of the rotation of the body, and of its orbit."""

    rate: Annotated[list[AngularRate], Three] | None = None
    rate_u: AngularRate | None = None
    acceleration: Annotated[list[AngularAcceleration], Three] | None = None
    acceleration_u: AngularAcceleration | None = None
    altitude: Length | None = None
    vertical: Annotated[list[float], Three] | None = None
    vertical_u: Angle = 0.0


class GyroTable(Strict):
    """[gyro]: how a gyro that was recorded too is mounted."""

    orientation: Matrix | None = None
    bias_u: AngularRate = 0.0
    clock: Duration = 0.0


class BodyTable(Strict):
    """The whole file."""

    heads: dict[str, HeadTable]
    motion: MotionTable = MotionTable()
    gyro: GyroTable = GyroTable()


@dataclass(frozen=True, eq=False)
class Mounted:
    """A head as it is mounted, SI."""

    name: str
    position: Array  # shape (3,), in the body [m]
    orientation: Array  # shape (3, 3): head from body
    position_u: float = 0.0  # of each component [m]
    orientation_u: float = 0.0  # about each axis [rad]
    clock: float | None = None  # its stamps are ahead by it [s]; None where nobody said
    clock_u: float = 0.0  # [s]
    clock_rate: float = 0.0  # (1)
    scale_factor_u: float = 0.0  # (1)
    calibrated: bool = False
    bias: Array | None = None  # shape (3,), in its own axes [m/s^2]; None where none was found absolutely
    bias_covariance: Array = field(default_factory=lambda: np.zeros((3, 3)))
    drift_u: float = 0.0  # of its bias since it was found [m/s^2]
    drift_said: bool = True


@dataclass(frozen=True, eq=False)
class Motion:
    """How the body turns, as far as it is stated, and its orbit."""

    rate: Array | None = None  # shape (3,), in the body [rad/s]
    rate_u: float | None = None
    acceleration: Array | None = None  # [rad/s^2]
    acceleration_u: float | None = None
    orbit: float | None = None  # orbital rate [rad/s]
    vertical: Array | None = None  # unit vector, in the body
    vertical_u: float = 0.0  # [rad]

    @property
    def said(self) -> bool:
        """Whether rates and accelerations are known or bounded, without a gyro."""
        return self.rate_u is not None and (self.acceleration_u is not None)


@dataclass(frozen=True, eq=False)
class Body:
    """What a file says of a body."""

    heads: dict[str, Mounted]
    motion: Motion = field(default_factory=Motion)
    gyro_orientation: Array = field(default_factory=lambda: np.eye(3))
    gyro_bias_u: float = 0.0  # [rad/s]
    gyro_clock: float = 0.0  # [s]
    file: str = ""


def read_body(path: str | Path) -> Body:
    """Return what a file says of a body.

    Raises
    ------
    PlanError
        As `parse_body`.
    """
    return parse_body(Path(path).read_bytes(), str(path))


def parse_body(raw: bytes, file: str) -> Body:
    """Return what a text says of a body.

    Raises
    ------
    PlanError
        If it is not TOML; ``wrong_value`` for a key that is wrong, each with its line.
    """
    text, document = parse_toml(raw, file)
    lines = key_lines(text)

    def at(*keys: str | int) -> str:
        line = nearest_line(lines, keys)
        return file if line is None else f"{file}:{line}"

    try:
        table = BodyTable.model_validate(document)
    except ValidationError as error:
        raise PlanError(list(model_problems(error, BodyTable, document, at))) from None
    problems: list[Problem] = []
    heads = {}
    for name, one in table.heads.items():
        problems += _problems(name, one, at)
        if not problems:
            heads[name] = _mounted(name, one)
    if table.gyro.orientation is not None and _wrong(table.gyro.orientation):
        problems.append(Problem("gyro.orientation is no rotation", at("gyro", "orientation"), code="wrong_value"))
    motion = table.motion
    if (motion.vertical is not None) and motion.altitude is None:
        what = "motion.vertical without motion.altitude"
        problems.append(Problem(what, at("motion"), "the gradient of gravity needs both", "Add altitude",
                                "missing_key"))  # fmt: skip
    if problems:
        raise PlanError(problems)
    vertical = None if motion.vertical is None else np.array(motion.vertical) / math.hypot(*motion.vertical)
    return Body(
        heads,
        Motion(
            None if motion.rate is None else np.array(motion.rate),
            motion.rate_u,
            None if motion.acceleration is None else np.array(motion.acceleration),
            motion.acceleration_u,
            None if motion.altitude is None else float(orbital_rate(motion.altitude).values[0]),
            vertical,
            motion.vertical_u,
        ),
        np.eye(3) if table.gyro.orientation is None else np.array(table.gyro.orientation, dtype=float),
        table.gyro.bias_u,
        table.gyro.clock,
        file,
    )


def _wrong(orientation: list[list[float]]) -> bool:
    turn = np.array(orientation, dtype=float)
    return not np.allclose(turn @ turn.T, np.eye(3), atol=ORTHOGONAL)


def _problems(name: str, one: HeadTable, at: At) -> list[Problem]:
    found = []
    if one.orientation is not None and _wrong(one.orientation):
        what = f"heads.{name}.orientation: its rows are not of length 1 and at right angles"
        found.append(Problem(what, at("heads", name, "orientation"), "it takes the body's axes to the head's",
                             code="wrong_value"))  # fmt: skip
    elif one.orientation is not None and np.linalg.det(np.array(one.orientation, dtype=float)) < 0.0:
        what = f"heads.{name}.orientation: left-handed"
        found.append(Problem(what, at("heads", name, "orientation"), do="Check the signs of its rows",
                             code="wrong_value"))  # fmt: skip
    if (one.bias is None) != (one.bias_u is None):
        what = f"heads.{name}: bias and bias_u go together"
        found.append(Problem(what, at("heads", name), "a bias counts by its uncertainty", code="missing_key"))
    if one.bias_correlation is not None:
        correlation = np.array(one.bias_correlation, dtype=float)
        if not np.allclose(correlation, correlation.T) or np.linalg.eigvalsh(correlation)[0] < -1e-9 or not np.allclose(
            np.diag(correlation), 1.0
        ):  # fmt: skip
            what = f"heads.{name}.bias_correlation is no correlation matrix"
            found.append(Problem(what, at("heads", name, "bias_correlation"), code="wrong_value"))
    return found


def _mounted(name: str, one: HeadTable) -> Mounted:
    u = np.zeros(3) if one.bias_u is None else np.array(one.bias_u)
    correlation = np.eye(3) if one.bias_correlation is None else np.array(one.bias_correlation, dtype=float)
    age = 0.0 if one.bias_age is None else one.bias_age / DAY
    return Mounted(
        name,
        np.array(one.position),
        np.eye(3) if one.orientation is None else np.array(one.orientation, dtype=float),
        one.position_u,
        one.orientation_u,
        one.clock,
        one.clock_u,
        one.clock_rate,
        one.scale_factor_u,
        one.calibrated or one.bias is not None,
        None if one.bias is None else np.array(one.bias),
        correlation * np.outer(u, u),
        (one.drift_u or 0.0) * age,
        one.bias is None or one.bias_age is None or one.drift_u is not None,
    )
