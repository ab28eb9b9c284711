"""What the engineer of the simulated campaign does not know of his bench: one unknown each for the whole campaign."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...core.axes import AXES
from ...core.estimate import Array
from ...physics.earth import earth_rate, level_to_table
from ..parts.campaign import drawn_error
from ..parts.gyro_bench import mounted
from ..protocol import Drawn
from .setup import Bench


@dataclass(frozen=True, eq=False)
class World:
    """How the bench really is.

    Parameters
    ----------
    table_gain, converter_gain : float
        True over nominal.
    thermometer : float
        By how much the temperature channels show too much [degC].
    latitude : float
        [rad]
    C_table_level : ndarray, shape (3, 3)
        Rate table from level.
    C_body_table : mapping of str to ndarray, shape (3, 3)
        For each axis that is turned.
    phase : mapping of str to float
        Table angle of the index mark for each axis that is turned [rad].
    C_body_chamber : ndarray, shape (3, 3)
        Body from level, in the chamber and at rest.
    """

    table_gain: float
    converter_gain: float
    thermometer: float
    latitude: float
    C_table_level: Array
    C_body_table: dict[str, Array]
    phase: dict[str, float]
    C_body_chamber: Array

    @property
    def earth_in_chamber(self) -> Array:
        """Rate of the earth along the body axes, in the chamber and at rest, shape (3,) [rad/s]."""
        return np.asarray(self.C_body_chamber @ earth_rate(self.latitude))


def draw_world(bench: Bench, rng: np.random.Generator) -> tuple[World, Drawn]:
    """Return how the bench really is, and the same for the file of the truth."""
    standards = bench.standards
    rate, converter, thermometer = (
        drawn_error(standards.get(name), rng)
        for name in ("rate_table.rate", "converter.reference", "thermometer.temperature")
    )
    latitude = float(np.radians(bench.latitude_deg)) + drawn_error(standards.get("site.latitude"), rng)
    stands = {
        "table": (bench.tilt_deg, bench.u_tilt_deg, bench.azimuth_deg, bench.u_azimuth_deg),
        "chamber": (
            bench.chamber_tilt_deg, bench.u_chamber_tilt_deg, bench.chamber_azimuth_deg, bench.u_chamber_azimuth_deg,
        ),
    }  # fmt: skip
    angles = {
        name: np.radians([rng.normal(tilt, u_tilt), rng.normal(azimuth, u_azimuth)])
        for name, (tilt, u_tilt, azimuth, u_azimuth) in stands.items()
    }
    mounting = standards.get("rate_table.mounting")
    pairs = {axis: (drawn_error(mounting, rng), drawn_error(mounting, rng)) for axis in AXES}
    phase = {axis: float(rng.uniform(0.0, 2.0 * np.pi)) for axis in AXES}
    level = {name: level_to_table(float(tilt), float(azimuth)) for name, (tilt, azimuth) in angles.items()}
    world = World(
        bench.table_gain * (1.0 + rate),
        1.0 + converter,
        thermometer,
        latitude,
        level["table"],
        {axis: mounted(i, pairs[axis]) for i, axis in enumerate(AXES)},
        phase,
        level["chamber"],
    )
    drawn: dict[str, float | list[float] | list[list[float]]] = {
        "table_rate_error": rate,
        "converter_reference_error": converter,
        "thermometer_error": thermometer,
        "latitude": latitude,
        **{f"tilt_and_azimuth_of_{name}": pair.tolist() for name, pair in angles.items()},
        **{f"mounting_{axis}_turned": list(pair) for axis, pair in pairs.items()},
        **{f"phase_{axis}_turned": angle for axis, angle in phase.items()},
    }
    return world, drawn
