"""Accelerometers and gyros with stamps of their own on one clock, as a phone logs them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from independent.case import Case, Table
from independent.positions import by_hand
from independent.trial import Outcome, called
from inertialcal.core.errors import DataError
from inertialcal.core.recording import Channel, Recording
from inertialcal.procedures.positions.inputs import own_stamps

FULL = 200  # [Hz]


@pytest.fixture(scope="module", name="hand")
def _hand() -> Case:
    return by_hand(3, positions=12, rest=3.0, first_rest=6.0, rate=FULL)


def sensor(case: Case, name: str, rows: np.ndarray, late: float = 0.0) -> Table:
    """Return the samples of a sensor with their own stamps, of which every one is late [s]."""
    whole = case.tables["hand.csv"]
    signals = tuple(one for one in whole.signals if one.startswith(name))
    columns = {whole.time: whole.columns[whole.time][rows] + late} | {one: whole.columns[one][rows] for one in signals}
    return Table(columns, signals, whole.time, form={**whole.form, whole.time: "%.6f"})


def files(folder: Path, **tables: Table) -> list[str]:
    paths = Case("positions", {f"{name}.csv": one for name, one in tables.items()}, [f"@{n}.csv" for n in tables], {})
    return [f"{name}={path}" for name, path in zip(tables, paths.write(folder), strict=True)]


def jittered(rng: np.random.Generator, n: int, step: int) -> np.ndarray:
    """Return every so many-th sample, give or take one, but for some that are lost."""
    rows = np.arange(step, n - step, step)
    rows = rows + rng.integers(-1, 2, len(rows)) * (step > 2)
    return rows[rng.random(len(rows)) > 0.01]


def positions(folder: Path, *words: str) -> Outcome:
    return called(["positions", *words, "--gravity", "9.81 m/s2", "--latitude", "48 deg"], folder)


def figures(found: Outcome, quantity: str, kind: str) -> tuple[np.ndarray, np.ndarray]:
    """Return values and standard uncertainties of a quantity, by axis."""
    rows = [
        one for one in found.rows if (one["quantity"], one["sensor"]) == (quantity, kind) and one["value"] is not None
    ]
    return np.array([one["value"] for one in rows]), np.array([one["u"] for one in rows])


def test_figures_hold_the_truth_with_the_uncertainty_of_each_sensors_own_samples(hand: Case, tmp_path: Path) -> None:
    """100 and 50 Hz, jittered and with samples lost; means of what was interpolated would show less noise."""
    rng = np.random.default_rng(2)
    n = len(hand.tables["hand.csv"])
    acc, gyro = sensor(hand, "acc", jittered(rng, n, 4)), sensor(hand, "gyro", jittered(rng, n, 2))
    found = positions(tmp_path, *files(tmp_path, acc=acc, gyro=gyro))
    assert found.exit == 0
    (said,) = [text for code, text in found.said if code == "joined_by_stamps"]
    assert "accelerometers (50 Hz) and gyros (100 Hz)" in said
    for quantity, kind in (("scale_factor_error", "gyro"), ("bias", "gyro"), ("scale_factor_error", "accelerometer")):
        values, u = figures(found, quantity, kind)
        truth = np.array([hand.truth[f"{quantity} {axis} {kind}"] for axis in "xyz"])
        assert np.all(np.abs(values - truth) < 4.0 * u)
    at_rest = 12 * 3.0 * 100.0  # samples of the gyros
    own = np.median(figures(found, "bias", "gyro")[1])
    assert 0.6 < own / (0.002 / np.sqrt(at_rest)) < 3.0


def test_a_stamp_column_for_each_sensor_in_one_file(hand: Case, tmp_path: Path) -> None:
    whole = hand.tables["hand.csv"]
    seconds = whole.columns[whole.time] - whole.columns[whole.time][0]
    columns = {"acc_time [s]": seconds, **{one: whole.columns[one] for one in whole.signals if one.startswith("acc")}}
    columns |= {"gyro_time [s]": seconds + 0.4 / FULL}
    columns |= {one: whole.columns[one] for one in whole.signals if one.startswith("gyro")}
    table = Table(
        columns, whole.signals, "acc_time [s]", form={**whole.form, "acc_time [s]": "%.6f", "gyro_time [s]": "%.6f"}
    )
    (path,) = Case("positions", {"phone.csv": table}, ["@phone.csv"], {}).write(tmp_path)
    found = positions(tmp_path, path)
    (said,) = [text for code, text in found.said if code == "joined_by_stamps"]
    assert "lies 2 to 2 ms from it" in said
    assert "Samples outside the overlap: accelerometers 1, gyros 1" in said
    shared = called(hand.write(tmp_path / "shared"), tmp_path)
    for kind in ("accelerometer", "gyro"):
        values, u = figures(found, "scale_factor_error", kind)
        same, same_u = figures(shared, "scale_factor_error", kind)
        assert np.all(np.abs(values - same) < 0.5 * u)
        np.testing.assert_allclose(u, same_u, rtol=0.2)


def test_nothing_is_interpolated_over_a_gap_in_a_turn(hand: Case, tmp_path: Path) -> None:
    n = len(hand.tables["hand.csv"])
    rows = np.arange(n)
    rate = np.linalg.norm([hand.tables["hand.csv"].columns[one] for one in hand.tables["hand.csv"].signals[3:]], axis=0)
    fastest = int(np.argmax(rate))
    gyro = sensor(hand, "gyro", rows[np.abs(rows - fastest) > 30], 0.4 / FULL)
    found = positions(tmp_path, *files(tmp_path, acc=sensor(hand, "acc", rows), gyro=gyro))
    assert found.exit == 0
    assert found.codes["rotation_incomplete"] == 1


def test_stamps_of_other_clocks_are_refused(hand: Case, tmp_path: Path) -> None:
    rows = np.arange(len(hand.tables["hand.csv"]))
    found = positions(
        tmp_path, *files(tmp_path, acc=sensor(hand, "acc", rows), gyro=sensor(hand, "gyro", rows, 3600.0))
    )
    assert found.exit == 3
    assert found.codes["clocks_differ"] == 1


def test_a_step_back_in_time_is_named(hand: Case, tmp_path: Path) -> None:
    rows = np.arange(len(hand.tables["hand.csv"]))
    gyro = sensor(hand, "gyro", rows, 0.4 / FULL)
    gyro.columns[gyro.time][1000:] -= 0.5
    found = positions(tmp_path, *files(tmp_path, acc=sensor(hand, "acc", rows), gyro=gyro))
    assert found.exit == 3
    assert found.codes["time_backwards"] == 1


def test_gravity_is_the_users_and_earth_rate_that_of_the_latitude(hand: Case, tmp_path: Path) -> None:
    (path,) = [word for word in hand.write(tmp_path) if word.endswith("hand.csv")]
    both = positions(tmp_path, path)
    gravity = called(["positions", path, "--gravity", "9.81 m/s2"], tmp_path)
    latitude = called(["positions", path, "--latitude", "48 deg"], tmp_path)
    assert both.exit == 0
    for kind, alike, other in (("accelerometer", gravity, latitude), ("gyro", latitude, gravity)):
        quantity = "scale_factor_error" if kind == "accelerometer" else "bias"
        values = figures(both, quantity, kind)[0]
        np.testing.assert_allclose(values, figures(alike, quantity, kind)[0], rtol=1e-9)
        assert np.abs(values - figures(other, quantity, kind)[0]).max() > 1e-7


def test_stamps_that_are_not_known_are_asked_for() -> None:
    """The clocks are not two, they are not known."""
    one, other = (Recording((Channel("x", np.zeros(n), "m/s^2"),)) for n in (5, 6))
    with pytest.raises(DataError, match="stamps are not known"):
        own_stamps((one, other))
