"""A rate table after a thermal test: what is taken off, what is left, and how both errors go together."""

from __future__ import annotations

import re
import tomllib
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from inertialcal.campaign.engine.engine import ReducedTest as Fitted
from inertialcal.campaign.file.cross_checks import cross_checks
from inertialcal.campaign.file.schema import CampaignFile
from inertialcal.campaign.twins.fitted import fitted_tests
from inertialcal.core.errors import DataError
from inertialcal.core.key import Key
from inertialcal.core.recording import Channel, Recording
from inertialcal.procedures.model_terms import joined_terms
from inertialcal.procedures.protocol import Facts
from inertialcal.procedures.protocol import Tested as Done
from inertialcal.procedures.rate_table import reduction as rate_table
from inertialcal.procedures.rate_table.model.held_out import model_terms
from inertialcal.procedures.thermal import reduction as thermal
from inertialcal.procedures.thermal.correction import ThermalCorrection, sources_of
from inertialcal.procedures.thermal.terms import model_terms as thermal_terms
from inertialcal.rigs.twin import SEED, Twin
from inertialcal.statistics.intervals import contains, t_interval
from npsat1_small import short_twin

AXES = ("x", "y", "z")
AFTER = re.compile(r"^after = .*\n", re.M)


def made(**change: Any) -> Twin:
    return short_twin(5, parts=("thermal", "rate_table"), **change)


@pytest.fixture(scope="module")
def twin() -> Twin:
    return made()


@pytest.fixture(scope="module")
def found(twin: Twin) -> dict[str, Fitted]:
    return {one.test.id: one for one in fitted_tests(twin)}


@pytest.fixture(scope="module")
def bias(found: dict[str, Fitted]) -> ThermalCorrection:
    result = found["thermal_ambient"].result
    assert isinstance(result, thermal.Result)
    return ThermalCorrection("thermal_ambient", result)


def on_table(found: dict[str, Fitted]) -> rate_table.Result:
    result = found["rate"].result
    assert isinstance(result, rate_table.Result)
    return result


def test_what_is_left_is_the_reading_less_the_polynomial_at_its_temperature(
    twin: Twin, found: dict[str, Fitted], bias: ThermalCorrection
) -> None:
    """Within the run-to-run spread of the temperature; the polynomial itself is some 0.1 deg/s."""
    as_it_is = {one.test.id: one for one in fitted_tests(replace(twin, campaign=AFTER.sub("", twin.campaign)))}
    left, whole = on_table(found).estimate, on_table(as_it_is).estimate
    assert left is not None
    assert whole is not None
    of_law = sources_of(bias)[0]
    assert of_law is not None
    for axis in AXES:
        law = bias.result.sensors[axis].law
        off = float((law.basis([22.0 + 3.0]) @ law.coefficients)[0])  # the unit is warmer than its room
        slope = abs(of_law.value(Key("bias_temperature", axis, power=1)))
        taken = whole.value(f"bias_{axis}") - left.value(f"bias_{axis}")
        assert taken == pytest.approx(off, abs=5.0 * slope + np.radians(0.0042))
        assert abs(taken) > 5.0 * abs(taken - off) or axis == "y"
        name = f"scale_factor_error_{axis}"
        assert left.value(name) == pytest.approx(whole.value(name), abs=2e-5)


def test_the_truth_lies_within_what_is_stated(twin: Twin, found: dict[str, Fitted]) -> None:
    true = {one.axis: one.value for one in twin.truth if (one.quantity, one.test) == ("bias", "rate")}
    estimate = on_table(found).estimate
    assert estimate is not None
    for axis in AXES:
        at = estimate.index(f"bias_{axis}")
        wide = t_interval(float(estimate.values[at]), float(estimate.u[at]), float(estimate.dof[at]), 0.9999)
        assert contains(wide, true[axis])
        assert estimate.u[at] < np.radians(0.01)


def test_the_scatter_of_the_thermal_test_is_in_the_bias_and_not_in_the_matrix(
    found: dict[str, Fitted], bias: ThermalCorrection
) -> None:
    estimate = on_table(found).estimate
    assert estimate is not None
    part = next(one for one in estimate.components if one.source == "thermal_ambient: scatter between runs")
    assert part.kind == "A"
    for axis in AXES:
        law = bias.result.sensors[axis].law
        at = estimate.index(f"bias_{axis}")
        own, dof = law.contrasts(law.basis([25.0]))
        assert part.u[at] == pytest.approx(np.sqrt(own[0, 0]), rel=0.05)
        assert np.broadcast_to(part.dof, part.u.shape)[at] == pytest.approx(dof[0], rel=0.2)
        assert part.u[estimate.index(f"scale_factor_error_{axis}")] < 1e-5


def test_the_thermometer_and_the_converter_drop_out(found: dict[str, Fitted]) -> None:
    estimate = on_table(found).estimate
    assert estimate is not None
    off = {one.source for one in estimate.components if one.source.startswith("thermal_ambient: ")}
    assert off == {
        "thermal_ambient: scatter between runs",
        "thermal_ambient: order of the polynomial",
        "thermal_ambient: earth rate: latitude",
        "thermal_ambient: earth rate: tilt of the body",
        "thermal_ambient: earth rate: azimuth of the body",
    }


def test_errors_of_the_polynomial_cancel_at_the_temperature_of_the_table(
    found: dict[str, Fitted], bias: ThermalCorrection
) -> None:
    """The sum of polynomial and rest is what was read on the table: there the thermal test adds nothing."""
    result = on_table(found)
    assert result.estimate is not None
    facts = Facts("gyro", "deg/s", "rad/s")
    rate = Done("rate", "", "fit", result.plan, result.readings, result, facts=facts)
    first = thermal_terms(bias.result, [found["thermal_ambient"].tested])
    assert first is not None
    later = replace(model_terms(result, [rate]), tests=("rate",), after=("thermal_ambient",))
    whole = joined_terms([later, replace(first, tests=("thermal_ambient",))]).estimate
    assert whole is not None
    warmth = 25.0 - bias.result.plan.reference_temperature
    names = [n for n in whole.names if n == "bias_x" or (n.startswith("bias_temperature_") and n.endswith("_x"))]
    scatter = next(one for one in whole.components if one.source == "thermal_ambient: scatter between runs")

    def u_at(degrees: float) -> float:
        powers = np.array([degrees**k for k in range(len(names))])
        at = [whole.index(name) for name in names]
        return float(np.sqrt(powers @ scatter.covariance[np.ix_(at, at)] @ powers))

    law = bias.result.sensors["x"].law
    alone = float(np.sqrt(law.contrasts(law.basis([25.0]))[0][0, 0]))
    assert u_at(warmth) < 0.1 * alone
    assert u_at(warmth + 40.0) > 0.1 * u_at(warmth)
    at_25 = sum(whole.value(name) * warmth**k for k, name in enumerate(names))
    earth = thermal.earth_along(bias.result.plan)[0][0]
    expected = float((law.basis([25.0]) @ law.coefficients)[0]) - earth + result.estimate.value("bias_x")
    assert at_25 == pytest.approx(expected, rel=1e-9)


def test_with_a_reading_at_rest_it_drops_out(twin: Twin) -> None:
    given = "plan = { attitude ="
    assert twin.campaign.count("after = ") == twin.campaign.count(given) == 2
    referenced = twin.campaign.replace(given, "plan = { zero_reference = true, attitude =")
    result = {one.test.id: one for one in fitted_tests(replace(twin, campaign=referenced))}["rate"].result
    assert result.estimate is not None
    assert not any(one.source.startswith("thermal_ambient: ") for one in result.estimate.components)


def turned(bias: ThermalCorrection, **channels: Any) -> tuple[str, Recording]:
    recording = bias.result.readings.sweeps[0]
    n = len(recording)
    made = {"x": np.zeros(n), "temperature_x": recording.temperature["x"]} | channels
    own = tuple(Channel(name, np.asarray(values), "rad/s") for name, values in made.items() if values is not None)
    return "turned", Recording(own, time_ns=np.arange(n) * 10**9, epoch="elapsed")


def test_samples_beyond_the_ramps_are_left_out_and_counted(bias: ThermalCorrection) -> None:
    n = len(bias.result.readings.sweeps[0])
    warmth = np.full(n, 25.0)
    warmth[:7] = 99.0
    one = bias.apply([turned(bias, temperature_x=warmth)])[0][0]
    assert np.isnan(one.channel("x").data).sum() == 7
    assert [(r.code, r.count) for r in one.remarks] == [("outside", 7)]


@pytest.mark.parametrize(
    ("channels", "code", "words"),
    [
        ({"temperature_x": None}, "no_temperature", "no temperature of the x sensor"),
        ({"temperature_x": 120.0}, "outside", "x was at 120 to 120 degC, thermal_ambient knows its bias from -"),
    ],
)
def test_what_has_no_bias_there_is_refused(
    bias: ThermalCorrection, channels: dict[str, Any], code: str, words: str
) -> None:
    n = len(bias.result.readings.sweeps[0])
    filled = {name: None if value is None else np.full(n, value) for name, value in channels.items()}
    with pytest.raises(DataError, match=words) as caught:
        bias.apply([turned(bias, **filled)])
    assert caught.value.problems[0].code == code


def test_a_sensor_without_a_law_is_refused(bias: ThermalCorrection) -> None:
    sensors = {axis: one for axis, one in bias.result.sensors.items() if axis != "x"}
    lacking = replace(bias, result=replace(bias.result, sensors=sensors))
    with pytest.raises(DataError, match="found no bias over temperature of x"):
        lacking.apply([turned(bias)])


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('after = ["thermal_ambient"]', 'after = ["rate_check"]', "'rate_check' is no flip or thermal test"),
        ('after = ["thermal_ambient"]', 'after = ["thermal_ambient_check"]', 'with use = "fit"'),
        (
            'against = "thermal_ambient"',
            'after = ["thermal_ambient"]',
            "nothing is taken off the readings of a thermal test",
        ),
    ],
)
def test_a_wrong_after_is_named(twin: Twin, tmp_path: Any, old: str, new: str, words: str) -> None:
    text = twin.campaign.replace(SEED, "5")
    file = CampaignFile.model_validate(tomllib.loads(text.replace(old, new)))
    found = [one.what for one in cross_checks(tmp_path, file, lambda *path: ".".join(map(str, path)))]
    assert any(words in what for what in found)
