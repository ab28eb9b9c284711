"""How the simulated rate-table test is set up: the bench, its standards, the unit that is drawn for it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from ...core.estimate import Array
from ...core.influence import Influence
from ...core.key import AXES
from ...sensors.chain.converter import Chain
from ...sensors.model.sensor_model import SensorModel
from ..parts.gyro_bench import CODES, INVERTED, STANDARDS, STEP, VALID_VOLTS, VOLTS_PER_RAD_S, Gyro

HIGHEST_DEG_S = 4.5  # of the rates by default


@dataclass(frozen=True)
class Bench:
    """The test as it is made."""

    # rates of the dwells of every recording, in order [deg/s]
    rates_deg_s: tuple[float, ...] = (0.0, 0.5, -0.5, 1.5, -1.5, 0.0, 3.0, -3.0, 4.5, -4.5, 0.0)
    # length of a dwell, interval of saves, length of the averaging window [s]
    dwell: float = 60.0
    interval: float = 2.0
    averaging: float = 1.0
    longest_ramp: int = 3  # a ramp takes one to this many intervals
    skipped: float = 0.01  # fraction of skipped saves
    averaged: int = 200  # conversions per average
    # power-ups, and those used for the fit
    runs: int = 12
    fit_runs: int = 6
    turned: tuple[str, ...] = AXES  # axes turned in every run
    # latitude; tilt of the table axis from the vertical, and its azimuth [deg]
    latitude_deg: float = 36.6
    tilt_deg: float = -36.4
    azimuth_deg: float = 0.0
    # uncertainties of tilt and azimuth [deg]
    u_tilt_deg: float = 1.0
    u_azimuth_deg: float = 2.0
    # uncertainties of the other standards
    standards: Mapping[str, Influence] = field(default_factory=lambda: dict(STANDARDS))
    table_gain: float = 1.0  # true over commanded table rate, apart from the error of the standard
    wiring: tuple[str, ...] = AXES  # sensor that the columns x, y, z really hold
    # true mounting: -1 for inverted; the campaign states ``INVERTED``
    inverted: tuple[int, ...] = INVERTED
    reference_saved: bool = True  # whether the logger saves the reference voltages
    curvature: float = (
        0.0  # standard deviation of the second- and of the third-order term at the highest rate, relative
    )
    built_in_test: float = 4.2  # voltage of the built-in test [V]
    as_delivered: float = 0.0  # least error of a scale factor, of a unit that its maker has not calibrated


def chain() -> Chain:
    """Return the signal chain of all three sensors."""
    return Chain(
        AXES, STEP, CODES, "rad/s", scale_factor=VOLTS_PER_RAD_S, reference="channel", validity_minimum=VALID_VOLTS
    )


def draw_gyro(
    inverted: tuple[int, ...], rng: np.random.Generator, curvature: float = 0.0, as_delivered: float = 0.0
) -> Gyro:
    """Return a unit of the family: scale factors within some 0.5 %, cross terms of 1 %, biases of 0.02 deg/s.

    With ``as_delivered`` each scale factor is off by that much more.
    """
    own = rng.normal(0.0, 0.005, (3, 3))
    own += as_delivered * np.sign(own)
    matrix: Array = np.eye(3) + np.where(np.eye(3) > 0.0, own, rng.normal(0.0, 0.01, (3, 3)))
    model = SensorModel(
        kind="gyro",
        axes=AXES,
        scale_factor=np.full(3, VOLTS_PER_RAD_S),
        output_unit="V",
        matrix=matrix,
        bias=rng.normal(0.0, np.radians(0.02), 3),
        scale_factor_asymmetry=rng.normal(0.0, 1e-3, 3),
    )
    if curvature:
        largest = float(np.radians(HIGHEST_DEG_S))
        model = replace(
            model,
            second_order=rng.normal(0.0, curvature, 3) / largest,
            third_order=rng.normal(0.0, curvature, 3) / largest**2,
        )
    return Gyro(
        model,
        mounting=np.diag(np.asarray(inverted, dtype=float)),
        run_bias_std=float(np.radians(0.005)),
        run_scale_std=1e-4,
        dwell_std=float(np.radians(0.001)),
        sample_std=float(np.radians(0.004)),
    )
