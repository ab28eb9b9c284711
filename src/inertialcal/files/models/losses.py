"""What of a model a format leaves out, each with its size: the largest error of a reading over the model's ranges.

Sizes are bounds of one term at a time, an axis each: full input on all axes at once, the whole range of temperature or
pressure, 1 g of specific force in any direction. Where no range is known there is no size, and that is said.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Polynomial

from ...core.constants import STANDARD_GRAVITY
from ...core.estimate import Array
from ...core.key import Kind
from ...core.remarks import Remark
from ...core.show.rounding import number
from ...core.units import convert
from ...sensors.model.sensor_model import FIELD_UNIT, RANGE_UNIT, SensorModel
from .apply_parts import plain
from .triad import RANGES

DIGITS = 3
GRID = 1001  # temperatures over a range at which a matrix is compared
FULL = "at full input on all axes"
NO_RANGE = "no range of the input is known"
NO_TEMPERATURES = "no range of temperature is known"
ONE_G = "at 1 g"


@dataclass(frozen=True, eq=False)
class Loss:
    """One thing that a format leaves out of a model."""

    what: str  # "cross terms"
    sizes: Array | None = None  # shape (k,): largest error of each reading [input unit]; None where there is no size
    at: str = ""  # Where the error has that size; or why there is none


def words(model: SensorModel, loss: Loss) -> str:
    """Return a loss as text: ``"cross terms: up to x 0.018, y 0.012, z 0.066 deg/s at full input on all axes"``."""
    if loss.sizes is None:
        return f"{loss.what} ({loss.at})" if loss.at else loss.what
    unit = FIELD_UNIT[model.kind]
    shown = convert(loss.sizes, model.unit, unit)
    each = ", ".join(f"{plain(axis)} {number(float(size), DIGITS)}"
                     for axis, size in zip(model.axes, shown, strict=True))  # fmt: skip
    return f"{loss.what}: up to {each} {unit}{f' {loss.at}' if loss.at else ''}"


def full_input(model: SensorModel) -> Array | None:
    """Return the largest size of the input along each axis, shape (k,); None where no range is known."""
    return None if model.input_range is None else np.max(np.abs(model.input_range), axis=1)


def bias_curves(model: SensorModel) -> list[Polynomial]:
    """Return the bias of each sensor as a polynomial in T [input unit; degC], other conditions at their reference."""
    if model.bias_temperature is None or model.reference_temperature is None:
        return [Polynomial([value]) for value in model.bias]
    rows = np.vstack([model.bias, model.bias_temperature]).T
    return [Polynomial(row)(Polynomial([-at, 1.0])) for row, at in zip(rows, model.reference_temperature, strict=True)]


def largest(curve: Polynomial, ends: tuple[float, float]) -> float:
    """Return the largest size of a polynomial between two temperatures: at an end, or where its slope is zero."""
    roots = curve.deriv().roots() if curve.degree() else np.empty(0)
    inside = [float(one.real) for one in np.atleast_1d(roots) if ends[0] < one.real < ends[1]]
    return float(np.max(np.abs(curve(np.array([*ends, *inside])))))


def matrix_loss(model: SensorModel, diagonal: bool) -> Loss | None:
    """Return what is lost with the matrix; the cross terms alone where the format has a scale factor for each axis."""
    own = model.matrix[0]
    error = own / np.diag(own)[:, np.newaxis] - np.eye(len(own)) if diagonal else own - np.eye(len(own))
    what = "cross terms" if diagonal else "scale factor errors and cross terms"
    if not np.any(error):
        return None
    full = full_input(model)
    if full is None:
        return Loss(what, at=NO_RANGE)
    never = [axis for axis, size in zip(model.axes, full, strict=True) if not size]
    turned = f"{FULL} ({_ends(model, full)})" + (f"; never turned: {', '.join(never)}" if never else "")
    return Loss(what, np.abs(error) @ full, turned)


def _ends(model: SensorModel, full: Array) -> str:
    unit = RANGE_UNIT[model.kind]
    texts = [number(float(one), DIGITS) for one in convert(full, model.unit, unit)]
    return f"{texts[0] if len(set(texts)) == 1 else ', '.join(texts)} {unit}"


def other_losses(model: SensorModel) -> list[Loss]:
    """Return what every format with a constant matrix and a bias (over temperature) leaves out, beside the matrix."""
    full = full_input(model)
    reach = None if full is None else np.abs(model.matrix[0]) @ full
    found = [*_curve(model, reach)]
    if model.g_sensitivity is not None:
        sizes = STANDARD_GRAVITY.value * np.linalg.norm(model.g_sensitivity, axis=1)
        found.append(Loss("g-sensitivity", np.asarray(sizes), ONE_G))
    if len(model.matrix) > 1:
        found.append(_matrix_over_temperature(model, full))
    found += [*_bias(model), *_channels(model, reach)]
    return [one for one in found if one.sizes is None or np.any(one.sizes)]


def _curve(model: SensorModel, reach: Array | None) -> list[Loss]:
    """Return what is lost of the nonlinearity; ``reach`` is the largest M x of each sensor, shape (k,)."""
    terms = (
        ("scale factor asymmetry", 0.5, 1, model.scale_factor_asymmetry),
        ("second-order term K2", 1.0, 2, model.second_order),
        ("third-order term K3", 1.0, 3, model.third_order),
    )
    return [
        Loss(what, at=NO_RANGE) if reach is None else Loss(what, part * np.abs(term) * reach**power, FULL)
        for what, part, power, term in terms
        if term is not None
    ]


def _bias(model: SensorModel) -> list[Loss]:
    """Return what is lost of the bias, beside its change with temperature."""
    found = []
    if model.bias_pressure is not None and model.reference_pressure is not None:
        what, ends = "bias over pressure", model.pressure_range
        if ends is None:
            found.append(Loss(what, at="no range of pressure is known"))
        else:
            far = max(abs(one - model.reference_pressure) for one in ends)
            found.append(Loss(what, np.abs(model.bias_pressure) * far, "over the range of pressure"))
    if model.bias_warm_up is not None:
        found.append(Loss("warm-up", np.sum(np.abs(model.bias_warm_up), axis=0), "at power-up"))
    if model.bias_temperature_rate is not None:
        per_minute = np.abs(model.bias_temperature_rate) / 60.0
        found.append(Loss("bias over the rate of temperature", per_minute, "for each degC/min"))
    if model.bias_hysteresis is not None:
        found.append(Loss("hysteresis of the bias", np.abs(model.bias_hysteresis)))
    if model.bias_run_to_run is not None:
        found.append(Loss("scatter of the bias from run to run", model.bias_run_to_run, "(standard deviation)"))
    return found


def _matrix_over_temperature(model: SensorModel, full: Array | None) -> Loss:
    what = "matrix over temperature"
    if full is None or model.temperature_range is None or model.reference_temperature is None:
        return Loss(what, at=NO_RANGE if full is None else NO_TEMPERATURES)
    away = np.linspace(*model.temperature_range, GRID)[:, np.newaxis] - model.reference_temperature
    total = np.zeros((GRID, *model.matrix[0].shape))
    for coefficient in model.matrix[:0:-1]:
        total = (total + coefficient) * away[:, :, np.newaxis]
    return Loss(what, np.max(np.abs(total) @ full, axis=0), f"{FULL}, over the range of temperature")


def _channels(model: SensorModel, reach: Array | None) -> list[Loss]:
    """Return what is lost with each channel that bias or scale factor change with."""
    found = []
    for one in model.sensitivities:
        what = f"change with {one.channel.replace('_', ' ')}"
        if one.range is None:
            found.append(Loss(what, at=f"no range of {one.channel} is known"))
            continue
        far = max(abs(end - one.reference) for end in one.range)
        total = np.zeros(len(model.axes)) if one.bias is None else np.abs(one.bias) * far
        if one.scale_factor is not None:
            if reach is None:
                found.append(Loss(what, at=NO_RANGE))
                continue
            total = total + np.abs(one.scale_factor) * far * reach
        if one.bias_temperature is not None:
            if model.temperature_range is None or model.reference_temperature is None:
                found.append(Loss(what, at=NO_TEMPERATURES))
                continue
            warm = np.max(np.abs(np.subtract.outer(model.temperature_range, model.reference_temperature)), axis=0)
            total = total + np.abs(one.bias_temperature) * far * warm
        found.append(Loss(what, total, f"over its range{' and ' + FULL if one.scale_factor is not None else ''}"))
    return found


def quiet_losses(model: SensorModel) -> list[Loss]:
    """Return what is no term of the equation: uncertainties (of the bias with their size), ranges, noise, origin."""
    found = []
    if model.estimate is not None:
        held = dict(zip(model.estimate.names, model.estimate.u, strict=True))
        own = [held.get(f"bias_{axis}") for axis in model.axes]
        sizes = None if None in own else np.array(own, dtype=np.float64)
        found.append(Loss(f"uncertainties{'' if sizes is None else ' (bias, one standard deviation)'}", sizes))
    if any(getattr(model, one) is not None for one in RANGES[::2]):
        found.append(Loss("ranges of input and pressure"))
    if model.condition:
        found.append(Loss(f"condition {plain(model.condition)}: right for it alone, and no notion of pressure"))
    if model.noise is not None:
        found.append(Loss("noise"))
    if model.item.serial or model.provenance:
        found.append(Loss("item and origin of the figures"))
    return found


def loss_remarks(
    models: Mapping[Kind, SensorModel], name: str, losses: Callable[[SensorModel], list[Loss]]
) -> tuple[Remark, ...]:
    """Return a remark for each loss of each model that has a size, and one for all without."""
    found = []
    for kind, model in models.items():
        for one in losses(model):
            found.append(Remark("not_held", "warning", f"{kind}: {name} cannot hold: {words(model, one)}",
                                do="It is left out"))  # fmt: skip
        quiet = "; ".join(words(model, one) for one in quiet_losses(model))
        if quiet:
            found.append(Remark("not_held", "info", f"{kind}: {name} cannot hold: {quiet}"))
    return tuple(found)


def loss_lines(model: SensorModel, losses: list[Loss]) -> list[str]:
    """Return lines of comment on a model and what is not in the file."""
    item = " ".join(plain(one) for one in (model.item.maker, model.item.part, model.item.serial) if one)
    head = f"{model.kind}: {item or 'unnamed sensor'}"
    head += f", condition {plain(model.condition)}" if model.condition else ""
    judged = [] if model.judged else ["Not checked on hold-out recordings."]
    gone = [f"Not held: {words(model, one)}" for one in (*losses, *quiet_losses(model))]
    return [head, *judged, *gone]


def raw_unit(models: Mapping[Kind, SensorModel], name: str) -> tuple[Remark, ...]:
    """Return a remark for sensors whose output is in another unit than the readings that a program corrects."""
    found = []
    for kind, model in models.items():
        if model.output_unit != model.unit:
            what = f"{kind}: {name} corrects readings in {model.unit}, not outputs in {model.output_unit}"
            scale = ", ".join(f"{s:.17g}" for s in model.scale_factor)
            found.append(Remark("other_raw_unit", "warning", what, do=f"Divide the outputs by scale_factor: {scale}"))
    return tuple(found)
