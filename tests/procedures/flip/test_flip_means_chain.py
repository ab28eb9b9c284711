"""A table of means in volts or counts gives what the same means in units give, axis by axis through the chain."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import inertialcal as ic
from inertialcal.core.errors import DataError, PlanError
from inertialcal.procedures.flip.reduction import Result

ANGLES = {"forward": "0 deg", "reverse": "180 deg"}
BIAS, AMBIENT = {"x": 120.0, "y": -80.0, "z": 35.0}, {"x": 0.0, "y": -1.5, "z": 2.0}  # ug, turned about x
PER_G = {"x": 1020.0, "y": 970.0, "z": 1010.0}  # V/g of each axis
REFERENCE = {"x": 2.5, "y": 2.4, "z": 2.6}  # V
LSB = 5.0 / 2**20  # V


def means() -> list[tuple[int, str, str, float]]:
    """Return flip, position, axis and mean [ug] of six flips."""
    rng = np.random.default_rng(3)
    return [(flip, way, axis, BIAS[axis] + sign * AMBIENT[axis] + 0.05 * float(rng.standard_normal()))
            for flip in range(6) for way, sign in (("forward", 1.0), ("reverse", -1.0)) for axis in "xyz"]  # fmt: skip


def written(path: Path, unit: str, value: Any, half: Any = None) -> str:
    """Write the means in a unit, with half widths of 0.2 ug where wanted."""
    head = f"flip,position,axis,mean [{unit}]{',half_width_95' if half else ''}"
    rows = [f"{flip},{way},{axis},{value(axis, v)!r}{f',{half(axis)!r}' if half else ''}"
            for flip, way, axis, v in means()]  # fmt: skip
    path.write_text("\n".join([head, *rows]) + "\n")
    return str(path)


def volts(axis: str, v: float) -> float:
    return float(REFERENCE[axis] + PER_G[axis] * v * 1e-6)


def same(found: Any, wanted: Any) -> None:
    """Check bias and ambient acceleration, and their uncertainties, against those of the means in units [m/s^2]."""
    one, other = found.result, wanted.result
    assert isinstance(one, Result)
    assert isinstance(other, Result)
    for got, true in zip(one.rows(), other.rows(), strict=True):
        assert got.key == true.key
        if true.value is not None:
            assert got.value == pytest.approx(true.value, rel=1e-6, abs=1e-13), got.key
        if true.u is not None:
            assert got.u == pytest.approx(true.u, rel=1e-6), got.key


EACH = {axis: f"{PER_G[axis]} V/g" for axis in "xyz"}
ZERO = {axis: f"{REFERENCE[axis]} V" for axis in "xyz"}


@pytest.mark.parametrize(
    ("unit", "value", "said"),
    [
        ("V", volts, {"scale_factor": EACH, "reference": ZERO}),
        ("mV", lambda axis, v: 1e3 * volts(axis, v), {"scale_factor": EACH, "reference": ZERO}),
        ("count", lambda axis, v: volts(axis, v) / LSB,
         {"scale_factor": EACH, "reference": ZERO, "lsb": "5 V / 1048576", "counts": "0, 1048575"}),
        ("LSB", lambda axis, v: 4.0 * v, {"scale_factor": {"acc": "4 LSB/ug"}}),
        ("V", volts,
         {"chain": '{ kind = "output", zero = { x = "2.5 V", y = "2.4 V", z = "2.6 V" }, scale_factor = '
                   '{ x = "1020 V/g", y = "970 V/g", z = "1010 V/g" } }'}),
    ],
    ids=["volts", "millivolts", "counts", "digital", "chain"],
)  # fmt: skip
def test_means_go_through_the_chain_of_their_axis(unit: str, value: Any, said: dict[str, Any], tmp_path: Path) -> None:
    wanted = ic.flip(written(tmp_path / "ug.csv", "ug", lambda _, v: v), positions=ANGLES)
    found = ic.flip(written(tmp_path / "raw.csv", unit, value), positions=ANGLES, **said)
    same(found, wanted)
    bias = next(one for one in found.result.rows() if one.key.quantity == "bias" and one.key.axis == "y")
    assert bias.value == pytest.approx(BIAS["y"] * 9.80665e-6, abs=5.0 * bias.u)
    ran = found.write_campaign(tmp_path / "campaign").parent
    assert ic.run(ran).exit_status in (0, 4)


def test_half_widths_know_no_reference(tmp_path: Path) -> None:
    """They are differences: the scale factor of their axis alone counts, whatever its sign."""
    minus = {axis: f"-{PER_G[axis]} V/g" for axis in "xyz"}
    in_units = written(tmp_path / "ug.csv", "ug", lambda _, v: v, lambda _: 0.2)
    in_volts = written(tmp_path / "volts.csv", "V", lambda axis, v: REFERENCE[axis] - PER_G[axis] * v * 1e-6,
                       lambda axis: 0.2e-6 * PER_G[axis])  # fmt: skip
    wanted = ic.flip(in_units, positions=ANGLES).result.readings.half_widths
    found = ic.flip(in_volts, positions=ANGLES, scale_factor=minus, reference=ZERO).result.readings.half_widths
    for axis in "xyz":
        assert found[0].values[axis] == pytest.approx(wanted[0].values[axis], rel=1e-9)
        assert found[0].values[axis] == pytest.approx(0.2 * 9.80665e-6)


def test_a_prediction_beside_volts_states_its_unit(tmp_path: Path) -> None:
    path = Path(written(tmp_path / "volts.csv", "V", volts))
    lines = path.read_text().splitlines()
    for name in ("predicted", "predicted [ug]"):
        path.write_text("\n".join([f"{lines[0]},{name}", *(f"{one},100.0" for one in lines[1:])]))
        if name == "predicted":
            with pytest.raises(DataError, match="unit not stated"):
                ic.flip(str(path), positions=ANGLES, scale_factor=EACH, reference=ZERO)
        else:
            found = ic.flip(str(path), positions=ANGLES, scale_factor=EACH, reference=ZERO)
            assert found.result.readings.predicted["y"] == pytest.approx(100.0 * 9.80665e-6)


def test_a_campaign_without_the_chain_is_refused(tmp_path: Path) -> None:
    found = ic.flip(written(tmp_path / "raw.csv", "V", volts), positions=ANGLES, scale_factor=EACH, reference=ZERO)
    toml = found.write_campaign(tmp_path / "campaign")
    text = toml.read_text()
    first = text.index("chain = ") if "chain = " in text else text.index("[sensors.accelerometer.chain]")
    last = text.index("\n", first) if "chain = " in text else text.index("\n[recordings", first)
    toml.write_text(text[:first] + text[last:])
    with pytest.raises(PlanError, match="means in 'V', need a unit of acceleration"):
        ic.check(toml.parent)
