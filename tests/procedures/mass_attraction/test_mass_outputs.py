"""A moved mass on sensors that give volts, codes, numbers, pulses a second or readings: one truth, one scale factor.

The records are made here, by their own equation: output = zero + S (a + drift + noise), codes of 24 bits.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import inertialcal as ic
from inertialcal.core.errors import DataError, UsageError

G = 9.80665
APPLIED = 23e-9 * G  # m/s^2
TRUE = 1030.0  # V/g
DWELL, MOVE, CYCLES, STEP = 100.0, 20.0, 25, 4.0  # s, s, 1, s
LSB = 5.0 / 2**24
ERROR = 3.0  # %: of the nominal 1000 V/g


def schedule(path: Path) -> str:
    """Write the schedule: middle, near, middle, far."""
    rows = [f"{i * (DWELL + MOVE)},{i * (DWELL + MOVE) + DWELL},{0.25 + 0.25 * o},{APPLIED * o!r}"
            for i, o in enumerate([0.0, 1.0, 0.0, -1.0] * CYCLES)]  # fmt: skip
    path.write_text("\n".join(["# dwells a cycle: 4", "start [s],stop [s],position [m],applied [m/s2]", *rows]) + "\n")
    return str(path)


def felt(seed: int) -> tuple[Any, Any]:
    """Return times and what the sensor feels [g]: the mass, drift, noise."""
    rng = np.random.default_rng(seed)
    time = np.arange(0.5 * STEP, 4 * CYCLES * (DWELL + MOVE) - MOVE, STEP)
    place = np.minimum((time // (DWELL + MOVE)).astype(int), 4 * CYCLES - 1)
    drift = 1e-7 * np.cumsum(rng.standard_normal(len(time))) / np.sqrt(len(time))
    order = np.array([0.0, 1.0, 0.0, -1.0])[place % 4]
    return time, 5e-5 + APPLIED / G * order + drift + 2e-9 * rng.standard_normal(len(time))


SENSORS: dict[str, tuple[str, Any, dict[str, Any], float]] = {  # header, output of [g], what is said, factor to V/g
    "volts": ("output [V]", lambda a: 2.5 + TRUE * a, {}, 1.0),
    "millivolts": ("accel_x [mV]", lambda a: 1e3 * (2.5 + TRUE * a), {}, 1.0),
    "nominal": ("output [V]", lambda a: 2.5 + TRUE * a,
                {"scale_factor": {"acc": "1000 V/g"}, "reference": {"acc": "2.5 V"}}, 1.0),
    "codes": ("adc [count]", lambda a: np.rint((2.5 + TRUE * a) / LSB),
              {"scale_factor": {"acc": "1000 V/g"}, "reference": {"acc": "2.5 V"}, "lsb": "5 V / 16777216",
               "counts": "0, 16777215"}, 1.0),
    "digital": ("acc_x [count]", lambda a: np.rint(4e9 * 1.03 * a), {"scale_factor": {"acc": "4 count/ng"}},
                1000.0 / 4e9),
    "rate": ("rate [count/s]", lambda a: 170.0 + 1.03e7 * a,
             {"gate": "4 s", "scale_factor": {"acc": "10 count/s/ug"}}, 1e-4),
    "pulses": ("pulses [count]", lambda a: np.rint(STEP * (170.0 + 1.03e9 * a)),
               {"gate": "4 s", "scale_factor": {"acc": "1000 count/s/ug"}}, 1e-6),
    "readings": ("acc_x [ug]", lambda a: 1.03e6 * a, {}, 1000.0),
}  # fmt: skip


def records(tmp_path: Path, name: str) -> list[str]:
    head, output, *_ = SENSORS[name]
    found = []
    for run in (1, 2, 3):
        time, a = felt(run)
        path = tmp_path / f"{name}{run}.csv"
        np.savetxt(path, np.column_stack([time, output(a)]), ["%.1f", "%.12g"], ",", header=f"time [s],{head}",
                   comments="")  # fmt: skip
        found.append(str(path))
    return found


def estimate(found: Any) -> tuple[float, float]:
    """Return scale factor and uncertainty as the result has them, SI."""
    assert found.result.estimate is not None
    return float(found.result.estimate.values[0]), float(found.result.estimate.u[0])


@pytest.mark.parametrize("name", list(SENSORS))
def test_every_output_gives_the_same_scale_factor(name: str, tmp_path: Path) -> None:
    """Relative to volts, to what rounding to whole counts changes; the truth lies within the uncertainty."""
    _, _, said, to_volts = SENSORS[name]
    of_mass = schedule(tmp_path / "schedule.csv")
    found = ic.mass_attraction(records(tmp_path, name), schedule=of_mass, **said)
    wanted, u = estimate(ic.mass_attraction(records(tmp_path, "volts"), schedule=of_mass))
    value, own_u = (one * to_volts for one in estimate(found))
    if name == "readings":
        value, own_u = value / G, own_u / G
    assert value == pytest.approx(wanted, abs=0.1 * u)
    assert own_u == pytest.approx(u, rel=0.1)
    assert wanted * G == pytest.approx(TRUE, abs=4.0 * u * G)
    rows = {one.key.quantity: one for one in found.rows if not one.case.beside and not one.member}
    if said or name == "readings":
        error = rows["scale_factor_error"]
        assert error.value is not None
        assert error.u is not None
        assert error.value == pytest.approx(ERROR, abs=4.0 * error.u)


def test_the_model_of_volts_compensates_the_record_as_it_is(tmp_path: Path) -> None:
    said = SENSORS["codes"][2]
    paths = records(tmp_path, "codes")
    found = ic.mass_attraction(paths, schedule=schedule(tmp_path / "schedule.csv"), **said)
    (model,) = found.write_models(tmp_path / "model.json")
    done = ic.compensate(str(model), paths[0])
    time, a = felt(1)
    assert len(done) == len(time)
    got = done.channel("x").data
    scale = estimate(found)[0] * G
    assert got == pytest.approx(a * TRUE / scale, abs=2e-9)


def test_a_scale_factor_at_high_g_is_in_the_output_too(tmp_path: Path) -> None:
    paths, of_mass = records(tmp_path, "volts"), schedule(tmp_path / "schedule.csv")
    found = ic.mass_attraction(paths, schedule=of_mass, high_g={"scale_factor": "1000 V/g", "u": "1 V/g"})
    (row,) = [one for one in found.rows if one.key.quantity == "high_g_difference"]
    assert row.value is not None
    assert row.value == pytest.approx(estimate(found)[0] * G / 1000.0 - 1.0)
    with pytest.raises(UsageError, match=r"high_g\.scale_factor = '10 count/s/ug' is not in V"):
        ic.mass_attraction(paths, schedule=of_mass, high_g={"scale_factor": "10 count/s/ug"})


def test_a_gate_is_of_pulses(tmp_path: Path) -> None:
    of_mass = schedule(tmp_path / "schedule.csv")
    with pytest.raises(UsageError, match="readings in V is of none"):
        ic.mass_attraction(records(tmp_path, "volts"), schedule=of_mass, gate="4 s")
    with pytest.raises(UsageError, match=r"pulses without the time.*No pulses\?"):
        ic.mass_attraction(records(tmp_path, "codes"), schedule=of_mass)
    with pytest.raises(UsageError, match="stamp='end' without what each sample is the mean of"):
        ic.mass_attraction(records(tmp_path, "volts"), schedule=of_mass, stamp="end")


def test_samples_longer_than_a_dwell_are_refused(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="mass dwells for 100 s"):
        ic.mass_attraction(records(tmp_path, "pulses"), schedule=schedule(tmp_path / "schedule.csv"), gate="130 s")
