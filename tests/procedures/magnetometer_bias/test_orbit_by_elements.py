"""A gyro against a magnetometer where the orbit is known by two-line elements alone."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.stats import t as student

import inertialcal as ic
from independent.coverage import keeps
from inertialcal.core.errors import DataError, InertialcalError
from inertialcal.core.recording import Channel, Recording
from inertialcal.physics.elements import parse_elements
from inertialcal.procedures.magnetometer_bias.entry import Tle
from inertialcal.procedures.magnetometer_bias.plan import Plan
from inertialcal.procedures.magnetometer_bias.readings import Readings, Track, track
from inertialcal.procedures.magnetometer_bias.reduction import BY_ELEMENTS, Result, reduce

pytest.importorskip("ppigrf")
pytest.importorskip("sgp4")
from independent.orbit.elements import positions, two_lines
from independent.orbit.magnetometer import Orbit, recorded
from sized import sized

Array = NDArray[np.float64]
START = 1_772_323_200_000_000_000  # 2026-03-01 [ns]
AXES = "xyz"
SIZES = (1e3, 2e3)  # standard uncertainty of a position each way; along the orbit, a day of age [m]


def made(seed: int, age: float, seconds: float = 3600.0, off: bool = True) -> tuple[Orbit, str]:
    """Return a record, and elements that are off as they state, so many days old."""
    rng = np.random.default_rng([seed, 32])
    lines = two_lines(rng, age)
    place, along = positions(lines, np.arange(seconds / 2.0) * 2.0)
    up = place / np.linalg.norm(place, axis=1)[:, None]
    across = np.cross(place, along)
    across /= np.linalg.norm(across, axis=1)[:, None]
    sizes = np.array([np.hypot(SIZES[0], SIZES[1] * age), SIZES[0], SIZES[0]]) * rng.normal(size=3) * float(off)
    true = place + sizes[0] * along + sizes[1] * across + sizes[2] * up
    return recorded(rng, seconds, 2.0, track=true), "\n".join(lines)


def tracked(one: Orbit, text: str) -> Track:
    channels = [Channel(axis, one.rates[:, i], "rad/s") for i, axis in enumerate(AXES)]
    channels += [Channel(f"magnetometer_{axis}", one.field[:, i], "T") for i, axis in enumerate(AXES)]
    stamps = np.rint(one.time * 1e9).astype(np.int64) + START
    recording = Recording(tuple(channels), stamps, 2.0, epoch="utc")
    return track(recording, "one", "one.csv", None, (parse_elements(text, "a.tle"), Tle(file="a.tle")))


def reduced(one: Orbit, text: str) -> Result:
    return reduce(Plan(), Readings((tracked(one, text),)))


def held(seeds: range, age: float) -> Counter[str]:
    hits: Counter[str] = Counter()
    for seed in seeds:
        one, text = made(seed, age)
        estimate = reduced(one, text).estimate
        truth = np.concatenate([one.bias, one.offset])
        inside = np.abs(estimate.values - truth) <= student.ppf(0.975, estimate.dof) * estimate.u
        hits.update(dict(zip(estimate.names, inside.astype(int).tolist(), strict=True)))
    return hits


def test_intervals_hold() -> None:
    hits = held(range(1, 4), 2.0)
    assert all(keeps("holds", one, 3) for one in hits.values()), hits


@pytest.mark.slow
@pytest.mark.parametrize("age", [0.0, 5.0])
def test_intervals_hold_in_200(age: float) -> None:
    n = sized(200, 40)
    hits = held(range(1, n + 1), age)
    assert all(keeps("holds", one, n) for one in hits.values()), hits


def test_the_field_is_that_of_the_true_position() -> None:
    one, text = made(1, 0.0, 400.0, off=False)
    recorded_there = Recording(
        (*(Channel(axis, one.rates[:, i], "rad/s") for i, axis in enumerate(AXES)),
         *(Channel(f"magnetometer_{axis}", one.field[:, i], "T") for i, axis in enumerate(AXES)),
         *(Channel(f"position_{axis}", one.position[:, i], "m") for i, axis in enumerate(AXES))),
        np.rint(one.time * 1e9).astype(np.int64) + START, 2.0, epoch="utc")  # fmt: skip
    other = track(recorded_there, "one", "", None)
    assert np.max(np.abs(tracked(one, text).reference - other.reference)) < 1e-10  # [T]


def test_a_position_that_is_off_moves_the_figures_as_said() -> None:
    one, text = made(2, 3.0, off=False)
    plain = tracked(one, text)
    assert plain.orbit is not None
    moved = Track(plain.times, plain.rates, plain.field, plain.reference + plain.orbit.moved[:, :, 0], plain.interval,
                  orbit=plain.orbit)  # fmt: skip
    before, after = (reduce(Plan(), Readings((each,))) for each in (plain, moved))
    (part,) = [each for each in before.estimate.components if each.source == BY_ELEMENTS]
    assert part.changes is not None
    assert part.unknowns[0] == "along the orbit, 44332"
    scale = np.max(np.abs(part.changes[0, :3]))
    # the sign: what the record would say of a field that is off so
    assert np.abs(after.estimate.values[:3] - before.estimate.values[:3]) == pytest.approx(
        np.abs(part.changes[0, :3]), abs=0.2 * scale
    )


def test_two_recordings_by_one_set_share_its_errors() -> None:
    one, text = made(3, 1.0)
    first = tracked(one, text)
    both = reduce(Plan(), Readings((first, first)))
    (part,) = [each for each in both.estimate.components if each.source == BY_ELEMENTS]
    (alone,) = [each for each in reduced(one, text).estimate.components if each.source == BY_ELEMENTS]
    assert part.u == pytest.approx(alone.u, rel=1e-6)  # twice the readings do not make it less


def test_a_clock_far_beyond_what_elements_are_known_to_is_told() -> None:
    one, text = made(4, 0.0, 5740.0, off=False)
    late = Orbit(one.time + 10.0, one.rates, one.field, one.position, one.geodetic, one.bias, one.offset,
                 one.true_rates)  # fmt: skip
    (remark,) = [each for each in reduced(late, text).remarks if each.code == "clock_offset"]
    assert "elements of that day" in remark.do


# ---- files ---------------------------------------------------------------------------------------------------------


def without_position(one: Orbit, path: Path) -> Path:
    one.write(path)
    lines = [",".join(line.split(",")[:7]) for line in path.read_text(encoding="utf-8").splitlines()]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8", newline="\n")
    return path


def test_a_file_needs_elements_and_an_instant(tmp_path: Path) -> None:
    one, text = made(1, 0.5)
    file = without_position(one, tmp_path / "orbit.csv")
    tle = tmp_path / "sat.tle"
    tle.write_text(f"OURS\n{text}\n", encoding="utf-8", newline="\n")
    with pytest.raises(InertialcalError, match="two-line elements"):
        ic.magnetometer_bias(file, epoch="2026-03-01")
    with pytest.raises(InertialcalError, match="a date without the time of day"):
        ic.magnetometer_bias(file, epoch="2026-03-01", tle=str(tle))
    with pytest.raises(InertialcalError, match="no elements of 'MINE'"):
        ic.magnetometer_bias(file, epoch="2026-03-01T00:00:00Z", tle=str(tle), satellite="MINE")
    found = ic.magnetometer_bias(file, epoch="2026-03-01T00:00:00Z", tle=str(tle), satellite="ours")
    assert found.result.estimate.values == pytest.approx(reduced(one, text).estimate.values, rel=1e-3)
    (remark,) = [each for each in found.remarks if each.code == "orbit_by_elements"]
    assert "known to 1.5 km along the orbit" in remark.what
    with pytest.raises(InertialcalError, match="after the epoch of the elements"):
        ic.magnetometer_bias(file, epoch="2026-04-01T00:00:00Z", tle=str(tle))


def test_elements_in_place_of_positions_that_are_there(tmp_path: Path) -> None:
    one, text = made(1, 0.5)
    tle = tmp_path / "sat.tle"
    tle.write_text(text, encoding="utf-8", newline="\n")
    found = ic.magnetometer_bias(one.write(tmp_path / "orbit.csv"), epoch="2026-03-01T00:00:00Z", tle=str(tle))
    assert {each.code for each in found.remarks} >= {"orbit_by_elements"}


def test_a_satellite_without_elements_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InertialcalError, match="a satellite, and no elements"):
        ic.magnetometer_bias(made(1, 0.5)[0].write(tmp_path / "orbit.csv"), epoch="2026-03-01", satellite="OURS")


def test_a_wrong_digit_is_refused_with_its_line(tmp_path: Path) -> None:
    one, text = made(1, 0.5)
    tle = tmp_path / "sat.tle"
    tle.write_text(text.replace("0012345", "0012346"), encoding="utf-8", newline="\n")
    with pytest.raises(DataError, match="checksum") as caught:
        ic.magnetometer_bias(without_position(one, tmp_path / "o.csv"), epoch="2026-03-01T00:00:00Z", tle=str(tle))
    assert caught.value.problems[0].where.endswith("sat.tle:2")
