"""What the formats of others have in common: three sensors, a matrix, an offset and perhaps a term in acceleration.

As one equation, in outputs and SI inputs::

    v = gain x + offset + force f        gain = diag(S0) M, offset = S0 bias, force = diag(S0) G

"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array
from ...core.key import AXES, Kind
from ...core.remarks import Remark
from ...core.unit.magnitudes import CODE, LARGEST, SMALLEST, is_possible
from ...sensors.model.sensor_model import SensorModel

KINDS: tuple[Kind, ...] = ("accelerometer", "gyro")

# Terms of our equation that a format may lack, in words.
TERMS = {
    "bias": "bias",
    "g_sensitivity": "g-sensitivity",
    "bias_temperature": "bias over temperature",
    "bias_pressure": "bias over pressure",
    "bias_warm_up": "warm-up",
    "bias_temperature_rate": "bias over the rate of temperature",
    "bias_hysteresis": "hysteresis of the bias",
    "bias_run_to_run": "scatter of the bias from run to run",
    "scale_factor_asymmetry": "scale factor asymmetry",
    "second_order": "second-order term",
    "third_order": "third-order term",
}
PARTS_LOST = {"bias": "the bias", "bias_temperature": "the bias over temperature", "scale_factor": "the scale factor"}
RANGES = ("input_range", "temperature_range", "pressure_range")


@dataclass(frozen=True, eq=False)
class Triad:
    """v = gain x + offset + force f."""

    gain: Array  # shape (3, 3): [output unit / SI input unit]
    offset: Array  # shape (3,): [output unit]
    force: Array  # shape (3, 3): [output unit / (m/s2)]; zero where the model has no such term


def triad(model: SensorModel) -> Triad:
    """Return the linear part of a model at its reference conditions.

    Raises
    ------
    DataError
        ``not_three_axes``.
    """
    if model.axes != AXES:
        raise DataError(
            f"the model has the axes {', '.join(model.axes)}",
            why="other formats need the three axes x, y, z",
            do="Export it as json, or as code",
            code="not_three_axes",
        )
    scale = model.scale_factor
    force = np.zeros((3, 3)) if model.g_sensitivity is None else scale[:, np.newaxis] * model.g_sensitivity
    return Triad(scale[:, np.newaxis] * model.matrix[0], scale * model.bias, force)


def model_of(
    kind: Kind, scale: Array, own: Triad, output_unit: str, name: str, reason: str = "",
    over_temperature: tuple[Array, float, tuple[float, float]] | None = None,
) -> SensorModel:  # fmt: skip
    """Return the model with a nominal scale factor that outputs of this equation have.

    Parameters
    ----------
    kind : {"accelerometer", "gyro"}
        What it senses.
    scale : ndarray, shape (3,)
        S0 [output unit / SI input unit].
    own : Triad
        The equation.
    output_unit : str
        Unit of the outputs.
    name : str
        Whose format it comes from.
    reason : str
        Why the bias is not known; empty where it is.
    over_temperature : (ndarray, float, (float, float)), optional
        Powers of the offset in temperature, shape (q, 3) [output unit/degC^j], the temperature that they count from,
        and the range that they hold for [degC].
    """
    force = own.force / scale[:, np.newaxis]
    powers, centre, ends = over_temperature or (None, 0.0, None)
    model = SensorModel(
        kind=kind,
        axes=AXES,
        scale_factor=scale,
        output_unit=output_unit,
        matrix=own.gain / scale[:, np.newaxis],
        bias=own.offset / scale,
        bias_temperature=None if powers is None else powers / scale,
        reference_temperature=None if powers is None else np.full(3, centre),
        temperature_range=ends,
        g_sensitivity=force if np.any(force) else None,
        source=f"{name} file",
    )
    reasons = {one.name: f"{name} holds no uncertainty" for one in model.parameters}
    if reason:
        reasons |= {one.name: reason for one in model.parameters if one.key.quantity == "bias"}
    return replace(model, not_estimated=reasons)


def lost(model: SensorModel, name: str, holds: frozenset[str]) -> tuple[Remark, ...]:
    """Return a remark for each thing of a model that a format cannot hold.

    Parameters
    ----------
    holds : frozenset of str
        Fields of ``SensorModel`` that the format has beside the matrix.
    """
    gone = [words for field, words in TERMS.items() if field not in holds and np.any(model.terms.get(field, 0.0))]
    if len(model.matrix) > 1 and np.any(model.matrix[1:]):
        gone.append("matrix over temperature")
    gone += [f"change of {PARTS_LOST[part]} with {one.channel.replace('_', ' ')}" for one in model.sensitivities
             for part, array in one.parts.items() if np.any(array)]  # fmt: skip
    found = [
        Remark("not_held", "warning", f"{model.kind}: {name} cannot hold: {words}", do="It is left out")
        for words in gone
    ]
    quiet = ["nominal scale factor apart from its error"] if "scale_factor" not in holds else []
    quiet += ["uncertainties"] if model.estimate is not None else []
    quiet += ["ranges that the model holds for"] if any(getattr(model, one) is not None for one in RANGES) else []
    quiet += ["condition that the model is for"] if model.condition else []
    quiet += ["noise"] if model.noise is not None and "noise" not in holds else []
    quiet += ["item and origin of the figures"] if model.item.serial or model.provenance else []
    if quiet:
        found.append(Remark("not_held", "info", f"{model.kind}: {name} cannot hold: {', '.join(quiet)}"))
    return tuple(found)


def filled(models: Mapping[Kind, SensorModel], name: str) -> tuple[Remark, ...]:
    """Return a remark for a sensor that a format wants and nobody gave."""
    return tuple(
        Remark(
            "filled_in",
            "warning",
            f"no {kind} given: {name} needs one, so an ideal one is written",
            do=f"Give the model of the {kind} too: --with MODEL",
        )
        for kind in KINDS
        if kind not in models
    )


def ideal() -> Triad:
    """Return the equation of a sensor without error, in SI."""
    return Triad(np.eye(3), np.zeros(3), np.zeros((3, 3)))


def numbers(content: object, key: str, shape: tuple[int, ...], where: str) -> Array:
    """Return an array of a file.

    Raises
    ------
    DataError
        ``missing_key``; ``schema`` where it is no array of finite numbers of that shape; ``impossible_value``.
    """
    if not isinstance(content, Mapping) or key not in content:
        raise DataError(
            f"no {key}", where=where, do="Write the file again with the tool it comes from", code="missing_key"
        )
    try:
        found = np.array(content[key], dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        found = np.empty(0)
    if found.shape != shape or not np.all(np.isfinite(found)):
        need = " x ".join(str(n) for n in shape)
        raise DataError(f"{key} is not {need} finite numbers", where=where, code="schema")
    check_possible(found, key, where)
    return found


def check_possible(values: Array, what: str, where: str) -> None:
    """Refuse a number of a size that nothing has.

    Raises
    ------
    DataError
        ``impossible_value``.
    """
    wrong = next((float(value) for value in values.flat if not is_possible(float(value))), None)
    if wrong is not None:
        raise DataError(f"{what}: {wrong:g} is not a number from {SMALLEST:g} to {LARGEST:g}", where=where, code=CODE)


def invertible(matrix: Array, what: str, where: str) -> Array:
    """Return a matrix that has an inverse.

    Raises
    ------
    DataError
        ``not_invertible``.
    """
    if not np.linalg.cond(matrix) < 1e8:
        raise DataError(
            f"{what} has no inverse", where=where, why="readings cannot be corrected", code="not_invertible"
        )
    return matrix
