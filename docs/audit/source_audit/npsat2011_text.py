"""Noise coefficients, units, rate of the earth, orbit."""

from __future__ import annotations

import math

import numpy as np

from inertialcal.core.constants import BIAS_INSTABILITY_FACTOR, EARTH_ROTATION_RATE, WGS84_GM, WGS84_SEMI_MAJOR_AXIS
from inertialcal.core.units import convert, divide, multiply
from inertialcal.physics.earth import axis_earth_rate, earth_rate_along, earth_rate_sensitivities, geocentric_latitude

from .figures import Figure, Section, Text, Variant, figure
from .npsat2011_fits import DOC, IDEAL
from .printed import Printed, Recomputed, recompute
from .table_files import Row, table

Told = dict[str, Printed]
LATITUDE = 36.6  # of the laboratory, geodetic [deg]
DOUBT = math.radians(3.0)  # of the table's angle, as printed


def text_sections(told: Told) -> tuple[Section, ...]:
    """Return Tables 13 and A, the earth's rate, the requirements."""
    return (_noise(told), _units(), _earth(told), _orbit(told))


def white_noise(axis: str) -> tuple[float, float]:
    """Return the smallest and largest scatter of one reading that the document states [deg/s]."""
    stds = [
        float(row["std"]) / (IDEAL if row["unit"] == "V" else 1.0)
        for row in table(DOC, "residual_bias")
        if row["axis"] == axis and row["std"]
    ] + [float(row["std_rate_dps"]) for row in table(DOC, "table05_noise") if row["axis"] == axis]
    return min(stds), max(stds)


def _walk(axis: str, factor: float) -> Recomputed:
    low, high = (float(convert(s, "deg/s/sqrt(Hz)", "deg/sqrt(h)")) * factor for s in white_noise(axis))
    return Recomputed(0.5 * (low + high), 0.5 * (high - low))


def _noise(told: Told) -> Section:
    figures: list[Figure | Text] = [
        figure(
            "factor",
            "factor of equation (22)",
            told["bias_instability_factor"],
            Recomputed(BIAS_INSTABILITY_FACTOR.value),
        )
    ]
    for row in table(DOC, "table13_allan"):
        axis = row["axis"]
        doubled = Variant(
            "what means over 1 s give that are saved every 2 s and taken as means over 2 s", _walk(axis, math.sqrt(2.0))
        )
        figures.append(
            figure(
                f"walk {axis}",
                f"angle random walk, {axis}",
                row["angle_random_walk_deg_per_sqrt_h"],
                _walk(axis, 1.0),
                "deg/sqrt(h)",
                variants=(doubled,),
            )
        )
    how = (
        "Angle random walk: scatter of one reading, a mean over 1 s, as the document states it in several "
        "places. Equation (22): sqrt(2 ln 2/pi)."
    )
    return Section("table 13", "Table 13, noise coefficients", how, tuple(figures))


def _units() -> Section:
    ramp, root_hour = divide("deg/h", "h"), "sqrt(h)"
    texts = (
        Text(
            "ramp",
            "rate ramp, Table 13",
            "deg/h/sqrt(h)",
            ramp,
            is_unit=True,
            why="equation (23) has R T/sqrt(2); that unit is rate random walk",
        ),
        Text("walk", "angle random walk, definitions", "deg/s/sqrt(h)", divide("deg", root_hour), is_unit=True),
        Text("rate walk", "rate random walk, definitions", "deg/h", divide("deg/h", root_hour), is_unit=True),
        Text(
            "threshold",
            "threshold of the third sensor, Appendix A",
            "deg/s/sqrt(Hz)",
            multiply("deg/s", "1"),
            is_unit=True,
            why="that unit belongs to output noise, one row below",
        ),
    )
    return Section("units", "Units", "Dimension of the quantity by its defining equation.", texts)


def _earth(told: Told) -> Section:
    latitude = math.radians(told["geocentric_latitude"].value)
    tilt = 0.5 * np.pi
    vertical = float(np.degrees(earth_rate_along(latitude, 0.0, 0.0)))
    horizontal = float(np.degrees(earth_rate_along(latitude, tilt, 0.0)))
    level = axis_earth_rate(latitude, tilt)
    doubt = DOUBT * float(earth_rate_sensitivities(latitude, 0.0, 0.0)[1])
    site = math.degrees(float(geocentric_latitude(math.radians(LATITUDE))))
    figures = (
        figure(
            "rate",
            "rate of the earth",
            told["earth_rate"],
            Recomputed(math.degrees(EARTH_ROTATION_RATE.value)),
            "deg/s",
        ),
        figure("vertical", "equation (13)", told["earth_z"], Recomputed(vertical), "deg/s"),
        figure(
            "vertical doubt",
            "equation (13), plus or minus",
            told["earth_z_plus_minus"],
            Recomputed(math.degrees(abs(doubt))),
            "deg/s",
        ),
        figure(
            "level",
            "equation (14)",
            told["earth_xy"],
            Recomputed(math.degrees(float(level.values[0]))),
            "deg/s",
            why="a level axis of unknown azimuth sees -0.0034 to 0.0034; 0.0068 would be more than the whole rate",
        ),
        figure(
            "level doubt", "equation (14), plus or minus", told["earth_xy_plus_minus"], Recomputed(horizontal), "deg/s"
        ),
        figure("latitude", "geocentric latitude of 36.6 deg", told["geocentric_latitude"], Recomputed(site), "deg"),
        *(
            figure(
                f"angle {row['axis']} {row['acs_id']}",
                f"table angle, {row['axis']}, test {row['acs_id']}",
                row["rotation_deg"].lstrip("-"),
                _nearest(told, row),
                "deg",
                variants=(_geodetic(row),),
            )
            for row in table(DOC, "appendix_b2_rate_tests")
            if row["purpose"] == "earth_rate" and row["rotation_deg"] not in ("", "0")
        ),
    )
    how = (
        "The earth's rate, along the vertical and along the level, at 36.4 deg; plus or minus by 3 deg of "
        "tilt; mean of a "
        "level axis over all azimuths. Angles of Appendix B against 36.4 and 53.6 deg of the text."
    )
    return Section("earth", "Text: rate of the earth", how, figures)


def _nearest(told: Told, row: Row) -> Recomputed:
    shown = abs(float(row["rotation_deg"]))
    return Recomputed(min((told["geocentric_latitude"].value, told["colatitude"].value), key=lambda a: abs(a - shown)))


def _geodetic(row: Row) -> Variant:
    shown = abs(float(row["rotation_deg"]))
    angle = min((LATITUDE, 90.0 - LATITUDE), key=lambda a: abs(a - shown))
    return Variant("the geodetic latitude or its complement, where the text has the geocentric one", Recomputed(angle))


def _orbit(told: Told) -> Section:
    radius = WGS84_SEMI_MAJOR_AXIS.value + 1e3 * told["altitude"].value
    twice = 2.0 * math.degrees(math.sqrt(WGS84_GM.value / radius**3))
    figures = (
        figure(
            "twice orbital", "twice the orbital rate at 560 km", told["twice_orbital_rate"], Recomputed(twice), "deg/s"
        ),
        figure(
            "mode",
            "first mode found by the sweep to 1000 Hz",
            told["first_mode"],
            recompute(lambda f: f / 1e3, told["sweep_end"]),
            "kHz",
            relation="at most",
            why="above the sweep that found it; 0.675 kHz fits",
        ),
        *(
            figure(
                f"pascal {name}",
                f"{told[f'torr_{name}'].text} Torr",
                told[f"pascal_{name}"],
                Recomputed(float(convert(told[f"torr_{name}"].value, "Torr", "Pa"))),
                "Pa",
            )
            for name in ("ambient", "space")
        ),
    )
    how = "Kepler's third law; the mode must lie inside the sweep; Torr to Pa."
    return Section("orbit", "Text: orbit, vibration, vacuum", how, figures)
