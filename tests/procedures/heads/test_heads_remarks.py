"""What is said of heads on one body that were not all stated, do not agree, or cannot be compared: cause by cause."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import inertialcal as ic
from independent.orbit.heads import UG, Made, Placed, Scene, made, on_line
from inertialcal.core.errors import DataError, InertialcalError
from inertialcal.physics.motion.body import parse_body
from inertialcal.procedures.heads.plan import Plan
from inertialcal.procedures.heads.readings import Readings, Track
from inertialcal.procedures.heads.reduction import Result, reduce

Array = NDArray[np.float64]
ORBIT = '[motion]\naltitude = "400 km"\nvertical = [1.0, 0.0, 0.0]'
THREE_AND_ONE = (Placed("a", (0.0, 0.0, 0.0)), Placed("b", (0.0, 2.0, 0.0)), Placed("d", (0.0, 1.0, 0.0)),
                 Placed("c", (0.0, 1.5, 0.0), False))  # fmt: skip
SHORT = 1200.0  # [s]


def reduced(one: Made, text: str) -> Result:
    body = parse_body(text.encode(), "body.toml")
    tracks = tuple(Track(one.times, one.read[name], one.scene.step, mounted, name)
                   for name, mounted in body.heads.items())  # fmt: skip
    return reduce(Plan(), Readings(tracks, body.motion))


def drawn(scene: Scene, seed: int = 3) -> Made:
    return made(replace(scene, seconds=SHORT), np.random.default_rng(seed))


def remarks(result: Result) -> dict[str, str]:
    return {one.code: one.what for one in result.remarks}


def test_what_nobody_stated_is_named() -> None:
    one = drawn(on_line())
    stated = "\n".join(line for line in one.toml(biases=True).splitlines()
                       if not line.startswith(("position_u", "orientation_u")))  # fmt: skip
    said = remarks(reduced(one, stated))
    assert "position_u or orientation_u" in said["relative_to_fixture"]
    aged = stated.replace("bias_u =", 'bias_age = "10 day"\nbias_u =')
    assert "heads a, b" in remarks(reduced(one, aged))["drift_not_stated"]
    drifting = aged.replace("bias_age", 'drift_u = "0.01 ug"\nbias_age')
    assert "drift_not_stated" not in remarks(reduced(one, drifting))
    assert "relative_to_fixture" not in remarks(reduced(one, one.toml(biases=True)))


def test_an_orbit_that_is_missing_is_asked_for_off_the_line_alone() -> None:
    off = Scene((Placed("a", (0.0, 0.0, 0.0)), Placed("b", (0.0, 2.0, 0.0)), Placed("c", (0.7, 1.0, 0.0), False)))
    one = drawn(off)
    said = remarks(reduced(one, one.toml(biases=True)))
    assert "gradient of gravity off the line" in said["orbit_not_stated"]
    assert "orbit_not_stated" not in remarks(reduced(one, one.toml(biases=True, motion=ORBIT)))
    along = drawn(on_line())
    assert "orbit_not_stated" not in remarks(reduced(along, along.toml(biases=True)))


@pytest.mark.parametrize("wrong", [0.0, 5.0])
def test_calibrated_heads_that_disagree_are_an_error(wrong: float) -> None:
    one = drawn(Scene(THREE_AND_ONE))
    one.said["d"] = one.said["d"] + wrong * UG
    said = remarks(reduced(one, one.toml(biases=True)))
    assert ("heads_disagree" in said) is bool(wrong)
    assert "not_redundant" not in said


def test_of_four_known_heads_the_odd_one_is_named() -> None:
    five = (*THREE_AND_ONE, Placed("e", (0.0, -1.0, 0.0)))
    one = drawn(Scene(five))
    one.said["d"] = one.said["d"] + 5.0 * UG
    assert "without d the others agree" in remarks(reduced(one, one.toml(biases=True)))["heads_disagree"]


@pytest.mark.parametrize("gain", [0.12, 0.2, 0.6])
def test_a_gain_that_is_far_off_is_told(gain: float) -> None:
    """However far: what it leaves between the heads is no noise, which slopes could not be told from."""
    scene = on_line()
    c = replace(scene.heads[2], gain=np.diag([gain, 0.0, 0.0]))
    one = drawn(replace(scene, heads=(*scene.heads[:2], c)))
    result = reduced(one, one.toml(biases=True))
    assert f"head c reads {100.0 * gain:.0f}" in remarks(result)["far_from_nominal"]
    assert result.estimate is not None
    assert result.estimate.value("scale_factor_error_x") == pytest.approx(gain, abs=0.01)


def test_glitches_of_one_head_and_events_of_all_are_told_apart() -> None:
    one = drawn(on_line())
    one.read["c"][100:103] += 3000.0 * UG
    said = remarks(reduced(one, one.toml(biases=True)))
    assert "departs from the others (c)" in said["glitch"]
    assert "thruster_event" not in said
    bent = drawn(on_line())
    for name, size in (("a", 1000.0), ("b", 1300.0), ("c", 2000.0)):  # a structure that bends
        bent.read[name][100:103] += size * UG
    said = remarks(reduced(bent, bent.toml(biases=True)))
    assert "all heads read an event" in said["thruster_event"]


# ---- refused -----------------------------------------------------------------------------------------------------


def without(name: str) -> Callable[[str], str]:
    def change(text: str) -> str:
        parts = text.split("[heads.")
        return "[heads.".join(part for part in parts if not part.startswith(f"{name}]"))

    return change


@pytest.mark.parametrize(
    ("change", "code"),
    [
        (without("c"), "too_few_heads"),
        (lambda text: "\n".join(line for line in text.splitlines() if not line.startswith("bias")), "not_calibrated"),
        (lambda text: text.replace("[heads.c]", "[heads.c]\ncalibrated = true"), "nothing_to_calibrate"),
    ],
    ids=["two", "none calibrated", "all calibrated"],
)
def test_heads_that_are_too_few_or_all_known_are_refused(
    change: Callable[[str], str], code: str, tmp_path: Path
) -> None:
    one = drawn(on_line())
    text = change(one.toml(biases=True))
    (tmp_path / "body.toml").write_text(text, encoding="utf-8", newline="\n")
    files = [path for path in one.write(tmp_path) if f"[heads.{path.stem}]" in text]
    with pytest.raises(InertialcalError) as caught:
        ic.heads(files, body=str(tmp_path / "body.toml"))
    assert caught.value.problems[0].code == code


def test_one_file_for_two_heads_is_refused(tmp_path: Path) -> None:
    one = drawn(on_line())
    (tmp_path / "body.toml").write_text(one.toml(biases=True), encoding="utf-8", newline="\n")
    files = one.write(tmp_path)
    files[1].write_text(files[0].read_text(encoding="utf-8"), encoding="utf-8", newline="\n")
    with pytest.raises(InertialcalError) as caught:
        ic.heads(files, body=str(tmp_path / "body.toml"))
    assert caught.value.problems[0].code == "duplicate_recording"


def test_an_axis_that_is_stuck_is_refused_by_its_head(tmp_path: Path) -> None:
    """Before, its samples counted as missing, and the first head was said to read nothing."""
    one = drawn(on_line())
    (tmp_path / "body.toml").write_text(one.toml(biases=True), encoding="utf-8", newline="\n")
    last = list(one.read)[-1]
    one.read[last][:, 1] = one.read[last][0, 1]
    with pytest.raises(InertialcalError) as caught:
        ic.heads(one.write(tmp_path), body=str(tmp_path / "body.toml"))
    (problem,) = caught.value.problems
    assert problem.code == "not_one_body"
    assert problem.what == f"{last}: y never changes"


def test_a_record_that_is_too_short_is_refused() -> None:
    one = made(replace(on_line(), seconds=30.0), np.random.default_rng(1))
    with pytest.raises(DataError) as caught:
        reduced(one, one.toml(biases=True))
    assert caught.value.problems[0].code == "too_short"
