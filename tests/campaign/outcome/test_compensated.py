"""Requirements on compensated readings: judged on readings held out alone, and in which ways they cannot be fooled."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping
from dataclasses import replace
from datetime import UTC, datetime
from typing import Any

import numpy as np
import pytest
from demo_power import decided

from inertialcal.campaign.calls.call import campaign_of
from inertialcal.campaign.engine.whole import Whole, reduce_campaign
from inertialcal.campaign.inputs.sources import Memory
from inertialcal.core.errors import DataError, UsageError
from inertialcal.core.recording import Recording
from inertialcal.core.show.requirement_lines import requirement_lines
from inertialcal.rigs.npsat1 import rig as npsat1
from inertialcal.rigs.npsat1.setup import AIR, Bench
from inertialcal.rigs.npsat1.unit import draw_unit, polynomial_bias
from inertialcal.rigs.twin import SEED, Twin
from inertialcal.statistics.intervals import covers
from npsat1_small import QUICK, SHORT, short_twin
from sized import sized

AIR_ALONE = {"parts": ("thermal",), "chambers": {AIR: QUICK[AIR]}}
Document = dict[str, Any]
Change = Callable[[Document], object]


def twin_of(seed: int, **change: Any) -> Twin:
    return short_twin(seed, **(AIR_ALONE | {"chamber_runs": 8, "chamber_fit_runs": 4} | change))


def whole(twin: Twin, change: Change | None = None, files: Mapping[str, Recording] | None = None) -> Whole:
    document = tomllib.loads(twin.campaign.replace(SEED, str(twin.seed)))
    if change is not None:
        change(document)
    return reduce_campaign(campaign_of(document), Memory({**twin.recordings, **(files or {})}, {}))


def judged(found: Whole) -> list[dict[str, Any]]:
    return [one for one in found.results["verdicts"] if one["readings"] == "compensated"]


@pytest.fixture(scope="module")
def twin() -> Twin:
    return twin_of(3)


@pytest.fixture(scope="module")
def plain(twin: Twin) -> Whole:
    return whole(twin)


def test_the_raw_sensor_fails_and_the_compensated_one_passes(plain: Whole) -> None:
    found = judged(plain)
    assert {one["test"] for one in found} == {"thermal_ambient_check"}
    assert {one["verdict"] for one in found} == {"PASS"}
    assert "FAIL" in {one["as_read"]["verdict"] for one in found}
    for one in found:
        assert -0.05 < one["interval"]["lo"] < one["value"] < one["interval"]["hi"] < 0.05
    line = next(one for one in requirement_lines(plain.results) if one.requirement == "R2")
    assert (line.raw_verdict, line.verdict) == ("FAIL", "PASS")
    assert line.raw_value is not None
    assert line.compensated_value is not None
    assert abs(line.compensated_value) < 0.05 < abs(line.raw_value)
    assert plain.verdict == "PASS"


def test_the_figure_as_read_is_that_of_a_requirement_on_readings_as_they_are(twin: Twin, plain: Whole) -> None:
    def as_read(document: Document) -> None:
        next(one for one in document["requirements"] if one["id"] == "R2").pop("readings")

    rows = [one for one in whole(twin, as_read).results["verdicts"] if one["requirement"] == "R2"]
    beside = {(one["axis"], one["at"]): one["as_read"] for one in judged(plain)}
    assert len(rows) == len(beside)
    for one in rows:
        assert one["as_read"] is None
        assert beside[one["axis"], one["at"]] == {
            key: one[key] for key in ("value", "u", "interval", "margin", "verdict")
        }


@pytest.mark.parametrize("n", [4, pytest.param(sized(40, 8), marks=pytest.mark.slow)])
def test_the_band_holds_what_compensation_truly_leaves(n: int) -> None:
    """Bias drawn less the bias of the delivered model: both are known here, and neither comes from the readings."""
    hits = []
    for seed in range(1, n + 1):
        found = whole(twin_of(seed))
        assert found.modelled is not None
        (model,) = [one.model for one in found.modelled.delivered]
        assert model is not None
        assert model.bias_temperature is not None
        assert model.reference_temperature is not None
        unit = draw_unit(np.random.default_rng(seed).spawn(5)[0])
        for i, axis in enumerate(model.axes):
            at = [one for one in judged(found) if one["axis"] == axis]
            warmth = np.array([one["at"] for one in at])
            powers = np.polynomial.Polynomial([model.bias[i], *model.bias_temperature[:, i]])
            left = polynomial_bias(unit, AIR, warmth)[:, "xyz".index(axis)] - powers(
                warmth - model.reference_temperature[i]
            )
            inside = [one["interval"]["lo"] <= true <= one["interval"]["hi"]
                      for one, true in zip(at, np.degrees(left), strict=True)]  # fmt: skip
            hits.append(all(inside))
    assert covers(sum(hits), len(hits))


def requirement(document: Document) -> Document:
    found: Document = next(one for one in document["requirements"] if one["id"] == "R2")
    return found


def held(document: Document) -> Document:
    found: Document = next(one for one in document["tests"] if one["id"] == "thermal_ambient_check")
    return found


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda one: requirement(one).update(tests=["thermal_ambient"]), "of test 'thermal_ambient', use = 'fit'"),
        (lambda one: held(one).update(use="report_only"), "use = 'report_only'"),
        (lambda one: requirement(one).update(quantity="hysteresis", where=""), "of hysteresis"),
        (lambda one: (requirement(one).pop("tests"), held(one).update(use="report_only")), "no test is held out"),
    ],
)
def test_readings_that_are_not_held_out_are_refused_before_anything_is_read(
    twin: Twin, change: Change, said: str
) -> None:
    with pytest.raises(UsageError) as caught:
        whole(twin, change)
    assert any(said in problem.what and problem.do for problem in caught.value.problems)


def test_power_ups_that_the_model_was_fitted_on_decide_nothing(twin: Twin) -> None:
    def same_power_up(document: Document) -> None:
        document["recordings"]["ambient_5"]["run"] = "ambient_1"

    found = judged(whole(twin, same_power_up))
    assert {one["verdict"] for one in found} == {"INCONCLUSIVE"}
    assert {one["reason"] for one in found} == {
        "in doubt: the model was fitted on power-up ambient_1, too: these readings are not held out"
    }


def test_later_hours_of_a_recording_of_the_fit_are_not_held_out(twin: Twin) -> None:
    start = datetime(2010, 4, 28, tzinfo=UTC)
    day, hours = 86_400, 2_400

    def split(document: Document) -> None:
        fit = next(one for one in document["tests"] if one["id"] == "thermal_ambient")
        middle = [start.timestamp() + number * day + hours for number in range(4)]
        ends = [start.timestamp() - 1.0, *(start.timestamp() + number * day for number in range(1, 9))]
        fit["windows"] = [[stamp(ends[number]), stamp(middle[number])] for number in range(4)]
        held(document)["recordings"] = fit["recordings"]
        held(document)["windows"] = [[stamp(middle[number]), stamp(ends[number + 1])] for number in range(4)]

    found = judged(whole(twin, split))
    assert {one["verdict"] for one in found} == {"INCONCLUSIVE"}
    assert all("these readings are not held out" in one["reason"] for one in found)


def stamp(seconds: float) -> str:
    return datetime.fromtimestamp(seconds, UTC).strftime("%Y-%m-%dT%H:%M:%SZ")


def test_one_power_up_held_out_decides_nothing(twin: Twin) -> None:
    found = judged(whole(twin, lambda one: held(one).update(recordings=["ambient_5"])))
    assert {one["verdict"] for one in found} == {"INCONCLUSIVE"}
    assert {one["reason"] for one in found} == {"one power-up is held out: how another one differs was not observed"}
    assert "FAIL" in {one["as_read"]["verdict"] for one in found}


@pytest.mark.parametrize("original", ["recordings/ambient_1.csv", "recordings/ambient_6.csv"])
@pytest.mark.parametrize("shift", [0, 30 * 86_400])
def test_a_copied_recording_is_refused(twin: Twin, original: str, shift: int) -> None:
    """Of a power-up of the fit, or of another one held out; with other stamps, too."""
    one = twin.recordings[original]
    assert one.time_ns is not None
    columns = tuple(replace(each, data=each.data + shift) if each.name == "unix_s" else each for each in one.channels)
    copy = replace(one, time_ns=one.time_ns + shift * 10**9, channels=columns)
    with pytest.raises(DataError) as caught:
        whole(twin, files={"recordings/ambient_5.csv": copy})
    assert "duplicate_recording" in {problem.code for problem in caught.value.problems}


def test_temperatures_beyond_the_model_are_not_judged() -> None:
    narrow = twin_of(3, set_points=(23.0, -10.0, 40.0, 23.0))
    wide = twin_of(3)
    names = [f"recordings/ambient_{number}.csv" for number in range(1, 5)]
    found = judged(whole(wide, files={name: narrow.recordings[name] for name in names}))
    beyond = [one for one in found if one["at"] < -11.0 or one["at"] > 41.0]
    assert beyond
    assert {one["verdict"] for one in beyond} == {"INCONCLUSIVE"}
    assert all("of the model" in one["reason"] for one in beyond)
    assert {one["verdict"] for one in found if -5.0 <= one["at"] <= 35.0} == {"PASS"}


def test_a_model_that_readings_held_out_refute_compensates_nothing(twin: Twin) -> None:
    turned = twin_of(3, inverted=(1, -1, 1))
    names = [f"recordings/ambient_{number}.csv" for number in range(5, 9)]
    found = whole(twin, files={name: turned.recordings[name] for name in names})
    assert found.verdict == "FAIL"
    assert {one["reason"] for one in judged(found)} == {"no model is delivered that could compensate these readings"}


@pytest.mark.slow
def test_the_demonstration_decides() -> None:
    """The default campaign, seed 1: as ``make power`` counts it."""
    found = decided(1, Bench())
    assert found.verdict == "PASS"
    assert set(found.raw.values()) == {"FAIL"}
    assert npsat1.Bench() != SHORT
