"""Plan of a record of gyro and magnetometer: its forecast against simulated tests, its programme, what is refused."""

from __future__ import annotations

import csv
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import special

import inertialcal as ic
from inertialcal.core.errors import UsageError
from inertialcal.core.recording import Channel, Recording
from inertialcal.procedures.magnetometer_bias.plan import Plan
from inertialcal.procedures.magnetometer_bias.readings import Readings, track
from inertialcal.procedures.magnetometer_bias.reduction import reduce
from inertialcal.procedures.planned import TestPlan

pytest.importorskip("ppigrf")
from independent.orbit.magnetometer import DEG, recorded
from sized import sized

AXES = "xyz"
WHITE = 0.004 * math.sqrt(2.0)  # of 0.004 deg/s a sample of 2 s [deg/s/sqrt(Hz)]
KNOWN = {"noise": f"{WHITE} deg/s/sqrt(Hz)", "field_noise": "50 nT", "field_error": "0 nT", "interval": "2 s"}
ONE_HOUR = {"available": "62 min", "most_orbits": 1, "simulate": 0}


def plan(**more: Any) -> TestPlan:
    return ic.plan_magnetometer_bias(**{**KNOWN, **ONE_HOUR, **more})


@pytest.mark.parametrize(
    ("motion", "n"),
    [
        ("nadir", 4),
        pytest.param("nadir", sized(60, 15), marks=pytest.mark.slow),
        pytest.param("tumbling", sized(60, 15), marks=pytest.mark.slow),
    ],
)
def test_the_forecast_is_the_scatter_of_another_simulator(motion: str, n: int) -> None:
    """Of orbits and motions that are drawn, so of the same size: within a factor of 2 of the forecast for one."""
    found = plan(motion=motion, available="48 min", turn_rate="0.3 deg/s")
    assert found.time == pytest.approx(0.5 * 5740.0, rel=0.01)
    errors = []
    for seed in range(1, n + 1):
        made = recorded(np.random.default_rng(seed), found.time, 2.0, motion)
        channels = [Channel(axis, made.rates[:, i], "rad/s") for i, axis in enumerate(AXES)]
        channels += [Channel(f"magnetometer_{axis}", made.field[:, i], "T") for i, axis in enumerate(AXES)]
        channels += [Channel(f"position_{axis}", made.position[:, i], "m") for i, axis in enumerate(AXES)]
        stamps = np.rint(made.time * 1e9).astype(np.int64) + 1_772_323_200_000_000_000
        one = track(Recording(tuple(channels), stamps, 2.0, epoch="utc"), "one", "", None)
        errors.append(np.max(np.abs(reduce(Plan(), Readings((one,))).estimate.values[:3] - made.bias)))
    worst = float(np.sqrt(np.mean(np.square(errors))))
    assert 0.5 < worst / found.of("bias").u < 2.5, (worst / DEG, found.of("bias").u / DEG)


STATED = {"u_scale": "0.5 %", "u_misalignment": "2 mrad", "u_mounting": "3 mrad", "u_field": "60 nT"}


@pytest.mark.parametrize(
    ("more", "n"),
    [
        ({**STATED, "field_error": "60 nT"}, 20),
        pytest.param(STATED, sized(100, 25), marks=pytest.mark.slow),
        pytest.param({"field_error": "60 nT"}, sized(100, 25), marks=pytest.mark.slow),
        pytest.param({"walk": "3e-6 deg/s/sqrt(s)", "motion": "nadir"}, sized(100, 25), marks=pytest.mark.slow),
    ],
    ids=["all", "standards", "field", "walk"],
)
def test_simulated_tests_scatter_as_forecast(more: dict[str, Any], n: int) -> None:
    found = plan(**more, interval="10 s", available="48 min", simulate=n)
    assert not [one for one in found.remarks if one.code == "forecast_differs"]
    for one in found.figures:
        assert one.simulated is not None
        low, high = special.chdtri(n, [0.9995, 0.0005])
        assert low <= n * (one.simulated.scatter / one.u) ** 2 <= high, one.key
        assert 0.7 < one.simulated.stated / one.u < 2.0, one.key


def test_parts_by_what_they_must_be() -> None:
    def parts(field: str) -> dict[str, float]:
        return {one.label: one.u for one in plan(u_field=field, u_mounting="1 mrad").of("bias").parts}

    one, twice = parts("3 uT"), parts("6 uT")  # so much that it decides which axis is known worst
    of_field, of_angle = "field of the earth, the same all along", "angle between gyro and magnetometer"
    assert set(one) == {"noise of gyro and magnetometer", of_angle, of_field}
    assert twice[of_field] == pytest.approx(2.0 * one[of_field], rel=1e-6)
    assert twice[of_angle] == pytest.approx(one[of_angle])
    assert 0.05 < one[of_angle] / (1e-3 * 0.005) < 2.0  # of the turn, seen under that angle


def test_noise_makes_all_of_it_larger_in_proportion() -> None:
    one = plan().of("bias").u
    twice = plan(noise=f"{2.0 * WHITE} deg/s/sqrt(Hz)", field_noise="100 nT").of("bias").u
    assert twice == pytest.approx(2.0 * one, rel=1e-6)


def test_the_longest_interval_that_is_enough_is_chosen() -> None:
    settings = {**KNOWN, "interval": None, "simulate": 0, "most_orbits": 2}
    easy = ic.plan_magnetometer_bias(**settings, wanted={"bias": "0.001 deg/s"})
    hard = ic.plan_magnetometer_bias(**settings, wanted={"magnetometer_bias": "2 nT"})
    assert easy.time == pytest.approx(0.5 * 5740.0, rel=0.01)
    assert float(easy.design.choice["sample interval"].split()[0]) > float(
        hard.design.choice["sample interval"].split()[0]
    )
    assert hard.of("magnetometer_bias").u <= 2e-9


def test_what_a_standard_alone_makes_impossible_is_told() -> None:
    found = plan(u_scale="1 %", wanted={"bias": "0.0001 deg/s"})
    (remark,) = [one for one in found.remarks if one.code == "not_reached"]
    assert "scale factor of the gyro alone leaves" in remark.what


def test_the_programme_is_written(tmp_path: Path) -> None:
    found = ic.plan_magnetometer_bias(
        **{**KNOWN, "interval": "10 s"}, available="4 h", simulate=0, schedule=str(tmp_path / "schedule.csv")
    )
    lines = (tmp_path / "schedule.csv").read_text(encoding="utf-8").splitlines()
    rows = list(csv.DictReader(one for one in lines if not one.startswith("#")))
    assert float(rows[-1]["stop [s]"]) == pytest.approx(found.time, abs=0.1)
    assert {one["sample interval [s]"] for one in rows} == {"10"}
    assert [one["start [s]"] for one in rows][1:] == [one["stop [s]"] for one in rows][:-1]


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({"available": "20 min"}, "less than half an orbit"),
        ({"noise": "1 mg"}, "noise"),
        ({"date": "tomorrow"}, "is no date"),
        ({"date": "2055-01-01"}, "the model of the field holds"),
        ({"turn_rate": "60 deg/s"}, "needs more samples"),
        ({"wanted": {"bias": "1 nT"}}, "bias"),
        ({"wanted": {"drift": "1 nT"}}, "no such figure"),
        ({"altitude": "10 km"}, "altitude"),
    ],
)
def test_what_cannot_be_planned_is_refused(more: dict[str, Any], said: str) -> None:
    with pytest.raises(UsageError, match=said):
        plan(**more)


def test_a_body_that_does_not_turn_leaves_more_open_than_one_that_does() -> None:
    assert plan(motion="nadir").of("bias").u > 1.2 * plan(turn_rate="0.3 deg/s").of("bias").u
