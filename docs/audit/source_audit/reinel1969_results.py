"""Table 4, the scale factor, and the figures of the introduction, the orbit proposal and Appendix C."""

from __future__ import annotations

import math

import numpy as np

from inertialcal.core.constants import REINEL_GRAVITY

from .figures import Figure, Section, figure
from .lead_body import point_attraction
from .printed import Input, Printed, Recomputed, printed, recompute
from .reinel1969_mass import DOC
from .table_files import Row, table

G = REINEL_GRAVITY.value  # cm/s^2
MOON_GM, MOON_RADIUS = 4.9028e18, 1.7374e8  # cm^3/s^2, cm; IAU mean radius
Told = dict[str, Printed]


def result_sections(told: Told) -> tuple[Section, ...]:
    """Return Table 4, what follows from it, and the statements."""
    return (_table4(), _scale_factor(told), _statements(told), _orbit(told))


def experiments() -> list[Row]:
    """Return the rows of Table 4."""
    return table(DOC, "table4_experiments")


def _table4() -> Section:
    figures: list[Figure] = []
    for row in experiments():
        for place, column, signal, noise in (
            ("GO", "go_1e-2_pps", "g25_1e-2_pps", "gr25_1e-2_pps"),
            ("BO", "bo_1e-2_pps", "b25_1e-2_pps", "cr25_1e-2_pps"),
        ):
            found = recompute(lambda a, b: a - b, printed(row[signal]), printed(row[noise]))
            figures.append(
                figure(
                    f"{place} {row['experiment']}",
                    f"{place}, run {row['experiment']}",
                    row[column],
                    found,
                    "(1e-2 pps)",
                )
            )
    how = "Signal less noise: GO = G - GR from the spectrum, BO = B - CR from the Fourier line."
    return Section("table 4", "Table 4, experiments", how, tuple(figures))


def used() -> list[Printed]:
    """Return the six values behind the scale factor, as printed."""
    rows = [row for row in experiments() if row["used_for_scale_factor"] == "yes"]
    return [printed(row[column]) for row in rows for column in ("go_1e-2_pps", "bo_1e-2_pps")]


def without_subtraction() -> float:
    """Return the scale factor of runs 1 to 3 with nothing subtracted [pps/g]."""
    rows = [row for row in experiments() if row["used_for_scale_factor"] == "yes"]
    signals = [float(row[column]) for row in rows for column in ("g25_1e-2_pps", "b25_1e-2_pps")]
    return float(np.mean(signals)) * 1e-2 / 23e-9


def _scale_factor(told: Told) -> Section:
    values: list[Input] = [*used()]
    mean, amplitude, spread = told["mean_response"], told["amplitude"], told["mean_response_plus_minus"]
    run1 = experiments()[0]
    during = sum(row["work_time"] == "during" for row in experiments())
    std = {row["experiment"]: printed(row["std_1e-2_pps"]) for row in experiments()}
    figures = (
        figure(
            "mean", "mean response of runs 1 to 3", mean, recompute(lambda *v: float(np.mean(v)), *values), "(1e-2 pps)"
        ),
        figure(
            "spread",
            "its plus or minus, twice the standard deviation",
            spread,
            recompute(lambda *v: 2.0 * float(np.std(v, ddof=1)), *values),
            "(1e-2 pps)",
        ),
        figure(
            "scale factor",
            "scale factor",
            told["scale_factor"],
            Recomputed(mean.value * 1e7 / amplitude.value),
            "pps/g",
        ),
        figure(
            "plus or minus",
            "its plus or minus",
            told["scale_factor_plus_minus"],
            Recomputed(
                1e7
                * mean.value
                / amplitude.value
                * math.hypot(spread.value / mean.value, told["amplitude_plus_minus"].value / amplitude.value)
            ),
            "pps/g",
        ),
        figure(
            "listing",
            "plus or minus by the listing, run 1",
            told["scale_factor_plus_minus"],
            recompute(lambda s: s * 1e7 / amplitude.value, std["1"]),
            "pps/g",
            why="the program prints the scatter of the data, not of the amplitude",
        ),
        figure(
            "power",
            "signal of run 1, if noise adds in power",
            told["run1_signal"],
            recompute(
                lambda b, c: math.sqrt(b**2 - c**2), printed(run1["b25_1e-2_pps"]), printed(run1["cr25_1e-2_pps"])
            ),
            "(1e-2 pps)",
            why="noise and signal add in power, not in size",
        ),
        figure(
            "data sheet",
            "response by the data sheet",
            told["response_data_sheet"],
            recompute(lambda a, s: a * s * 0.1, amplitude, told["low_range"]),
            "(1e-2 pps)",
        ),
        figure(
            "noise ratio",
            "noise during over after work",
            told["noise_ratio"],
            recompute(lambda a, b: a / b, std["6"], std["5"]),
            "",
        ),
        figure(
            "work time",
            "runs during work time",
            told["runs_in_work_time"],
            Recomputed(float(during)),
            why="run 6 is said to be in work time on the same page",
        ),
    )
    how = (
        "Mean and scatter of the six values as printed; scale factor = 24 / 23.0 with 2 and 0.2 added in "
        "squares; data sheet: "
        "23.0 ng times 10.21 pps/ug."
    )
    return Section("scale factor", "Text: scale factor", how, figures)


def _statements(told: Told) -> Section:
    arcsec = math.radians(1.0 / 3600.0)
    rows = {row["mass_position"]: printed(row["tilt_rad"]) for row in table(DOC, "appendix_c_tilt")}
    figures = (
        figure(
            "theodolite",
            "0.2 arcsec as an acceleration",
            told["theodolite_limit"],
            recompute(lambda a: a * arcsec * 1e6, told["theodolite"].value),
            "ug",
        ),
        figure("1 ng", "1 ng", told["one_ng"], Recomputed(1e-9 * G), "cm/s^2"),
        figure(
            "tilt",
            "Appendix C, amplitude of the tilt",
            told["tilt_amplitude"],
            recompute(lambda u, d: 0.5 * (u - d), rows["up"], rows["down"]),
            "rad",
        ),
        figure(
            "position",
            "position error of 1 ug after 1 h",
            told["position_error"],
            Recomputed(0.5 * 1e-8 * G * 3600.0**2),
            "m",
            why="a free double integration",
        ),
    )
    how = "Tilt times g; g = 981 cm/s^2; half of up less down; a t^2 / 2."
    return Section("statements", "Text: sizes", how, figures)


def _orbit(told: Told) -> Section:
    eotvos = 1e-9 / G
    radius = MOON_RADIUS + 1e5 * told["lunar_altitude"].value
    figures = (
        figure("eotvos", "one Eotvos", told["eotvos"], Recomputed(eotvos), "g/cm"),
        figure(
            "threshold",
            "0.5 Eotvos at 2 m",
            told["threshold"],
            Recomputed(told["resolution"].value * eotvos * told["sensor_distance"].value * 100.0),
            "g",
        ),
        figure(
            "lunar",
            "lunar gradient at 55 km",
            told["lunar_gradient"],
            Recomputed(2.0 * MOON_GM / radius**3 * 1e9),
            "eotvos",
        ),
        figure(
            "centrifuge",
            "rate for 1e-9 g at 2.5 cm",
            told["centrifuge_rate"],
            recompute(lambda r: math.sqrt(told["centrifuge_acceleration"].value * G / r), told["centrifuge_radius"]),
            "rad/s",
        ),
        figure(
            "mass 1 kg",
            "attraction of 1 kg, surface at 10.2 cm",
            told["small_mass_acceleration"],
            Recomputed(_attraction(1.0)),
            "g",
            why="4 kg are proposed for the same acceleration elsewhere",
        ),
        figure(
            "mass 4 kg",
            "attraction of 4 kg, surface at 10.2 cm",
            told["small_mass_acceleration"],
            Recomputed(_attraction(4.0)),
            "g",
        ),
    )
    how = (
        "1e-9 s^-2 over 981 cm/s^2; 2 GM/r^3 of the moon (GM 4.9028e12 m^3/s^2, radius 1737.4 km, not from the "
        "document); root of a/r; sphere of lead."
    )
    return Section("orbit", "Text: orbit proposal", how, figures)


def _attraction(mass: float) -> float:
    radius = (mass * 1e3 / 11.34 / (4.0 / 3.0 * math.pi)) ** (1.0 / 3.0)
    return point_attraction(mass, radius + 10.2)
