"""What flight C has to compute, in exact rationals: a model and its chain as one function of raw codes.

With d a signal code above its reference and t a temperature code above its own, per sensor j::

    r_j = a_j d_j + R_j + s_j(t_j)        reading without bias [output unit]; s_j is 0 at the centre t0_j
    u_j = r_j + q_j(r_j)                  inverse of the sensor's curve g; q is 0 where the sensor is linear
    x_i = sum_j N_ij u_j                  N = M^-1
        = C_i + sum_j W_ij d_j + sum_j N_ij (s_j + q_j)

The doubles of model and chain count as the rationals that they are, pi at 60 digits. Temperatures beyond the range of
the model are taken at its ends; beyond the ends of the range in which a curve is inverted, u_j - r_j stays as it is
at the end.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from math import ceil, floor, lcm

import numpy as np
from numpy.typing import NDArray

from ....core.errors import DataError
from ....sensors.chain.converter import Chain
from ....sensors.model.compensate import check_unique
from ....sensors.model.equation import curve
from ....sensors.model.nonlinearity import inverse
from ....sensors.model.sensor_model import SensorModel

PI = Fraction("3.141592653589793238462643383279502884197169399375105820974944")
OUTPUT_UNIT = {"gyro": "deg/s", "accelerometer": "m/s^2"}
PER_INPUT_UNIT = {"gyro": 180 / PI, "accelerometer": Fraction(1)}  # output units in one input unit
WORST_CODE = 2**30  # so that a difference of two fits int32
MOST_TEMPERATURES = 2**18  # codes that are looked at one by one
WIDER = 2  # times the input range: as far as the codes of a converter without ends are taken

Codes = NDArray[np.int64]
Row = tuple[Fraction, ...]
Window = tuple[int, int]
TERMS = {  # that flight C cannot hold, in words
    "bias_pressure": "change of the bias with pressure",
    "bias_warm_up": "warm-up",
    "bias_temperature_rate": "change of the bias with dT/dt",
    "bias_hysteresis": "hysteresis",
    "g_sensitivity": "g-sensitivity",
}


@dataclass(frozen=True)
class Temperatures:
    """Codes of temperature above their reference, as far as the model holds, and s over them."""

    lowest: int
    highest: int
    centre: int
    powers: Row  # s = powers[0] tau + powers[1] tau^2 + ..., tau = t - centre [output unit]

    @property
    def steps(self) -> Codes:
        """Every tau, in order."""
        return np.arange(self.lowest - self.centre, self.highest - self.centre + 1)


@dataclass(frozen=True)
class Bend:
    """Curve g(u) = u + K1'/2 |u| + K2 u^2 + K3 u^3 of a sensor in output units, and the u that it is inverted for."""

    asymmetry: Fraction
    second: Fraction
    third: Fraction
    lowest: Fraction  # 0 or less
    highest: Fraction  # 0 or more

    def powers(self, negative: bool) -> Row:
        """Coefficients of u, u^2, u^3 on one side of zero."""
        side = -1 if negative else 1
        return 1 + side * self.asymmetry / 2, self.second, self.third

    def reading(self, u: Fraction) -> Fraction:
        """g(u)."""
        first, second, third = self.powers(u < 0)
        return u * (first + u * (second + u * third))


@dataclass(frozen=True, eq=False)
class Ideal:
    """The function of raw codes, exact; of k sensors."""

    kind: str
    axes: tuple[str, ...]
    lowest: int  # codes of the converter, or as far as they are looked at
    highest: int
    has_ends: bool  # whether these are the ends of the converter
    has_reference: bool  # whether a reference is measured with each signal
    origin: tuple[int, ...]  # else the code that stands for it
    slope: Row  # a_j [output unit]
    reading: Row  # R_j
    inverse: tuple[Row, ...]  # N
    temperatures: tuple[Temperatures, ...] | None
    bends: tuple[Bend, ...] | None
    good: int | None  # lowest good code of the built-in test
    reference_window: tuple[Window, ...] | None  # plausible codes of the reference
    temperature_window: tuple[Window, ...] | None  # and of that of the temperature
    input_range: tuple[tuple[Fraction, Fraction], ...] | None

    @property
    def unit(self) -> str:
        """Output unit."""
        return OUTPUT_UNIT[self.kind]

    @property
    def warmths(self) -> tuple[Temperatures, ...]:
        """Temperatures of each sensor; none where the model takes none."""
        return self.temperatures or ()

    @property
    def curves(self) -> tuple[Bend, ...]:
        """Curve of each sensor; none where all are straight."""
        return self.bends or ()

    @property
    def signals(self) -> tuple[Window, ...]:
        """Lowest and highest d of each sensor."""
        if self.has_reference:
            return ((self.lowest - self.highest, self.highest - self.lowest),) * len(self.axes)
        return tuple((self.lowest - one, self.highest - one) for one in self.origin)

    @cached_property
    def constant(self) -> Row:
        """C_i."""
        return tuple(sum((n * r for n, r in zip(row, self.reading, strict=True)), Fraction(0)) for row in self.inverse)

    @cached_property
    def weights(self) -> tuple[Row, ...]:
        """W_ij = N_ij a_j."""
        return tuple(tuple(n * a for n, a in zip(row, self.slope, strict=True)) for row in self.inverse)


def scaled(values: Sequence[Fraction]) -> tuple[list[int], int]:
    """Return whole numbers and the denominator that they share."""
    common = lcm(*(one.denominator for one in values)) if values else 1
    return [one.numerator * (common // one.denominator) for one in values], common


def ideal(model: SensorModel, chain: Chain) -> Ideal:
    """Return what a model makes of the codes of its chain.

    Raises
    ------
    DataError
        ``cannot_hold`` for terms and parts that flight C has no place for, by name; ``wrong_chain`` for a chain of
        another sensor; ``missing_temperature``; ``no_range`` where neither converter nor model says which codes there
        are; as ``sensors.model.compensate.check_unique``.
    """
    _check(model, chain)
    check_unique(replace(model, matrix=model.matrix[:1], sensitivities=(), estimate=None), {})
    k, unit = len(model.axes), PER_INPUT_UNIT[model.kind]
    gain, volts = _each(chain.gain, k), [unit / one for one in _scale_factor(model, chain)]
    per_volt = [one / amplified for one, amplified in zip(volts, gain, strict=True)]
    fixed = Fraction(0) if chain.reference == "channel" else Fraction(chain.reference)
    step = Fraction(chain.step)
    slope = tuple(step * one for one in per_volt)
    matrix = [[Fraction(float(x)) for x in row] for row in model.matrix[0]]
    opposite = inverted(matrix)
    offsets, temperatures = _offsets(model, chain, per_volt, fixed, unit)
    limits = None
    if model.input_range is not None:
        limits = tuple((Fraction(float(lo)) * unit, Fraction(float(hi)) * unit) for lo, hi in model.input_range)
    spans = _temperature_spans(offsets, temperatures)
    ends = chain.codes
    if ends is None:
        ends = _ends_by_range(model, chain, limits, matrix, slope, spans)
    if max(abs(ends[0]), abs(ends[1])) > WORST_CODE:
        raise _cannot(f"codes from {ends[0]} to {ends[1]}", "their differences do not fit 32 bits")
    origin = (0,) * k if chain.reference == "channel" else (round(fixed / step),) * k
    reading = tuple(r + a * at for r, a, at in zip((one[0] for one in offsets), slope, origin, strict=True))
    has_reference = chain.reference == "channel"
    windows = None
    if has_reference:
        windows = tuple(_window(ends, _signal_span(limits, matrix, j, slope, spans, Fraction(1, 2))) for j in range(k))
    warm = None
    if has_reference and temperatures is not None:
        warm = tuple(_window(ends, (one.lowest, one.highest)) for one in temperatures)
    good = None if chain.validity_minimum is None else ceil(Fraction(chain.validity_minimum) / step)
    if good is not None and chain.validity_minimum is not None and chain.step * (good - 1) >= chain.validity_minimum:
        good -= 1  # a limit that is a code: as the volts of that code, rounded, have it
    made = Ideal(
        kind=model.kind, axes=model.axes, lowest=ends[0], highest=ends[1], has_ends=chain.codes is not None,
        has_reference=has_reference, origin=origin, slope=slope, reading=reading, inverse=opposite,
        temperatures=temperatures, bends=None, good=good, reference_window=windows, temperature_window=warm,
        input_range=limits,
    )  # fmt: skip
    return made if model.linear else _bent(made, model, matrix)


# ---- what has no place ---------------------------------------------------------------------------------------------


def _cannot(what: str, why: str, do: str = "Export to c or python, which take them as arguments") -> DataError:
    return DataError(f"flight-c cannot hold: {what}", why=why, do=do, code="cannot_hold")


def _check(model: SensorModel, chain: Chain) -> None:
    terms = model.terms
    held = [words for name, words in TERMS.items() if name in terms and np.any(terms[name])]
    held += [f"change with {one.channel}" for one in model.sensitivities if any(map(np.any, one.parts.values()))]
    if np.any(model.matrix[1:]):
        held.append("matrix over temperature")
    if held:
        raise _cannot(", ".join(held), "it starts from codes of signal, reference, temperature and built-in test alone")
    if chain.input_unit != "count":
        raise _cannot(f"a chain from {chain.input_unit}", "it starts from codes", "Export to c, and convert first")
    if chain.reference != "channel" and chain.thermometer is not None and chain.thermometer.own_reference:
        why = "a measured reference of the temperature stands beside that of the signal, and this one is fixed"
        raise _cannot("the reference of the temperature channel", why, "Export to c, and convert the temperature first")
    if chain.zero_at:
        raise _cannot("gains over time", "one gain stands in the code", "Give a chain with the gain of the flight")
    if chain.axes != model.axes:
        raise DataError(
            f"the chain is of axes {', '.join(chain.axes)}, the model of {', '.join(model.axes)}",
            do="Give the chain of this sensor",
            code="wrong_chain",
        )


def _scale_factor(model: SensorModel, chain: Chain) -> Row:
    """S0 that the output v of the chain is divided by [output unit of the chain / input unit]."""
    k = len(model.axes)
    own = tuple(_each(model.scale_factor, k))
    if model.output_unit == chain.output_unit:
        both = (model.scale_factor if chain.scale_factor is None else chain.scale_factor, model.scale_factor)
        if not np.allclose(*both, rtol=1e-9, atol=0):
            raise DataError(
                f"scale factor of the chain {chain.scale_factor}, of the model {model.scale_factor.tolist()}",
                why="they are the same number",
                do="Give the chain with which the model was found",
                code="wrong_chain",
            )
        return own
    if model.output_unit == model.unit and chain.scale_factor is not None:
        return tuple(a * b for a, b in zip(own, _each(chain.scale_factor, k), strict=True))
    raise DataError(
        f"the chain ends in {chain.output_unit}, the model starts from {model.output_unit}",
        why="nothing takes one to the other",
        do=f"Give a chain with a scale factor [{chain.output_unit}/({model.unit})]",
        code="wrong_chain",
    )


def _each(values: object, k: int) -> list[Fraction]:
    return [Fraction(float(one)) for one in np.broadcast_to(np.asarray(values, dtype=float), (k,))]


def inverted(matrix: list[list[Fraction]]) -> tuple[Row, ...]:
    """Return the inverse of a square matrix, by elimination; exact, so any pivot other than zero will do."""
    k = len(matrix)
    rows = [[*row, *(Fraction(int(i == j)) for j in range(k))] for i, row in enumerate(matrix)]
    for i in range(k):
        best = max(range(i, k), key=lambda at: abs(rows[at][i]))
        rows[i], rows[best] = rows[best], rows[i]
        rows[i] = [x / rows[i][i] for x in rows[i]]
        for other in range(k):
            if other != i:
                rows[other] = [x - rows[other][i] * y for x, y in zip(rows[other], rows[i], strict=True)]
    return tuple(tuple(row[k:]) for row in rows)


# ---- temperature ---------------------------------------------------------------------------------------------------


def _offsets(
    model: SensorModel, chain: Chain, per_volt: Sequence[Fraction], fixed: Fraction, unit: Fraction
) -> tuple[list[Row], tuple[Temperatures, ...] | None]:
    """Powers of tau of each reading at d = 0, the constant first; and the codes of temperature."""
    k, order = len(model.axes), 0 if model.bias_temperature is None else len(model.bias_temperature)
    zero = np.asarray(chain.zero, dtype=float)
    zero = zero if zero.ndim == 2 else np.broadcast_to(zero, (1, k))
    needs = [what for what, powers in (("bias over temperature", order), ("zero of the electronics", len(zero) - 1))
             if powers]  # fmt: skip
    meter = chain.thermometer
    if meter is None and needs:
        raise DataError(
            f"no temperature in the chain, and the model needs it: {' and '.join(needs)}",
            do="Give the chain its thermometer",
            code="missing_temperature",
        )
    if meter is None or not (needs or model.temperature_range):
        rows = [-(fixed + Fraction(float(zero[0, j]))) * per_volt[j] - unit * Fraction(float(model.bias[j]))
                for j in range(k)]  # fmt: skip
        return [(one,) for one in rows], None
    slope, volts, degrees = (_each(one, k) for one in (meter.slope, meter.voltage, meter.temperature))
    step, offsets, found = Fraction(chain.step), [], []
    for j in range(k):
        per_code = step / slope[j]
        at_zero = degrees[j] - (volts[j] + fixed) / slope[j]  # [degC] where t = 0
        lowest, highest = _temperature_codes(model, chain, per_code, at_zero)
        centre = (lowest + highest) // 2
        here = at_zero + centre * per_code
        bias = [Fraction(float(model.bias[j]))]
        bias += [] if model.bias_temperature is None else [Fraction(float(x)) for x in model.bias_temperature[:, j]]
        reference = Fraction(0)
        if model.reference_temperature is not None:
            reference = Fraction(float(model.reference_temperature[j]))
        k0 = _shifted(bias, here - reference, per_code)
        of_zero = _shifted([Fraction(float(x)) for x in zero[:, j]], here, per_code)
        of_zero[0] += fixed
        powers = _sum([-unit * x for x in k0], [-per_volt[j] * x for x in of_zero])
        offsets.append(tuple(powers))
        found.append(Temperatures(lowest, highest, centre, tuple(powers[1:])))
    return offsets, tuple(found)


def _temperature_codes(model: SensorModel, chain: Chain, per_code: Fraction, at_zero: Fraction) -> Window:
    """Codes above the reference whose temperature lies in the range of the model, and that the converter can give."""
    lowest, highest = -2 * WORST_CODE, 2 * WORST_CODE
    if chain.codes is not None:
        lo, hi = chain.codes
        lowest, highest = (lo - hi, hi - lo) if chain.reference == "channel" else (lo, hi)
    if model.temperature_range is not None:
        ends = sorted((Fraction(one) - at_zero) / per_code for one in model.temperature_range)
        lowest, highest = max(lowest, ceil(ends[0])), min(highest, floor(ends[1]))
    if lowest > highest:
        raise DataError(
            "no code of the temperature channel lies in the temperature range of the model",
            why="every reading would be out of range",
            do="Look at the thermometer of the chain, and at the temperature range",
            code="no_range",
        )
    if highest - lowest >= MOST_TEMPERATURES:
        if chain.codes is None and model.temperature_range is None:
            raise _no_range("temperature")
        raise _cannot(
            f"{highest - lowest + 1} codes of temperature",
            f"each is looked at, and {MOST_TEMPERATURES} is the limit",
            "Give temperature_range, or leave out bits that are noise",
        )
    return lowest, highest


def _no_range(what: str) -> DataError:
    return DataError(
        f"no range of {what}: the converter has no ends, and the model no {what}_range",
        why="a bound over all codes needs to know which there are",
        do=f"State the codes of the converter, or the {what}_range of the model",
        code="no_range",
    )


def _shifted(powers: Sequence[Fraction], at: Fraction, per: Fraction) -> list[Fraction]:
    """Powers of tau of a polynomial in y, where y = at + per tau."""
    total = [Fraction(0)]
    for power in reversed(powers):
        longer = [Fraction(0)] * (len(total) + 1)
        for i, x in enumerate(total):
            longer[i] += x * at
            longer[i + 1] += x * per
        longer[0] += power
        total = longer
    return total[: max(len(powers), 1)]


def _sum(one: list[Fraction], other: list[Fraction]) -> list[Fraction]:
    size = max(len(one), len(other))
    both = ([*each, *[Fraction(0)] * (size - len(each))] for each in (one, other))
    return [a + b for a, b in zip(*both, strict=True)]


# ---- ranges --------------------------------------------------------------------------------------------------------


def _temperature_spans(
    offsets: Sequence[Row], temperatures: tuple[Temperatures, ...] | None
) -> list[tuple[Fraction, Fraction]]:
    """Lowest and highest reading at d = 0 of each sensor, over temperature; for ranges, not for the bound."""
    spans = []
    for j, row in enumerate(offsets):
        values = np.array([float(row[0])])
        if temperatures is not None:
            values = np.polynomial.polynomial.polyval(temperatures[j].steps.astype(float), [float(x) for x in row])
        spans.append((Fraction(float(values.min())), Fraction(float(values.max()))))
    return spans


def _felt(limits: Sequence[tuple[Fraction, Fraction]], row: Sequence[Fraction]) -> tuple[Fraction, Fraction]:
    """Lowest and highest u of a sensor over a box of inputs, widened to hold zero."""
    ends = [sorted((m * lo, m * hi)) for m, (lo, hi) in zip(row, limits, strict=True)]
    return min(Fraction(0), sum((a for a, _ in ends), Fraction(0))), max(
        Fraction(0), sum((b for _, b in ends), Fraction(0))
    )


def _signal_span(
    limits: tuple[tuple[Fraction, Fraction], ...] | None, matrix: list[list[Fraction]], j: int,
    slope: Row, spans: Sequence[tuple[Fraction, Fraction]], share: Fraction,
) -> Window | None:  # fmt: skip
    """Lowest and highest d that a share of the input range gives, at any temperature; None without a range."""
    if limits is None:
        return None
    lowest, highest = (share * one for one in _felt(limits, matrix[j]))
    ends = sorted(((lowest - spans[j][1]) / slope[j], (highest - spans[j][0]) / slope[j]))
    if slope[j] < 0:
        ends = sorted(((lowest - spans[j][0]) / slope[j], (highest - spans[j][1]) / slope[j]))
    return floor(ends[0]), ceil(ends[1])


def _window(ends: Window, span: Window | None) -> Window:
    """Codes of a reference that leave a span of codes above it inside the converter; else the middle half of it."""
    lowest, highest = ends
    if span is not None and lowest - span[0] < highest - span[1]:
        return max(lowest + 1, lowest - span[0]), min(highest - 1, highest - span[1])
    quarter = (highest - lowest) // 4
    return lowest + quarter, highest - quarter


def _ends_by_range(
    model: SensorModel, chain: Chain, limits: tuple[tuple[Fraction, Fraction], ...] | None,
    matrix: list[list[Fraction]], slope: Row, spans: Sequence[tuple[Fraction, Fraction]],
) -> Window:  # fmt: skip
    """Codes of a converter without ends: those of the input range, some times over."""
    found = [_signal_span(limits, matrix, j, slope, spans, Fraction(WIDER)) for j in range(len(model.axes))]
    known = [one for one in found if one is not None]
    if not known:
        raise _no_range("input")
    if chain.reference == "channel":
        raise _cannot("a measured reference of a converter without ends", "its codes have no range")
    origin = round(Fraction(chain.reference) / Fraction(chain.step))
    return min(one[0] for one in known) + origin, max(one[1] for one in known) + origin


def _bent(made: Ideal, model: SensorModel, matrix: list[list[Fraction]]) -> Ideal:
    """Give the curves, and the u over which each is inverted."""
    per, bent = PER_INPUT_UNIT[model.kind], curve(model)
    bends = []
    for j in range(len(model.axes)):
        terms = [Fraction(float(one[j])) for one in (bent.asymmetry, bent.second, bent.third)]
        one = Bend(terms[0], terms[1] / per, terms[2] / per**2, Fraction(0), Fraction(0))
        if made.input_range is not None:
            lowest, highest = _felt(made.input_range, matrix[j])
        else:
            lowest, highest = _over_all_codes(made, j, model)
        bends.append(Bend(one.asymmetry, one.second, one.third, lowest, highest))
    return replace(made, bends=tuple(bends))


def _over_all_codes(made: Ideal, j: int, model: SensorModel) -> tuple[Fraction, Fraction]:
    """Every u that a code gives, a little widened; of a curve that never turns."""
    values = np.zeros(1)
    if made.temperatures is not None:
        powers = [0.0, *(float(x) for x in made.temperatures[j].powers)]
        values = np.polynomial.polynomial.polyval(made.temperatures[j].steps.astype(float), powers)
    ends = [float(made.slope[j] * d + made.reading[j]) for d in made.signals[j]]
    per = float(PER_INPUT_UNIT[model.kind])
    extremes = np.array([[min(ends) + values.min()], [max(ends) + values.max()]]) / per
    bent = curve(model)
    one = type(bent)(bent.asymmetry[j : j + 1], bent.second[j : j + 1], bent.third[j : j + 1])
    lowest, highest = (float(x) * per * 1.0001 for x in inverse(one, extremes)[:, 0])
    return min(Fraction(0), Fraction(lowest)), max(Fraction(0), Fraction(highest))
