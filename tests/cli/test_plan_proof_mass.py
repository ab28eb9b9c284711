"""`plan mass-attraction --proof-mass`, what is in the way, what an orbit does not use, and what the schedule says."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import inertialcal as ic
from inertialcal.core.show.rows import case_name
from inertialcal.procedures.mass_attraction.schedule_csv import read_schedule
from typed_commands import call, call_json

COMMAND = ("plan", "mass-attraction")


def sets(*changes: str) -> tuple[str, ...]:
    return tuple(word for change in changes for word in ("--set", change))


PLAN = (*COMMAND, *sets("body.cube=10 cm", "body.count=50", "body.stand_off=7.6 cm"))
MOVED = sets("motion.stroke=10 cm, 40 cm", "motion.rig=0 cm, 60 cm")
LONG = sets("proof_mass.length=8 cm", "proof_mass.radius=2 cm")


def figures(content: dict[str, Any]) -> dict[tuple[str, str], float]:
    return {(row["quantity"], case_name(row)): row["value"] for row in content["results"]}


def test_a_long_proof_mass_changes_the_amplitude_as_the_second_order_rule_has_it(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    written = tmp_path / "s.csv"
    point = figures(call_json(capsys, *PLAN, *MOVED))["amplitude", "sine"]
    content = call_json(capsys, *PLAN, *MOVED, *LONG, *sets("constants.gravity=981 cm/s^2"), "--schedule", str(written))
    rows = figures(content)
    summed = rows["proof_mass_effect", "on the amplitude, summed"]
    assert summed > 0.5  # %: longer than sqrt(3) radii, it feels more of the steep part
    assert rows["proof_mass_effect", "on the amplitude, second order"] == pytest.approx(summed, rel=0.02)
    in_ng = rows["amplitude", "sine"] * 9.81 / 9.80665
    assert 100.0 * (in_ng / point - 1.0) == pytest.approx(summed, abs=2e-3)
    assert rows["pointlike_length", "of a proof mass of these radii"] == pytest.approx(2.0 * np.sqrt(3.0))
    plan = ic.plan_mass_attraction(
        body={"cube": "10 cm", "count": 50, "stand_off": "7.6 cm"}, motion={"stroke": ["10 cm", "40 cm"]},
        proof_mass={"length": "8 cm", "radius": "2 cm"},
    )  # fmt: skip
    (curve,) = (one for one in plan.curves if one.name == "proof_mass")
    length, rule = (np.array(curve.columns[name].values) for name in ("length", "second_order"))
    assert (rule > 0.0).tolist() == (length > 2.0 * np.sqrt(3.0) * (1.0 + 1e-9)).tolist()
    lines = written.read_text().splitlines()
    assert "# gravitational constant: 6.6743e-11 m^3/s^2/kg" in lines
    assert "# gravity: 9.81 m/s^2" in lines


@pytest.mark.parametrize(
    ("words", "expected", "said"),
    [
        (("proof_mass.length=3 cm",), 3, "proof_mass.radius is missing"),
        (("proof_mass.length=3", "proof_mass.radius=1 cm"), 3, "proof_mass.length: 3 is not a quantity"),
        (
            ("proof_mass.length=3 cm", "proof_mass.radius=1 cm", "proof_mass.inner_radius=2 cm"),
            3,
            "is not between 0 and the radius",
        ),
        (("proof_mass.length=20 cm", "proof_mass.radius=1 cm"), 3, "would overlap the instrument"),
        (("instrument.case=9 cm",), 3, "would overlap the instrument"),
        (("instrument.case=-1 cm",), 3, "should be greater than or equal to 0 m"),
    ],
)
def test_a_proof_mass_or_case_that_cannot_be_is_refused_also_without_a_motion(
    capsys: pytest.CaptureFixture[str], words: tuple[str, ...], expected: int, said: str
) -> None:
    status, out, err = call(capsys, *PLAN, *sets(*words))
    assert (status, out) == (expected, "")
    assert said in " ".join(err.split())


def test_an_orbit_refuses_what_it_would_not_use_and_a_refusal_names_the_whole_command(
    capsys: pytest.CaptureFixture[str],
) -> None:
    orbit = (*COMMAND, *sets("orbit.stand_off=10 cm"))
    status, _, err = call(capsys, *orbit, *sets("noise.bias_instability=5 ug", "uncertainty.stop=1 mm"))
    assert status == 3
    assert "orbit with noise, uncertainty" in err
    refused = call_json(capsys, *orbit, *sets("timing.target=1 %"))
    assert refused["exit"] == 3
    assert refused["command"] == "plan mass-attraction"


def test_in_orbit_the_difference_over_a_long_baseline_is_seen_from_less_far_than_the_gradient(
    capsys: pytest.CaptureFixture[str],
) -> None:
    rows = figures(call_json(capsys, *COMMAND, *sets("orbit.stand_off=10 cm")))
    near = rows["distance", "from the nearer accelerometer"] / 100.0
    assert 6.6743e-11 * 4.0 * (near**-2 - (near + 2.0) ** -2) == pytest.approx(0.5e-9 * 2.0)
    assert near < rows["distance", "of its centre, at that gradient"] / 100.0


def test_the_mercury_of_a_tilt_meter_is_in_the_schedule_and_follows_from_potentials(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    written = tmp_path / "s.csv"
    pools = np.array([[0.0, -0.5, -0.1], [0.0, 0.4, -0.1]])
    said = sets("instrument.first_pool=0 cm,-50 cm,-10 cm", "instrument.second_pool=0 cm,40 cm,-10 cm")
    content = call_json(capsys, *PLAN, *MOVED, *said, "--schedule", str(written))
    schedule = read_schedule(written)
    assert schedule.mercury is not None
    body = ic.plan_mass_attraction(body={"cube": "10 cm", "count": 50, "stand_off": "7.6 cm"}).body
    assert body is not None
    offsets = (np.stack(np.meshgrid(*[np.arange(6)] * 3), -1).reshape(-1, 3) + 0.5) / 60.0 - 0.05
    points = (body.body.cells[0][:, None, :] + offsets).reshape(-1, 3)
    for place, found in zip(schedule.position[:4], schedule.mercury[:4], strict=True):
        distance = np.linalg.norm(points + np.array([0.0, 0.0, -place]) - pools[:, None, :], axis=2)
        potential = 6.6743e-11 * 11340.0 * 1e-3 / 216.0 * np.sum(1.0 / distance, axis=1)
        assert found == pytest.approx((potential[1] - potential[0]) / (9.80665 * 0.9), rel=1e-3)
    amplitude = figures(content)["mercury_amplitude", ""]
    assert amplitude == pytest.approx(np.ptp(schedule.mercury) / 2.0)


FIRST, SECOND = "instrument.first_pool=0 cm,-5 cm,0 cm", "instrument.second_pool=0 cm,5 cm,0 cm"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ((*MOVED, *sets(FIRST)), "without second_pool"),
        ((*MOVED, *sets(FIRST, "instrument.second_pool=1 cm,2 cm")), "Give 3 different values"),
        ((*MOVED, *sets(FIRST, "instrument.second_pool=1,2,4")), "is not a quantity"),
        ((*MOVED, *sets("instrument.first_pool=0 cm,0 cm,0 cm", "instrument.second_pool=0 cm,0 cm,9 cm")), "height"),
        (sets(FIRST, SECOND), "without a drive"),
    ],
)
def test_pools_that_cannot_be_are_refused(
    capsys: pytest.CaptureFixture[str], words: tuple[str, ...], said: str
) -> None:
    status, _, errors = call(capsys, *PLAN, *words)
    assert status == 3
    assert said in " ".join(errors.split())
