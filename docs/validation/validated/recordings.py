"""Recordings that others made, with what their authors, or the field's tools, found in them."""

from __future__ import annotations

import csv
import json
from importlib.metadata import version
from typing import Any

import numpy as np
import pandas as pd
from imucal import FerrarisCalibration, ferraris_regions_from_df
from test_positions_recordings import GRAVITY, SHEET_ACC, SHEET_GYRO

import inertialcal as ic
from inertialcal.core.units import factor as factor_of

from . import tedaldi
from .found import Line, Table, shared

WITHIN = 0.003  # relative, of a scale factor that a sheet rounds to 1
PRINTED = 2e-5  # relative: six digits


def tables() -> list[Table]:
    """Return a table a recording."""
    return [_xsens(), _ferraris(), _mpu6050()]


def _recording(acc: Any, gyro: Any, units: tuple[str, str], rate: float, time: Any = None) -> ic.Recording:
    named = [(f"{group}_{axis}", values[:, k], unit) for group, values, unit in
             (("acc", acc, units[0]), ("gyro", gyro, units[1])) for k, axis in enumerate("xyz")]  # fmt: skip
    stamps = None if time is None else np.round(time * 1e9).astype(np.int64)
    return ic.Recording(tuple(ic.Channel(n, np.array(v), u) for n, v, u in named), stamps, 1.0 / rate)


def _row(found: ic.Reduced, sensor: str, quantity: str, axis: str) -> ic.Row:
    wanted = (sensor, quantity, axis, "result")
    (row,) = (one for one in found.rows if (one.key.sensor, one.quantity, one.axis, one.method.value) == wanted)
    return row


def _at_no_input(found: ic.Reduced, sensor: str, axis: str) -> tuple[float, float]:
    """Return the reading at no input and its standard uncertainty: the bias times the ideal scale factor."""
    bias, scale = (_row(found, sensor, one, axis) for one in ("bias", "scale_factor"))
    ideal = float(f"{scale.value:.2g}")  # without a stated one the bias refers to that which is found, to two digits
    return bias.value * ideal, bias.u * ideal


def _xsens() -> Table:
    folder = shared() / "imu_tk_xsens_mti"
    acc, gyro = np.loadtxt(folder / "xsens_acc.mat"), np.loadtxt(folder / "xsens_gyro.mat")
    found = ic.positions(
        _recording(acc[:, 1:], gyro[:, 1:], ("count", "count"), 100.0, acc[:, 0]), gravity=f"{GRAVITY} m/s^2"
    )
    by_peer = tedaldi.fitted(acc[:, 1:], gyro[:, 1:], 0.01, GRAVITY, (415.0, 4770.0))
    lines = []
    for sensor, sheet, theirs in (("accelerometer", SHEET_ACC, by_peer.acc), ("gyro", SHEET_GYRO, by_peer.gyro)):
        for k, axis in enumerate("xyz"):
            row = _row(found, sensor, "scale_factor", axis)
            close = abs(row.value / sheet[k] - 1.0) < WITHIN and abs(row.value / theirs[k] - 1.0) < WITHIN
            cells = (f"scale factor, {sensor} {axis}", row.unit, row.value, row.u, float(theirs[k]), sheet[k])
            lines.append(Line(cells, close))
    for sensor, theirs in (("accelerometer", by_peer.acc_bias), ("gyro", by_peer.gyro_bias)):
        for k, axis in enumerate("xyz"):
            cells = (
                f"reading at no input, {sensor} {axis}",
                "count",
                *_at_no_input(found, sensor, axis),
                float(theirs[k]),
                None,
            )
            lines.append(Line(cells, judged=False))
    text = (
        "A hand-held Xsens MTi, 512 s in 38 positions (imu_tk; BSD). The factory's sheet is rounded to 1 count. The "
        "peer is the method of Tedaldi, Pretto and Menegatti (2014), written from the paper beside this page: it has "
        "no uncertainty, no g-sensitivity and another frame, which moves scale factors by parts in a thousand. A "
        f"line holds if all three agree within {100 * WITHIN:g} %. `ic.positions(recording, gravity='{GRAVITY} "
        "m/s^2')`; u is standard uncertainty. Of readings at no input nothing is asked: that of the peer's gyros is "
        "the mean of the first rest, g-sensitivity and all."
    )
    heads = ("figure", "unit", "inertialcal", "u", "Tedaldi's method", "factory")
    return Table("An IMU laid by hand: Xsens MTi", text, heads, (0, 0, 7, 2, 7, 0), tuple(lines))


def _ferraris() -> Table:
    folder = shared() / "imucal_ferraris"
    rate, gravity = 102.4, 9.81
    data = pd.read_csv(folder / "example_ferraris_session.csv")
    listed = json.loads((folder / "example_ferraris_session_list.json").read_text(encoding="utf-8"))
    parts = {name: (int(one["start"]), int(one["end"])) for name, one in listed.items()}
    acc, gyro = (data[[f"{group}_{axis}" for axis in "xyz"]].to_numpy() for group in ("acc", "gyr"))
    names = {one: [f"{one}_{axis}" for axis in "xyz"] for one in ("acc", "gyr")}
    labelled = pd.concat([data.iloc[a:b].assign(part=name) for name, (a, b) in parts.items()]).set_index("part")
    regions = ferraris_regions_from_df(labelled[[*names["acc"], *names["gyr"]]])
    theirs = FerrarisCalibration(grav=gravity).compute(regions, rate, from_acc_unit="m/s^2", from_gyr_unit="deg/s")
    stated = dict.fromkeys(("fixture.orientation", "fixture.mounting", "turn.angle"), "20 mrad")
    found = ic.positions(
        _recording(acc, np.radians(gyro), ("m/s^2", "rad/s"), rate),
        gravity=f"{gravity} m/s^2",
        turn="-360 deg",
        sections=str(folder / "example_ferraris_session_list.json"),
        standards=stated,
    )
    lines = []
    for sensor, peer_scale, peer_bias, factor in (
        ("accelerometer", np.diag(theirs.K_a), theirs.b_a, 1.0),
        ("gyro", np.diag(theirs.K_g), theirs.b_g, np.degrees(1.0)),
    ):
        unit = "m/s^2" if sensor == "accelerometer" else "deg/s"
        for k, axis in enumerate("xyz"):
            error, bias = (_row(found, sensor, one, axis) for one in ("scale_factor_error", "bias"))
            value, u = 1.0 + factor_of(error.unit, "1") * error.value, factor_of(error.unit, "1") * error.u
            cells = (f"scale factor, {sensor} {axis}", "1", value, u, float(peer_scale[k]))
            lines.append(Line(cells, abs(value - peer_scale[k]) < 2.0 * u + 2e-4))
            cells = (f"bias, {sensor} {axis}", unit, factor * bias.value, factor * bias.u, float(peer_bias[k]))
            lines.append(Line(cells, judged=False))
    text = (
        f"Six faces and three turns of 360 deg (imucal {version('imucal')}, its example session at its true rate of "
        "102.4 Hz; MIT). imucal computes the closed form of Ferraris (1995), without uncertainty; `inertialcal` fits "
        "all rests and turns at once. With 20 mrad for how faces and turns were made, a scale factor holds if they "
        "agree within 2 u and 2e-4: the closed form keeps the cosine of each tilt. The same closed form in "
        "`inertialcal` gives imucal's own snapshot within 1e-6 (`tests/procedures/positions`)."
    )
    heads = ("figure", "unit", "inertialcal", "u", "imucal")
    return Table("Six faces and three turns: the session of imucal", text, heads, (0, 0, 6, 2, 6), tuple(lines))


def _mpu6050() -> Table:
    folder = shared() / "sunsided_mpu6050_static"
    lines = []
    for sensor in ("gyroscope", "accelerometer", "temperature"):
        figures, worst = 0, 0.0
        for place in sorted(one for one in folder.iterdir() if one.is_dir()):
            with (place / "sensor-stats.csv").open(encoding="utf-8") as stream:
                rows = [row for row in csv.DictReader(stream) if row["sensor"] == "MPU6050" and row["type"] == sensor]
            survey = ic.info(place / f"mpu6050_{sensor}.mat")
            for channel, row in zip(survey.channels, rows, strict=True):
                own = (channel.minimum, channel.maximum, channel.mean, channel.std)
                theirs = [float(row[name]) for name in ("v_min", "v_max", "v_mean", "v_std_dev")]
                worst = max(worst, *(abs(a - b) / max(abs(b), 1e-2) for a, b in zip(own, theirs, strict=True)))
                figures += len(own)
        lines.append(Line((sensor, figures, worst, PRINTED), worst <= PRINTED))
    text = (
        "Fourteen recordings of an MPU-6050 (sunsided; EUPL-1.2) with their author's least, greatest, mean and "
        "standard deviation of each channel, six digits each, by `ic.info`. Differences are relative, of means below "
        "0.01 to 0.01."
    )
    heads = ("sensor", "figures", "largest relative difference", "allowed")
    return Table("Statistics of an author: MPU-6050", text, heads, (0, 0, 2, 1), tuple(lines))
