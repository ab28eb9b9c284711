"""Rate sensor suite of a satellite: Badescu, NPS thesis, September 2011."""

from __future__ import annotations

from .figures import Document, Effect
from .npsat2011_fits import DOC, fit_sections, rows_of
from .npsat2011_lists import list_sections
from .npsat2011_matrix import matrix_effect, matrix_sections
from .npsat2011_table12 import resolution_section, std_section, table12_sections
from .npsat2011_text import text_sections, white_noise
from .npsat2011_thermal import cubic_gap, thermal_sections
from .npsat2011_vacuum import vacuum_sections
from .table_files import by, stated, table


def document() -> Document:
    """Return the audited document."""
    told = stated(DOC)
    return Document(
        DOC,
        "Rate sensor suite",
        'V. V. Badescu, "NPSAT1 MEMS 3-Axis Rate Sensor Suite Performance, Characterization, and Flight Unit '
        'Acceptance Testing", Naval Postgraduate School, September 2011',
        (
            *thermal_sections(told),
            *vacuum_sections(told),
            std_section(),
            *fit_sections(),
            *table12_sections(),
            *matrix_sections(),
            resolution_section(told),
            *text_sections(told),
            *list_sections(told),
        ),
        _effects(),
    )


def _effects() -> tuple[Effect, ...]:
    cubic = by(table(DOC, "table07_poly_vacuum_volt"), "axis", "coefficient")
    left = ", ".join(f"{float(cubic[axis, 'B']['value']):+.3f}" for axis in "XYZ")
    allan = by(table(DOC, "table13_allan"), "axis")
    low = min(white_noise(axis)[0] for axis in "XYZ") * 60.0
    high = max(white_noise(axis)[1] for axis in "XYZ") * 60.0
    shown = ", ".join(allan[axis,]["angle_random_walk_deg_per_sqrt_h"] for axis in "XYZ")
    fast = [row for axis in "XYZ" for row in rows_of(axis, "std_dps", rates=("5",))]
    still = sum(row["std_dps"] == "0.001" for row in fast)
    ambient = cubic_gap("table03_poly_ground_volt", "table04_poly_ground_degc_dps")
    vacuum = cubic_gap("table07_poly_vacuum_volt", "table08_poly_vacuum_degc_dps")
    return (
        matrix_effect(),
        Effect(
            "The flight equation takes the bias over temperature, a cubic in volts, from a rate in deg/s.",
            f"Half of the bias stays: {left} deg/s of the constant term alone, where 5 % of 0.1 deg/s is 0.005 deg/s.",
        ),
        Effect(
            f"Angle random walk is printed as {shown} deg/sqrt(h).",
            f"The stated scatter of 1 s means gives {low:.2f} to {high:.2f}. Means over 1 s, saved every 2 "
            "s and taken as means "
            "over 2 s, give the printed ones: averaging time and interval are two things.",
        ),
        Effect(
            "m_zx of the matrix with reference is the intercept of its fit, not the slope.",
            (
                "0.244 % for -0.200 %: the sign of a cross term is wrong. Two entries have no fit behind them "
                "at all (m_yx, m_yz)."
            ),
        ),
        Effect(
            f"{still} of the 12 rows at 5 deg/s scatter by 0.001 deg/s, a quarter of what all others do.",
            (
                "5 deg/s is the end of the converter: these readings are clipped, and they have the largest "
                "weight in the slope."
            ),
        ),
        Effect(
            "Table 12 has the scatter of the bias in volts under a head of deg/s.",
            "The bias is half as certain as it seems.",
        ),
        Effect(
            (
                "Table 4 holds for X and Y only with their reference temperatures exchanged; Table 8 comes "
                "from other data than Table 7."
            ),
            (
                f"From -29 to 66 degC the two forms differ by up to {ambient:.4f} deg/s at ambient pressure and "
                f"{vacuum:.4f} in vacuum. Use the cubics in volts."
            ),
        ),
    )
