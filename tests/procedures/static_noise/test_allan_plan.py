"""Plan of a record at rest: its forecast against noise of another simulator, what no hour helps, what is refused."""

from __future__ import annotations

import csv
import json
import math
from pathlib import Path

import numpy as np
import pytest
from scipy import special

import inertialcal as ic
from independent.static import Noise, drawn
from inertialcal.core.errors import UsageError

DEG = math.radians(1.0)
WHITE, FLICKER = 0.01, 0.002  # [deg/s/sqrt(Hz)], [deg/s]
KNOWN = {"noise": f"{WHITE} deg/s/sqrt(Hz)", "instability": f"{FLICKER} deg/s", "sample_rate": "2 Hz"}


@pytest.mark.parametrize("n", [20, pytest.param(60, marks=pytest.mark.slow)])
def test_the_forecast_is_the_scatter_of_another_simulator_and_what_the_test_states(n: int) -> None:
    found = ic.plan_allan(**KNOWN, wanted={"instability": "8 %"}, simulate=0)
    samples = int(found.time * 2.0)
    ratios: dict[str, list[float]] = {"angle_random_walk": [], "bias_instability": []}
    stated: dict[str, list[float]] = {"angle_random_walk": [], "bias_instability": []}
    truth = {"angle_random_walk": WHITE * DEG, "bias_instability": FLICKER * DEG}
    for seed in range(1, n + 1):
        values = drawn(np.random.default_rng([32, seed]), Noise(white=WHITE, flicker=FLICKER), samples, 0.5)
        made = ic.allan(values[:, None] * DEG, sample_rate=2.0, units="rad/s").result.estimate
        for quantity, size in truth.items():
            at = [k for k, key in enumerate(made.keys) if key.quantity == quantity]
            ratios[quantity] += [float(made.values[k]) / size - 1.0 for k in at]
            stated[quantity] += [float(made.u[k]) / size for k in at]
    for quantity, name in (("angle_random_walk", "noise"), ("bias_instability", "instability")):
        forecast, found_in = found.of(name).u, len(ratios[quantity])
        assert found_in >= 0.9 * n, quantity  # named in nearly every record
        low, high = special.chdtri(found_in, [0.9995, 0.0005])
        assert low <= float(np.sum(np.square(ratios[quantity]))) / forecast**2 <= high, quantity
        # the test states more than the scatter where it cannot exclude a term beside
        assert 0.7 * forecast < np.median(stated[quantity]) < 2.5 * forecast, quantity


def test_white_noise_alone_by_the_closed_form() -> None:
    """A fit to overlapping Allan deviations at octaves knows N nearly as well as all samples: 1 / sqrt(2 n)."""
    found = ic.plan_allan(noise="0.01 deg/s/sqrt(Hz)", sample_rate="10 Hz", wanted={"noise": "1 %"}, simulate=0)
    assert found.of("noise").u == pytest.approx(1.0 / math.sqrt(2.0 * 10.0 * found.time), rel=0.25)
    assert found.of("noise").u <= 0.01


def test_a_room_that_is_not_steady_and_a_scale_factor_bind() -> None:
    found = ic.plan_allan(
        **KNOWN, coefficient="0.002 deg/s/degC", room="0.5 K", wanted={"instability": "5 %"}, simulate=0
    )
    (lost,) = [one for one in found.remarks if one.code == "not_reached"]
    deviation = FLICKER * math.sqrt(2.0 * math.log(2.0) / math.pi)
    assert found.of("instability").least == pytest.approx(0.5 * (0.002 * 0.5 / deviation) ** 2, rel=0.05)
    assert "temperature of the room alone leaves" in lost.what
    other = ic.plan_allan(**KNOWN, u_scale="1 %", wanted={"noise": "0.5 %"}, simulate=0)
    assert "scale factor alone leaves 1.0 %" in next(one.what for one in other.remarks if one.code == "not_reached")


def test_noise_above_half_of_the_sample_rate_is_told() -> None:
    found = ic.plan_allan(**KNOWN, cut_off="50 Hz", wanted={"noise": "5 %"}, simulate=0)
    (folded,) = [one for one in found.remarks if one.code == "aliased"]
    assert "7.07 times too large" in folded.what
    assert "125 Hz" in folded.do
    fast = ic.plan_allan(**{**KNOWN, "sample_rate": "125 Hz"}, cut_off="50 Hz", wanted={"noise": "5 %"}, simulate=0)
    assert not [one for one in fast.remarks if one.code == "aliased"]


def test_terms_of_a_record_are_taken_from_its_file(tmp_path: Path) -> None:
    values = drawn(np.random.default_rng(1), Noise(white=WHITE, flicker=FLICKER), 40_000, 0.5) * DEG
    np.savetxt(tmp_path / "still.csv", values, header="gyro_x [rad/s]", comments="")
    made = ic.allan(tmp_path / "still.csv", sample_rate=2.0)
    (tmp_path / "noise.json").write_text(json.dumps(made.results), encoding="utf-8")
    found = ic.plan_allan(
        noise_file=str(tmp_path / "noise.json"), sample_rate="2 Hz", wanted={"noise": "1 %"}, simulate=0
    )
    assert [one.key.quantity for one in found.figures] == ["noise", "instability"]
    with pytest.raises(UsageError, match="axis"):
        ic.plan_allan(noise_file=str(tmp_path / "noise.json"), axis="q", wanted={"noise": "1 %"})
    with pytest.raises(UsageError, match="both say the noise"):
        ic.plan_allan(noise_file=str(tmp_path / "noise.json"), noise="1 deg/sqrt(h)", wanted={"noise": "1 %"})


def test_the_schedule_is_one_record_and_the_check_simulates_it(tmp_path: Path) -> None:
    path = tmp_path / "schedule.csv"
    found = ic.plan_allan(**KNOWN, wanted={"instability": "15 %"}, simulate=20, schedule=str(path))
    beside = found.of("instability").simulated
    assert beside is not None
    assert beside.agrees(found.of("instability").u)
    for one in found.figures:  # a test that states more than it scatters by says so, and why
        wide = one.simulated is not None and one.simulated.stated > 1.2 * max(one.simulated.scatter, one.u)
        told = [said for said in found.remarks if said.code == "states_more" and said.what.startswith(f"{one.name}:")]
        assert len(told) == wide
        assert all("a mild low pass" in said.what for said in told)
    with path.open(encoding="utf-8") as file:
        (row,) = list(csv.DictReader(line for line in file if not line.startswith("#")))
    assert float(row["duration [s]"]) == pytest.approx(found.time, abs=0.1)
    assert row["sample_rate [Hz]"] == "2"


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"wanted": {"noise": "1 %"}}, "no noise"),
        ({"noise": "5 V", "wanted": {"noise": "1 %"}}, "noise"),
        (KNOWN, "nothing is wanted"),
        ({**KNOWN, "wanted": {"walk": "1 %"}}, "no such figure"),
        ({**KNOWN, "room": "1 K", "available": "1 h"}, "coefficient"),
        ({"noise": "1 deg/sqrt(h)", "walk": "1 ug/sqrt(s)", "available": "1 h"}, "walk"),
    ],
)
def test_one_clear_message(given: dict[str, object], said: str) -> None:
    with pytest.raises(UsageError) as error:
        ic.plan_allan(**given)
    assert said in str(error.value)
