"""Units: spellings of the field, round trips, factors against pint and printed tables."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, reject, settings
from hypothesis import strategies as st

from inertialcal.core.errors import DataError
from inertialcal.core.units import (
    Quantity,
    convert,
    divide,
    factor,
    is_unit,
    kind,
    known_units,
    multiply,
    normalise,
    parse_quantity,
    power,
    same_dimension,
    si_unit,
)

RELATIVE = 1e-14  # rounding of a few products
LAST_BIT = 2.0**-52

WRITTEN = {
    "m/s^2": "m/s2 m/s^2 m/s**2 m·s⁻² mps2 m/s/s m/s² m.s-2 m*s^-2 (m)/(s^2) m_s2 ㎨ m/sec^2 meters/second^2",
    "deg/s": "deg/s dps °/s deg/sec degree/s degrees/second º/s deg_per_s DPS deg/SEC (deg/s) deg_s deg·s⁻¹",
    "deg/h": "deg/h deg/hr °/h dph deg/hour °/hr",
    "mdeg/s": "mdps mdeg/s m°/s millidegrees/s",
    "rad/s": "rad/s rad*s^-1 radian/s rad_s",
    "deg/sqrt(h)": "deg/sqrt(h) deg/√h deg/rt(hr) °/√hr deg/h^0.5 deg/h^(1/2) deg_per_sqrt_h deg*h^-0.5 deg/√(h)",
    "deg/h/sqrt(Hz)": "deg/h/sqrt(Hz) (deg/h)/sqrt(Hz) deg/h/√Hz deg/(h*sqrt(Hz)) deg/h/Hz^0.5 deg/h/rtHz",
    "deg/h/sqrt(h)": "deg/h/sqrt(h) (deg/h)/√h deg/h^1.5 deg/h^(3/2) deg/sqrt(h)^3",
    "deg/s/sqrt(Hz)": "deg/s/√Hz dps/sqrt(Hz) °/s/√Hz dps/√Hz dps/rtHz",
    "ug/sqrt(Hz)": "ug/sqrt(Hz) \u00b5g/√Hz \u03bcg/√Hz ug/rtHz ug/Hz^.5 microg/sqrt(Hz) micro-g/rootHz ug/SQRT(Hz)",
    "m/s/sqrt(h)": "m/s/√h m/s/sqrt(hr) mps/rth",
    "sqrt(Hz)": "sqrt(Hz) √Hz Hz^0.5 Hz**(1/2) rtHz",
    "g^2/Hz": "g^2/Hz g2/Hz g²/Hz g**2/Hz",
    "(m/s^2)^2/Hz": "(m/s2)^2/Hz m^2/s^4/Hz (m/s²)²/Hz (m/s2)2/Hz (m/s^2)2/Hz",
    "(deg/s)^2/Hz": "(deg/s)^2/Hz dps^2/Hz deg^2/s^2/Hz (°/s)²/Hz (deg/s)2/Hz (°/s)2/Hz",
    "count": "LSB lsb count counts ct cts pulse pulses digit LSBs Counts COUNT",
    "count/s": "pulse/s pps counts/s LSB/s",
    "count/s/ug": "pulses/s/ug pps/ug pps_per_ug",
    "count/g": "LSB/g counts/g count/gn",
    "count/(rad/s)": "count/(rad/s) LSB/(rad/s) count*s/rad",
    "count/(m/s^2)": "count/(m/s2) LSB/mps2 count*s^2/m",
    "V/(deg/s)": "V/(deg/s) V/dps V/(°/s) V*s/deg volts/(deg/sec) volt_per_dps (V)/(deg/s) V/(deg*s^-1)",
    "mV/(deg/s)": "mV/(deg/s) mV/dps mV/(°/s)",
    "mdeg/s/count": "mdps/LSB mdps/digit",
    "rad/s/(m/s^2)": "(rad/s)/(m/s2) rad*s/m rad/s/(m/s²)",
    "deg/s/g": "deg/s/g dps/g °/s/g (deg/s)/g",
    "deg/h/g": "deg/h/g °/h/g",
    "V/(m/s^2)": "V/(m/s^2) V/mps2 V*s^2/m",
    "V/degC": "V/degC V/°C",
    "ppm/degC": "ppm/°C ppm/℃",
    "V": "V volt volts Volt",
    "mV": "mV millivolt millivolts",
    "uV": "uV µV microvolt",
    "g": "g gn g0 g_n standard_gravity gee",
    "ug": "ug µg micro-g microg",
    "ng": "ng nano-g",
    "mGal": "mGal mgal mGAL",
    "uGal": "uGal µGal ugal",
    "degC": "degC °C celsius ℃ degc Celsius DEGC",
    "degF": "degF °F fahrenheit ℉",
    "K": "K kelvin",
    "%": "% percent pct",
    "ppm": "ppm PPM",
    "1": "1 dimensionless unitless - 1/1 V/V",
    "1/s": "1/s s^-1 s⁻¹",
    "Hz": "Hz hz HZ hertz",
    "kHz": "kHz khz kilohertz",
    "s": "s sec second seconds",
    "ms": "ms msec milliseconds",
    "us": "us µs usec",
    "ns": "ns nsec",
    "min": "min minute minutes",
    "h": "h hr hour hours",
    "day": "day days d",
    "Pa": "Pa pascal",
    "hPa": "hPa hectopascal",
    "mbar": "mbar millibar",
    "Torr": "Torr torr TORR",
    "psi": "psi PSI",
    "arcsec": "arcsec arcsecond arcseconds",
    "arcmin": "arcmin",
    "urad": "urad µrad microradian",
    "mrad": "mrad",
    "deg": "deg ° degree degrees",
    "rev/min": "rpm rev/min RPM turns/min",
    "kg": "kg kilogram kilograms",
    "gram": "gram grams",
    "lb": "lb lbm pounds",
    "inch": "inch in inches",
    "cm": "cm centimeter centimetre",
    "ohm": "ohm Ω Ω",
    "uT": "uT µT microtesla",
    "Eotvos": "Eotvos eotvos",
}
WITH_BLANKS = {
    "m s-2": "m/s^2",
    "m s^-2": "m/s^2",
    "deg C": "degC",
    "° C": "degC",
    "degrees Celsius": "degC",
    "deg F": "degF",
    "deg/rt h": "deg/sqrt(h)",
    "deg / √ h": "deg/sqrt(h)",
    "deg per second": "deg/s",
    "degrees per root hour": "deg/sqrt(h)",
    "counts per g": "count/g",
    "V s/deg": "V/(deg/s)",
    "kg m s-2": "kg*m/s^2",
    " deg/s ": "deg/s",
    "": "1",
    "  ": "1",
}
SPELLINGS = [(text, unit) for unit, texts in WRITTEN.items() for text in texts.split()] + list(WITH_BLANKS.items())

NOISE_AND_MODEL_TERMS = [
    "deg",
    "deg/sqrt(h)",
    "deg/h",
    "deg/h/sqrt(h)",
    "deg/h^2",
    "m/s",
    "m/s/sqrt(h)",
    "ug",
    "m/s^2/sqrt(h)",
    "rad/sqrt(s)",
    "rad/s/sqrt(s)",
    "m/s/sqrt(s)",
    "m/s^2/sqrt(s)",
    "V/(deg/s)",
    "V/g",
    "V/(m/s^2)",
    "count/s/(m/s^2)",
    "1/g",
    "1/(m/s^2)^2",
    "1/g^2",
    "ug/g^2",
    "deg/s/g",
    "rad/s/(m/s^2)",
    "deg/h/g^2",
    "m/s^2/(rad/s)",
    "deg/s/degC",
    "ug/degC",
    "ppm/degC",
    "ug/degC^2",
    "deg/s/Torr",
    "%/year",
    "g^2/Hz",
    "(rad/s)^2/Hz",
    "(deg/s)^2/Hz",
    "V^2/Hz",
    "V/sqrt(Hz)",
    "1/s",
    "1/s^2",
    "m^3/s^2/kg",
    "kg/m^3",
    "arcsec/sqrt(Hz)",
    "1/(rad/s)",
    "rad/s^2",
    "gram/cm^3",
]

atoms = st.sampled_from(known_units())
exponents = st.sampled_from(
    [1, 1, 1, -1, -1, 2, -2, 3, Fraction(1, 2), Fraction(-1, 2), Fraction(3, 2), Fraction(-1, 4)]
)


@st.composite
def units(draw: Any) -> str:
    """A unit that is printed: a term of the field, or a product of up to four powers."""
    if draw(st.booleans()):
        return str(draw(st.sampled_from(NOISE_AND_MODEL_TERMS)))
    unit = "1"
    for atom, exponent in draw(st.lists(st.tuples(atoms, exponents), min_size=1, max_size=4)):
        unit = multiply(unit, power(atom, exponent))
    try:
        si_unit(unit)
    except DataError:  # g^7: its time would stand to the power -14
        reject()
    return unit


class TestSpelling:
    @pytest.mark.parametrize(("text", "unit"), SPELLINGS)
    def test_what_people_write(self, text: str, unit: str) -> None:
        assert normalise(text) == unit

    @pytest.mark.parametrize("unit", [*known_units(), *NOISE_AND_MODEL_TERMS, *WRITTEN])
    def test_printed_units_come_back(self, unit: str) -> None:
        assert normalise(unit) == unit
        assert unit.isascii()

    @given(units())
    def test_products_come_back(self, unit: str) -> None:
        assert normalise(unit) == unit
        assert unit.isascii()

    @given(units())
    def test_si_units_come_back(self, unit: str) -> None:
        inside = si_unit(unit)
        assert normalise(inside) == inside
        assert si_unit(inside) == inside

    def test_masses_are_kg_and_g_is_an_acceleration(self) -> None:
        assert [kind(unit) for unit in ("g", "mg", "ug", "ng", "pg")] == ["acceleration"] * 5
        assert [kind(unit) for unit in ("kg", "gram", "lb")] == ["mass"] * 3
        assert kind("mgal") == "acceleration"


class TestRefusals:
    @pytest.mark.parametrize(
        ("text", "words"),
        [
            ("furlong", "'furlong' is not known"),
            ("m/furlong", "unit 'm/furlong': 'furlong' is not known"),
            ("degs/s", "Write deg or deg/s"),
            ("dgree/s", "Nearest known: degree"),
            ("v", "Nearest known: V"),
            ("G", "Write g for the acceleration, gauss for the field"),
            ("mG", "Write g for the acceleration"),
            ("C", "Write degC"),
            ("V/C", "Write degC"),
            ("F", "Write degF"),
            ("rps", "Write rad/s or rev/s"),
            ("rads", "Write rad or rad/s"),
            ("cps", "Write count/s or Hz"),
            ("mV/deg/s", r"Write mV/\(deg/s\)"),
            ("mV/°/s", r"mV/\(deg/s\) or mV/\(deg\*s\)"),
            ("1/deg/s", r"Write 1/\(deg/s\)"),
            ("V/m/s2", r"Write V/\(m/s\^2\)"),
            ("V/m/s^2", r"Write V/\(m/s\^2\)"),
            ("ms-2", "milliseconds or m and s"),
            ("ms⁻²", "milliseconds or m and s"),
            ("m/s-2", "is ambiguous"),
            ("deg/s g", "'g' after a division"),
            ("kg/m·s", "'s' after a division"),
            ("V(deg/s)", "a bracket follows 'V'"),
            ("Mrad", "'Mrad' is not known"),
            ("mhz", "Nearest known: mHz, MHz"),
            ("MPA", "'MPA' is not known"),
            ("m^13", "m to the power 13"),
            ("m^0.3", "m to the power 3/10"),
            ("(m^9)^9", "m to the power 81"),
            ("m^999999999", "'999999999' is not an exponent"),
            ("m^1e999999999", "'1e999999999' is not an exponent"),
            ("m^x", "'x' is not an exponent"),
            ("m^(1/0)", "its exponent divides by zero"),
            ("m^(1/2", r"'\)' is missing"),
            ("s2.5", "'2.5' is not an exponent"),
            ("s0", "'0' is not an exponent"),
            ("5 V", "it contains the number 5"),
            ("V 5", "the number 5 follows 'V'"),
            ("V/(deg/s", r"'\)' is missing"),
            ("deg/s)", r"'\)' does not belong here"),
            ("deg/", "a unit is missing at the end"),
            ("/s", "a unit is missing before '/'"),
            ("m//s", "a unit is missing before '/'"),
            ("()", r"a unit is missing before '\)'"),
            ("-deg", "a unit is missing before '-'"),
            ("m;s", "the character ';' does not belong here"),
            ("m" * 81, "it has 81 characters, more than 80"),
            ("(" * 10 + "m" + ")" * 10, "more than 8 brackets"),
            ("√" * 12 + "m", "more than 8 brackets or roots"),
        ],
    )
    def test_unknown_or_two_readings(self, text: str, words: str) -> None:
        with pytest.raises(DataError, match=words) as caught:
            normalise(text)
        assert caught.value.problems[0].code == "unknown_unit"
        assert caught.value.problems[0].do

    def test_product_too_long_to_print(self) -> None:
        unit = "*".join(known_units()[:30:3])
        with pytest.raises(DataError, match="characters, more than 80"):
            multiply(unit, "mGal*uGal*arcsec*Eotvos*gauss*mTorr*mmHg*inHg*degF*degC")

    @settings(max_examples=300)
    @given(st.text(max_size=90) | st.text("msdegHzVC/*^()√-12. µ°kruplo", max_size=40))
    def test_any_text_gives_a_unit_or_a_data_error(self, text: str) -> None:
        codes: set[str] = set()
        for reader in (normalise, parse_quantity, lambda t: parse_quantity(f"1 {t}"), kind, si_unit):
            try:
                reader(text)
            except DataError as error:
                codes.add(error.problems[0].code)
        assert codes <= {"unknown_unit", "unknown_quantity", "impossible_value"}

    @settings(max_examples=200)
    @given(st.lists(st.sampled_from([*known_units()[:40], *"/*^()-2. ", "sqrt(", "√", "**", "1"]), max_size=12))
    def test_any_jumble_of_tokens_gives_a_unit_or_a_data_error(self, tokens: list[str]) -> None:
        try:
            unit = normalise("".join(tokens))
        except DataError:
            return
        assert normalise(unit) == unit


def factors_by_pint() -> Iterator[tuple[str, str, float, float]]:
    """Factors made once by pint: with our definitions they agree to the last bit or its neighbour."""
    lines = Path(__file__).with_name("factors_by_pint.csv").read_text(encoding="utf-8").splitlines()
    for row in csv.DictReader(lines[1:]):
        yield row["from"], row["to"], float(row["factor"]), LAST_BIT if row["list"] == "ours" else RELATIVE


class TestFactors:
    @pytest.mark.parametrize(
        ("from_unit", "to_unit", "expected"),
        [
            # NIST SP 811 (2008), Appendix B.8
            ("g", "m/s^2", 9.80665),
            ("Gal", "m/s^2", 1e-2),
            ("mGal", "ug", 1.019716212977928),
            ("Torr", "Pa", 101325.0 / 760.0),
            ("inch", "m", 0.0254),
            ("lb", "kg", 0.45359237),
            ("atm", "Pa", 101325.0),
            ("psi", "Pa", 6894.757293168361),
            ("gauss", "T", 1e-4),
            # definitions
            ("deg", "rad", math.pi / 180.0),
            ("arcsec", "rad", math.pi / 648000.0),
            ("deg/h", "rad/s", math.pi / 648000.0),
            ("deg/sqrt(h)", "rad/sqrt(s)", math.pi / 180.0 / 60.0),
            ("deg/s/sqrt(Hz)", "deg/sqrt(h)", 60.0),  # IEEE Std 952, Annex C
            ("deg/h/sqrt(Hz)", "deg/sqrt(h)", 1.0 / 60.0),
            ("ug/sqrt(Hz)", "m/s/sqrt(h)", 9.80665e-6 * 60.0),
            ("V/(deg/s)", "V/(rad/s)", 180.0 / math.pi),
            ("count/g", "count/(m/s^2)", 1.0 / 9.80665),
            ("rev/min", "deg/s", 6.0),
            ("Eotvos", "1/s^2", 1e-9),
            ("%", "1", 0.01),
            ("ppm", "%", 1e-4),
            ("Hz", "1/s", 1.0),
            ("V/K", "V/degC", 1.0),
            ("V/degF", "V/K", 1.8),
            ("V*s/deg", "V/dps", 1.0),
            ("mK", "K", 1e-3),
        ],
    )
    def test_printed_values(self, from_unit: str, to_unit: str, expected: float) -> None:
        assert factor(from_unit, to_unit) == pytest.approx(expected, rel=RELATIVE)

    def test_pint_agrees(self) -> None:
        rows = list(factors_by_pint())
        assert len(rows) > 900
        wrong = [row for row in rows if abs(factor(*row[:2], difference=True) / row[2] - 1.0) > row[3]]
        assert wrong == []

    @pytest.mark.parametrize(
        ("unit", "base"),
        [
            ("V", "kg*m^2/s^3/A"),
            ("ohm", "kg*m^2/s^3/A^2"),
            ("W", "kg*m^2/s^3"),
            ("T", "kg/s^2/A"),
            ("N", "kg*m/s^2"),
            ("Pa", "kg/s^2/m"),
            ("Hz", "1/s"),
        ],
    )
    def test_derived_units_inside_are_coherent(self, unit: str, base: str) -> None:
        assert si_unit(unit) == unit
        assert factor(unit, base) == pytest.approx(1.0, rel=RELATIVE)

    @given(units())
    def test_there_and_back(self, unit: str) -> None:
        inside = si_unit(unit)
        values = np.array([-3.5, 0.0, 1.0, 1e6])
        kelvins = kind(unit) == "temperature"  # the offset of 273.15 degC costs digits of small units
        lost = (
            4.0 * np.spacing(300.0) / abs(convert(1.0, unit, inside) - convert(0.0, unit, inside)) if kelvins else 0.0
        )
        back = convert(convert(values, unit, inside), inside, unit)
        np.testing.assert_allclose(back, values, rtol=1e-12, atol=1e-9 + lost)
        if not kelvins:
            assert factor(unit, inside) * factor(inside, unit) == pytest.approx(1.0, rel=RELATIVE)
            assert convert(2.0, unit, inside) == pytest.approx(2.0 * factor(unit, inside), rel=RELATIVE)

    @given(units(), units())
    def test_factors_multiply(self, a: str, b: str) -> None:
        try:
            both, inside = multiply(a, b), multiply(si_unit(a), si_unit(b))
        except DataError:
            return  # too long, or an exponent beyond 12
        expected = factor(a, si_unit(a), difference=True) * factor(b, si_unit(b), difference=True)
        assert factor(both, inside, difference=True) == pytest.approx(expected, rel=1e-13)

    def test_same_unit_is_exactly_one(self) -> None:
        assert all(factor(unit, unit) == 1.0 for unit in known_units())

    def test_temperatures(self) -> None:
        assert convert([0.0, 25.0], "degC", "K") == pytest.approx([273.15, 298.15])
        assert convert(np.array([32.0, 212.0]), "degF", "degC") == pytest.approx([0.0, 100.0], abs=1e-12)
        assert convert(0.0, "K", "°C") == pytest.approx(-273.15)
        assert factor("degC", "degC") == 1.0
        assert factor("degF", "degC", difference=True) == pytest.approx(5.0 / 9.0)
        assert Quantity(0.1, "K").to("degC", difference=True) == pytest.approx(0.1)
        assert Quantity(0.1, "K").to("degC") == pytest.approx(-273.05)

    def test_factor_between_scales_is_refused(self) -> None:
        for pair in (("degC", "K"), ("K", "degF"), ("degF", "degC")):
            with pytest.raises(DataError, match=r"the zero points differ.*Use convert") as caught:
                factor(*pair)
            assert caught.value.problems[0].code == "unit_mismatch"

    @pytest.mark.parametrize(
        ("from_unit", "to_unit", "words"),
        [
            ("deg/s", "Hz", "one is of kind angular_rate, the other of kind frequency"),
            ("count", "1", "one is of kind count, the other of kind dimensionless"),
            ("rad", "1", "one is of kind angle"),
            ("g", "kg", "the other of kind mass"),
            ("V/(deg/s)", "V", r"one is measured in V/\(rad/s\)"),
            ("degC", "degC^2", "measured in degC\\^2"),
        ],
    )
    def test_dimensions_that_differ(self, from_unit: str, to_unit: str, words: str) -> None:
        assert not same_dimension(from_unit, to_unit)
        for call in (lambda: factor(from_unit, to_unit), lambda: convert(1.0, from_unit, to_unit)):
            with pytest.raises(DataError, match=words) as caught:
                call()
            assert caught.value.problems[0].code == "unit_mismatch"

    def test_temperature_inside_a_product_is_a_difference(self) -> None:
        assert convert(2.0, "%*degF", "K") == pytest.approx(0.02 * 5.0 / 9.0)
        assert convert(2.0, "V/degF", "V/degC") == pytest.approx(3.6)

    def test_factor_beyond_numbers(self) -> None:
        with pytest.raises(DataError, match="too large or too small"):
            factor("ps^12*prad^12*pg^12", "s^12*rad^12*g^12")

    def test_values_keep_shape_and_are_not_touched(self) -> None:
        given_values = np.arange(6, dtype=np.int16).reshape(3, 2)
        result = convert(given_values, "mV", "V")
        assert result.shape == (3, 2)
        assert result.dtype == np.float64
        assert given_values[2, 1] == 5


class TestKinds:
    @pytest.mark.parametrize(
        ("expected", "texts"),
        [
            ("angular_rate", "deg/s dps rad/s deg/h rpm mdps rev/s"),
            ("acceleration", "g ug m/s2 mGal cm/s^2 m/h^2 1/(s^2/m)"),
            ("angle", "deg rad arcsec rev urad deg/s*s"),
            ("voltage", "V mV W/A V*%"),
            ("temperature", "degC K degF mK"),
            ("time", "s ms h day 1/Hz"),
            ("frequency", "Hz 1/s kHz sps"),
            ("count", "LSB counts pulse"),
            ("dimensionless", "1 % ppm ppb V/mV m/inch"),
            ("pressure", "Pa Torr mbar psi kg/(m*s^2)"),
            ("length", "m cm inch mm"),
            ("mass", "kg lb gram"),
            ("other", "V/(deg/s) deg/sqrt(h) count/s ug/sqrt(Hz) rad/s^2 A Eotvos"),
        ],
    )
    def test_kind(self, expected: str, texts: str) -> None:
        assert {text: kind(text) for text in texts.split()} == dict.fromkeys(texts.split(), expected)

    @pytest.mark.parametrize(
        ("unit", "inside"),
        [
            ("dps", "rad/s"),
            ("ug", "m/s^2"),
            ("arcsec", "rad"),
            ("mV", "V"),
            ("K", "degC"),
            ("degF", "degC"),
            ("h", "s"),
            ("%", "1"),
            ("lb", "kg"),
            ("inch", "m"),
            ("Torr", "Pa"),
            ("LSB", "count"),
            ("mV/(deg/s)", "V/(rad/s)"),
            ("LSB/g", "count/(m/s^2)"),
            ("deg/sqrt(h)", "rad/sqrt(s)"),
            ("deg/h/sqrt(h)", "rad/s/sqrt(s)"),
            ("ug/sqrt(Hz)", "m/s^2/sqrt(Hz)"),
            ("pps/ug", "count/s/(m/s^2)"),
            ("deg/h/g", "rad/s/(m/s^2)"),
            ("g^2/Hz", "(m/s^2)^2/Hz"),
            ("ppm/degC", "1/degC"),
            ("%/h", "1/s"),
        ],
    )
    def test_unit_inside(self, unit: str, inside: str) -> None:
        assert si_unit(unit) == inside


class TestAlgebra:
    def test_unit_algebra(self) -> None:
        assert divide("V", "deg/s") == "V/(deg/s)"
        assert divide("V", "m/s2") == "V/(m/s^2)"
        assert divide("count/s", "ug") == "count/s/ug"
        assert divide("deg/s", "deg/s") == "1"
        assert divide("mV", "V") == "mV/V"
        assert multiply("deg/s", "s") == "deg"
        assert multiply("deg/s", "sqrt(s)") == "deg/sqrt(s)"
        assert multiply("V/(deg/s)", "dps") == "V"
        assert power("h", -0.5) == "1/sqrt(h)"
        assert power("deg/s", 2) == "(deg/s)^2"
        assert power("m/s^2", -1) == "1/(m/s^2)"
        assert power("m^3", 1.0 / 3.0) == "m"
        assert power("g^2/Hz", Fraction(1, 2)) == "g/sqrt(Hz)"
        assert power("V", 0) == "1"

    def test_si_unit_beyond_the_exponents(self) -> None:
        with pytest.raises(DataError, match=r"the SI unit of 'g\^7' is not a unit: s to the power -14"):
            si_unit("g^7")

    @pytest.mark.parametrize("exponent", [math.nan, math.inf, 0.123456, 1e300, Fraction(1, 7), 13])
    def test_powers_that_are_no_unit(self, exponent: float) -> None:
        with pytest.raises(DataError, match=r"'V' to the power .* is not a unit"):
            power("V", exponent)

    @given(units(), units())
    def test_quotient_undoes_product(self, a: str, b: str) -> None:
        try:
            both = multiply(a, b)
        except DataError:
            return
        assert divide(both, b) == normalise(a)
        assert multiply(b, a) == both

    @given(units())
    def test_square_and_root(self, unit: str) -> None:
        try:
            square = power(unit, 2)
        except DataError:
            return  # beyond the power 12, or too long
        assert power(square, 0.5) == unit
        assert divide("1", divide("1", unit)) == unit


class TestQuantities:
    @pytest.mark.parametrize(
        ("text", "value", "unit"),
        [
            ("0.05 %", 0.05, "%"),
            ("-36.4 deg", -36.4, "deg"),
            ("+36.4 deg", 36.4, "deg"),
            ("−3 °C", -3.0, "degC"),
            ("9.799 m/s2", 9.799, "m/s^2"),
            ("5 V / 4095", 5.0 / 4095.0, "V"),
            ("10 V / 65536", 10.0 / 65536.0, "V"),
            ("10 V / 2^16", 10.0 / 65536.0, "V"),
            ("5 V / (4096 count)", 5.0 / 4096.0, "V/count"),
            ("2 * 5 V", 10.0, "V"),
            ("0.5 V/(deg/s)", 0.5, "V/(deg/s)"),
            ("0.5 V/dps", 0.5, "V/(deg/s)"),
            ("2 s", 2.0, "s"),
            ("5 ug", 5.0, "ug"),
            ("5ug", 5.0, "ug"),
            ("5%", 5.0, "%"),
            ("1e-5 Torr", 1e-5, "Torr"),
            ("10 cm", 10.0, "cm"),
            (".5 V", 0.5, "V"),
            ("5. V", 5.0, "V"),
            ("3", 3.0, "1"),
            ("1/3", 1.0 / 3.0, "1"),
            ("5 1/s", 5.0, "1/s"),
            ("1/s", 1.0, "1/s"),
            ("5 (deg/s)/V", 5.0, "deg/s/V"),
            ("10^-6 g", 1e-6, "g"),
            ("3 * sqrt(4) V", 6.0, "V"),
        ],
    )
    def test_what_people_write(self, text: str, value: float, unit: str) -> None:
        assert parse_quantity(text) == Quantity(value, unit)

    @pytest.mark.parametrize(
        ("text", "words"),
        [
            ("", "must begin with a number"),
            ("V", "must begin with a number"),
            ("nan V", "must begin with a number"),
            ("inf", "must begin with a number"),
            ("- V", "must begin with a number"),
            ("5 furlong", "quantity '5 furlong': 'furlong' is not known"),
            ("5 G", "Write g for the acceleration"),
            ("1e999 V", "not finite"),
            ("1e300*1e300 V", "not finite"),
            ("10^99*10^99*10^99*10^99", "not finite"),
            ("5e300^9 V", "not finite"),
            ("5 V/0", "divides by zero"),
            ("0^-1 V", "not finite"),
            ("1,5 V", "Use a decimal point"),
            ("1 000 V", "the number 000 follows '1' without a sign between"),
            ("5 V / 4096 count", "'count' after a division"),
            ("1/3 deg", "'deg' after a division"),
            ("5 mV/deg/s", "Write 5mV/\\(deg/s\\)"),
            ("5 V ± 1 V", "the character '±' does not belong here"),
            ("5 V + 1 V", "'\\+' does not belong here"),
            ("--5 V", "must begin with a number"),
            ("5 " + "m" * 80, "it has 82 characters"),
            ("__import__('os')", "does not belong here"),
        ],
    )
    def test_refusals(self, text: str, words: str) -> None:
        with pytest.raises(DataError, match=words) as caught:
            parse_quantity(text)
        assert caught.value.problems[0].code == "unknown_quantity"

    @given(st.floats(allow_nan=False, allow_infinity=False, width=64), units())
    def test_printed_quantities_come_back(self, value: float, unit: str) -> None:
        """All but those that nothing has: they are refused by name."""
        quantity = Quantity(value, unit)
        if len(str(quantity)) <= 80:
            try:
                assert parse_quantity(str(quantity)) == quantity
            except DataError as error:
                assert error.problems[0].code == "impossible_value"  # noqa: PT017
                inside = value if unit == "1" else value * factor(unit, si_unit(unit), difference=True)
                assert not (1e-29 < abs(value) < 1e29 and 1e-29 < abs(inside) < 1e29)

    @pytest.mark.parametrize("text", ["1e206 m", "1e31", "-1e31 s", "1e-31 rad", "1e28 km", "1e-28 um", "1e29 d"])
    def test_quantities_that_nothing_has(self, text: str) -> None:
        with pytest.raises(DataError, match="beyond any physical range") as caught:
            parse_quantity(text)
        assert caught.value.problems[0].code == "impossible_value"

    @pytest.mark.parametrize(
        "text", ["0 m", "0", "-0.0 V", "9223372036854775807 count", "6.674e-11 m^3/kg/s^2", "1 ng"]
    )
    def test_quantities_that_something_has(self, text: str) -> None:
        parse_quantity(text)

    def test_to(self) -> None:
        assert parse_quantity("-36.4 deg").to("rad") == pytest.approx(math.radians(-36.4))
        assert parse_quantity("20 degC").to("K") == pytest.approx(293.15)
        assert isinstance(Quantity(1.0, "V").to("mV"), float)
        with pytest.raises(DataError, match="'V' cannot be expressed in 's'"):
            Quantity(1.0, "V").to("s")

    def test_print(self) -> None:
        assert str(Quantity(5.0, "V")) == "5 V"
        assert str(Quantity(0.25, "1")) == "0.25"
        assert str(Quantity(1e-5, "Torr")) == "1e-05 Torr"


def test_repeated_reading_is_cheap() -> None:
    normalise("deg/s/sqrt(Hz)")
    before = normalise.cache_info().hits
    normalise("deg/s/sqrt(Hz)")
    assert normalise.cache_info().hits == before + 1


@pytest.mark.parametrize(
    "text", ["", "-", "deg/s", "m s-2", "1/s", "x+", "x_rot", "furlong", "5 V", "m/s/s", "deg/", "ms-1", "5", "a" * 90]
)
def test_a_unit_is_what_can_be_normalised(text: str) -> None:
    try:
        normalise(text)
    except DataError:
        assert not is_unit(text)
    else:
        assert is_unit(text)
