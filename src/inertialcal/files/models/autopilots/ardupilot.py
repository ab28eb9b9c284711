"""ArduPilot's parameters of temperature calibration and of sensor offsets, as a file that ground stations load.

::

    x = SCAL (r - [p(T - 35) - p(CALTEMP - 35)] - OFFS)      SCAL: accelerometers only
    p(d) = 1e-6 (c1 d + c2 d^2 + c3 d^3)

with both temperatures held between TMIN and TMAX; rad/s, m/s2 and degC. ``INS_TCAL1_GYR2_Z`` is c2 of the z gyro of
the first IMU. OFFS is the bias at CALTEMP. The firmware reads order 3, whatever a file holds [2]_.

References
----------
.. [1] ArduPilot, libraries/AP_InertialSensor, and its wiki: "IMU Temperature Calibration". Equations and names only.
.. [2] ArduPilot, issue 27294.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.polynomial import Polynomial

from ....core.errors import DataError
from ....core.estimate import Array
from ....core.key import AXES, Kind
from ....core.remarks import Remark
from ....sensors.model.sensor_model import INPUT_UNIT, SensorModel
from ..losses import loss_lines, loss_remarks, raw_unit
from ..model_format import ImportedModels, ModelFormat, ModelText
from ..triad import Triad, model_of
from .offsets import (
    ORDER,
    Offsets,
    check_axes,
    figure,
    has_temperature,
    known_bias,
    losses,
    offsets,
    parameters,
    scales,
    unknown_left,
    unknown_lines,
)

NAME = "ArduPilot"
CENTRE = 35.0  # that the polynomials count from [degC]
SCALE = 1e-6  # of their coefficients
WORD: dict[Kind, str] = {"gyro": "GYR", "accelerometer": "ACC"}
BEGINNINGS = ("INS_TCAL", "INS_GYR", "INS_ACC")
COLDEST = -300.0  # CALTEMP that stands for none
START = "INS_GYR_CAL 1, the default, replaces OFFS and CALTEMP of the gyros at each start"


def dump(models: Mapping[Kind, SensorModel]) -> str:
    """Return the text of the file, for the first IMU.

    Raises
    ------
    DataError
        As `offsets.offsets`; ``two_ranges`` where both sensors hold for different temperatures.
    """
    lines = ["# ArduPilot parameters written by inertialcal, for the first IMU"]
    warm = {kind: offsets(model, NAME, CENTRE) for kind, model in models.items() if has_temperature(model)}
    for kind, model in models.items():
        check_axes(model)
        lines += ["#", *(f"# {line}" for line in loss_lines(model, losses(model, NAME)))]
        if model.output_unit != model.unit:
            lines.append(f"# The driver must apply the scale factor: these correct readings in {model.unit}")
        lines += [*unknown_lines(kind, model, NAME), *([f"# {START}"] if kind == "gyro" else [])]
    low, high = _ends(warm)
    lines += [f"# {one.what}. {one.do}" for one in _shared_range(models)]
    if warm or len(models) == len(WORD):  # the switch is for both sensors
        lines.append(f"INS_TCAL1_ENABLE,{1 if warm else 0}")
    lines += [f"INS_TCAL1_TMIN,{figure(low)}", f"INS_TCAL1_TMAX,{figure(high)}"] if warm else []
    for kind, model in models.items():
        lines += _sensor(kind, model, warm.get(kind), (low, high))
    return "\n".join(lines) + "\n"


def _ends(warm: Mapping[Kind, Offsets]) -> tuple[float, float]:
    """Return the range of temperature: the firmware has one for both sensors."""
    found = sorted({one.range for one in warm.values()})
    if len(found) > 1:
        each = " and ".join(f"{low:g} to {high:g} degC" for low, high in found)
        what = f"the models hold for {each}, and {NAME} has one range for both sensors"
        raise DataError(what, do="Export them one by one, and load the one that matters", code="two_ranges")
    return found[0] if found else (0.0, 0.0)


def _shared_range(models: Mapping[Kind, SensorModel]) -> tuple[Remark, ...]:
    """Return a remark where the range of one sensor is written alone: it is that of the other one too."""
    if len(models) == len(WORD) or not any(map(has_temperature, models.values())):
        return ()
    (other,) = set(WORD) - set(models)
    what = f"INS_TCAL1_TMIN and INS_TCAL1_TMAX hold for the {other}s of the vehicle too"
    do = f"If these have a temperature calibration, export both in one file: --with MODEL of the {other}s"
    return (Remark("set_on_vehicle", "warning", what, do=do),)


def _sensor(kind: Kind, model: SensorModel, held: Offsets | None, ends: tuple[float, float]) -> list[str]:
    word, lines = WORD[kind], []
    bias, at = np.asarray(model.bias), None
    powers = np.zeros((ORDER, 3)) if held is None else held.powers[1:]  # zeros: nothing of an older file stays
    written = np.array([[float(np.float32(c / SCALE)) for c in row] for row in powers])
    lines += [f"INS_TCAL1_{word}{power + 1}_{axis.upper()},{figure(float(written[power, i]))}"
                  for power in range(ORDER) for i, axis in enumerate(AXES)]  # fmt: skip
    if held is not None:
        at = float(np.clip(np.mean(model.terms["reference_temperature"]), *ends))
        bias = np.array([Polynomial(column)(at - CENTRE) for column in held.powers.T])
    if known_bias(model):
        lines += [f"INS_{word}1_CALTEMP,{figure(at)}"] if at is not None else []
        lines += [f"INS_{word}OFFS_{axis.upper()},{figure(float(value))}"
                  for axis, value in zip(AXES, bias, strict=True)]  # fmt: skip
    return lines + [f"INS_{word}SCAL_{axis.upper()},{figure(one)}"
                    for axis, one in zip(AXES, scales(model), strict=True) if one is not None]  # fmt: skip


def read(given: ModelText) -> ImportedModels | None:
    """Return the models of the first IMU; None for a text in another format.

    Raises
    ------
    DataError
        ``missing_key`` for a temperature calibration without its range or CALTEMP; as `offsets.parameters`.
    """
    found = None if given.json is not None else parameters(given.text, BEGINNINGS, given.where)
    if found is None:
        return None
    remarks = []
    if any(key.startswith(("INS_TCAL2_", "INS_TCAL3_", "INS_GYR2OFFS", "INS_ACC2OFFS")) for key in found):
        remarks.append(Remark("left_out", "warning", "other IMUs are in the file too: only the first is read"))
    models = {
        kind: _model(kind, found, given.where)
        for kind, word in WORD.items()
        if any(key.startswith((f"INS_TCAL1_{word}", f"INS_{word}OFFS_", f"INS_{word}SCAL_")) for key in found)
    }
    if not models:
        raise DataError("no parameters of the first IMU", where=given.where, code="missing_key")
    return ImportedModels(models, tuple(remarks))


def _model(kind: Kind, found: Mapping[str, float], where: str) -> SensorModel:
    word = WORD[kind]
    powers: Array = SCALE * np.array(
        [[found.get(f"INS_TCAL1_{word}{power}_{axis.upper()}", 0.0) for axis in AXES] for power in range(1, ORDER + 1)]
    )
    off = np.array([found.get(f"INS_{word}OFFS_{axis.upper()}", 0.0) for axis in AXES])
    scale = np.array([found.get(f"INS_{word}SCAL_{axis.upper()}", 1.0) for axis in AXES])
    if not np.all(scale > 0.0):
        raise DataError(f"INS_{word}SCAL: not positive", where=where, code="schema")
    gain = np.eye(3) if kind == "gyro" else np.diag(1.0 / scale)
    if not found.get("INS_TCAL1_ENABLE", 1.0) or not np.any(powers):
        return model_of(kind, np.ones(3), Triad(gain, off, np.zeros((3, 3))), INPUT_UNIT[kind], NAME)
    for key in ("INS_TCAL1_TMIN", "INS_TCAL1_TMAX"):
        if key not in found:
            raise DataError(f"no {key}", where=where, do="Save all parameters of the vehicle", code="missing_key")
    ends = found["INS_TCAL1_TMIN"], found["INS_TCAL1_TMAX"]
    stated = found.get(f"INS_{word}1_CALTEMP", found.get(f"INS_{word}_CALTEMP", COLDEST))
    if np.any(off) and stated <= COLDEST:
        raise DataError(
            f"no INS_{word}1_CALTEMP", where=where, why="the temperature that the offsets hold for",
            do="Save all parameters of the vehicle", code="missing_key",
        )  # fmt: skip
    at = CENTRE if stated <= COLDEST else float(np.clip(stated, *ends))
    moved = np.array([Polynomial([0.0, *column])(at - CENTRE) for column in powers.T])
    own = Triad(gain, off - moved, np.zeros((3, 3)))
    return model_of(kind, np.ones(3), own, INPUT_UNIT[kind], NAME, over_temperature=(powers, CENTRE, ends))


def cannot_hold(models: Mapping[Kind, SensorModel]) -> tuple[Remark, ...]:
    """Return what of these models the format leaves out, or takes otherwise."""
    gone = loss_remarks(models, NAME, lambda model: losses(model, NAME))
    start = (
        (Remark("set_on_vehicle", "info", START, do="Set INS_GYR_CAL to 0 to keep these"),) if "gyro" in models else ()
    )
    return (*gone, *start, *_shared_range(models), *unknown_left(models, NAME), *raw_unit(models, NAME))


FORMAT = ModelFormat(
    name="ardupilot",
    title=NAME,
    dump=dump,
    cannot_hold=cannot_hold,
    read=read,
    scale_optional=frozenset(WORD),
)
