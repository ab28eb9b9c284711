"""Noise at rest of records with faults: what is named, what the terms are without it, which terms are not claimed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from inertialcal.core.recording import Channel, Recording, Source
from inertialcal.core.remarks import Remark
from inertialcal.core.results import Row
from inertialcal.procedures.static_noise import reduction as noise
from inertialcal.procedures.static_noise.agreement import agreement

GYRO, ACC = noise.Plan(kind="gyro"), noise.Plan(kind="accelerometer")
SIGMA, INTERVAL = 1e-3, 0.05  # rad/s, s
WITHIN = 3e-3  # of the angle random walk of the clean record
SLOW = ("bias_instability", "rate_random_walk", "rate_ramp", "gauss_markov_sigma", "gauss_markov_correlation_time")
Values = NDArray[np.float64]


def white(n: int = 24_000, seed: int = 1) -> Values:
    return SIGMA * np.random.default_rng(seed).standard_normal(n)


def at_rest(channels: Mapping[str, Values], name: str = "r", **more: Any) -> noise.AtRest:
    made = tuple(Channel(axis, values, "rad/s", "header", axis, "gyro") for axis, values in channels.items())
    source = Source(f"{name}.csv")
    record = Recording(made, None, INTERVAL, interval_from="header", source=source, first_row=2)
    return noise.AtRest(record, {axis: axis for axis in channels}, name=name, **more)


def found(values: Values, plan: noise.Plan = GYRO, **more: Any) -> noise.Result:
    return noise.reduce(plan, noise.readings_from(plan, [at_rest({"x": values}, **more)]))


def rows(result: noise.Result) -> dict[str, Row]:
    return {row.quantity: row for row in result.rows() if row.case.plain}


def walk(result: noise.Result) -> float:
    value = rows(result)["angle_random_walk"].value
    assert value is not None
    return value


def named(result: noise.Result, code: str) -> Remark:
    (one,) = (one for one in result.remarks if one.code == code)
    return one


def glitch(x: Values) -> Values:
    x[12_000] = -32_768.0 * SIGMA
    return x


def spikes(x: Values) -> Values:
    draw = np.random.default_rng(2)
    at = draw.choice(len(x), 3, replace=False)
    x[at] += 50.0 * SIGMA * draw.choice([-1.0, 1.0], 3)
    return x


def bursts(x: Values) -> Values:
    draw = np.random.default_rng(3)
    for at in draw.choice(len(x) - 3, 4, replace=False):
        x[at : at + 3] += 50.0 * SIGMA * draw.standard_normal(3)
    return x


@pytest.mark.parametrize("fault", [glitch, spikes, bursts])
def test_glitches_are_named_and_the_random_walk_is_that_of_the_clean_record(fault: Any) -> None:
    result = found(fault(white()))
    remark = named(result, "glitch")
    assert remark.what.endswith("from their neighbours; left out")
    assert remark.where.startswith("r.csv:")
    assert walk(result) == pytest.approx(walk(found(white())), rel=WITHIN)
    kept = found(fault(white()), screening=False)
    assert named(kept, "glitch").what.endswith("; kept in")
    assert rows(kept)["angle_random_walk"].reason.text == "in doubt: glitches were kept in"
    assert rows(found(fault(white()), replace(GYRO, disturbed="keep")))["angle_random_walk"].reason.code == "in_doubt"


def test_no_slow_term_is_claimed_across_a_step_of_the_level() -> None:
    x = white()
    x[13_000:] += 1.5 * SIGMA
    result = found(x)
    assert named(result, "level_step").index == pytest.approx(13_000, abs=100)
    assert {rows(result)[one].reason.code for one in SLOW} == {"level_step"}
    assert {rows(result)[one].status for one in SLOW} == {"not_estimated"}
    assert walk(result) == pytest.approx(walk(found(white())), rel=0.02)
    assert [term.name for term in result.axes[0].terms] == ["random_walk"]
    assert not {"rate_random_walk", "bias_instability"} & {key.quantity for key in result.estimate.keys}  # type: ignore[union-attr]
    assert {said.partition(":")[0] for _, said in result.sentences()} <= {"quantization", "angle random walk"}


def test_no_slow_term_is_claimed_across_a_thermostat_and_its_wave_is_no_part_of_the_random_walk() -> None:
    x = white(48_000)
    x += 0.2 * SIGMA * np.sin(2.0 * np.pi * np.arange(len(x)) / 7_000.0)
    result = found(x)
    assert "a wave of 3" in named(result, "slow_wave").what
    assert {rows(result)[one].reason.code for one in SLOW} == {"slow_wave"}
    assert walk(result) == pytest.approx(walk(found(white(48_000))), rel=WITHIN)


def test_figures_of_noise_that_changes_or_of_samples_saved_twice_are_in_doubt() -> None:
    x = white()
    x[12_000:] *= 1.5
    assert rows(found(x))["angle_random_walk"].reason.text == "in doubt: the noise changes within the record"
    x = white()
    x[1::40] = x[::40]
    assert "saved twice" in rows(found(x))["angle_random_walk"].reason.text


@pytest.mark.parametrize("part", [0.05, 1e-3, None])
def test_clipping_is_named(part: float | None) -> None:
    x = np.rint(white() / 1e-5) * 1e-5
    end = float(np.sort(x)[-4] if part is None else np.quantile(x, 1.0 - part))
    remark = named(found(np.minimum(x, end)), "saturated")
    assert f"of 24000 samples lie at the end of the range, {end:.5g} rad/s; left out" in remark.what


def test_a_knock_is_left_out_and_is_no_change_of_the_noise() -> None:
    x = white()
    x[9_000:9_400] += 6.0 * SIGMA * np.random.default_rng(4).standard_normal(400)
    result = found(x)
    assert {one.code for one in result.remarks if one.severity == "warning"} <= {"disturbed", "glitch"}
    assert not rows(result)["angle_random_walk"].reason


# Recordings of one sensor


def several(change: Any, count: int = 3, level: float = 0.0, plan: noise.Plan = GYRO) -> list[Remark]:
    parts = []
    for seed in range(count):
        axes = {axis: white(4_000, 10 * seed + i) + level for i, axis in enumerate("xy")}
        parts.append(at_rest(change(axes) if seed == 1 else axes, f"run{seed}"))
    return list(agreement(plan, noise.readings_from(plan, parts)))


@pytest.mark.parametrize(
    ("size", "said"),
    [(np.pi / 180.0, "rad/s, taken for deg/s"), (180.0 / np.pi, "deg/s, taken for rad/s"), (1e3, "milli")],
)
def test_a_recording_in_another_unit_is_named(size: float, said: str) -> None:
    (one,) = several(lambda axes: {axis: size * x for axis, x in axes.items()})
    assert (one.code, one.severity, one.where) == ("unit_disagrees", "error", "run1.csv")
    assert one.what.startswith("run1: the noise of x, y is ")
    assert said in one.what


def test_a_recording_with_another_sign_is_named_where_the_others_agree() -> None:
    def turned(axes: dict[str, Values]) -> dict[str, Values]:
        return axes | {"x": -axes["x"]}

    (one,) = several(turned, 4, level=0.8)
    assert (one.code, one.severity, one.where) == ("sign_disagrees", "error", "run1.csv")
    assert several(turned, 2, level=0.8) == []  # nothing says which is right


def test_accelerometers_on_several_faces_have_no_wrong_sign() -> None:
    for seed in range(6):
        parts = []
        for face in range(6):
            levels = np.where(np.arange(3) == face % 3, 9.8 * (-1) ** (face // 3), 0.0)
            axes = {axis: white(4_000, 18 * seed + 3 * face + i) + levels[i] for i, axis in enumerate("xyz")}
            parts.append(at_rest(axes, f"face{face}"))
        for chosen in (parts, [parts[0], parts[0], parts[3]], [parts[0], parts[0], parts[4]]):
            assert not list(agreement(ACC, noise.readings_from(ACC, chosen)))


def test_recordings_that_agree_are_not_named() -> None:
    for count, level in ((1, 0.0), (2, 0.0), (5, 0.0), (5, 9.8), (5, 1e-4)):
        assert several(lambda axes: {axis: 1.3 * x if not level else x for axis, x in axes.items()}, count, level) == []  # noqa: B023
