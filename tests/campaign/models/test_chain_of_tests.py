"""Thermal test, rate table after it and noise give one model; what two of them share is one unknown in it."""

from __future__ import annotations

import tomllib
from functools import cache

import numpy as np
import pytest

from inertialcal.campaign.calls.call import campaign_of
from inertialcal.campaign.engine.whole import Whole, reduce_campaign
from inertialcal.campaign.inputs.sources import Memory
from inertialcal.core.estimate import Array, Estimate
from inertialcal.core.key import Key
from inertialcal.procedures import procedure_of
from inertialcal.procedures.model_terms import ModelTerms
from inertialcal.rigs.npsat1.setup import AIR
from inertialcal.rigs.twin import SEED
from inertialcal.sensors.model.sensor_model import SensorModel
from npsat1_small import QUICK, short_twin

THERMAL, RATE, NOISE = "thermal_ambient", "rate", "noise"
ONLY_THERMAL = 'air = { bias = ["thermal_ambient"] }'
REFERENCE = 20.0  # [degC]

pytestmark = pytest.mark.slow


@cache
def whole() -> Whole:
    """Return the chain in air, the bias of both tests added, reduced from memory."""
    twin = short_twin(3, chambers={AIR: QUICK[AIR]}, static_hours=0.5)
    assert ONLY_THERMAL in twin.campaign
    text = twin.campaign.replace(ONLY_THERMAL, f'air = {{ bias = ["{THERMAL}", "{RATE}"] }}').replace(SEED, "3")
    store = Memory(twin.recordings, {file: extra.content for file, extra in twin.extras.items()})
    return reduce_campaign(campaign_of(tomllib.loads(text)), store)


def model() -> SensorModel:
    modelled = whole().modelled
    assert modelled is not None
    (one,) = modelled.every
    assert one.model is not None
    return one.model


def terms_of(name: str) -> ModelTerms:
    """Return what a test gives by itself."""
    one = next(one for one in whole().tested if one.test.id == name)
    found = procedure_of(one.test.procedure).terms(one.result, [one.tested])
    assert found is not None
    return found


def of_thermal(estimate: Estimate, keys: tuple[Key, ...]) -> dict[str, Array]:
    """Return what the unknowns of the thermal test change in these terms, by origin, shape (s, k)."""
    found = {}
    for one in estimate.components:
        if one.origin.test == THERMAL and one.changes is not None:
            rows = np.zeros((len(one.changes), len(keys)))
            for k, key in enumerate(keys):
                rows[:, k] = one.changes[:, estimate.index(key)] if key in estimate.keys else 0.0
            found[one.origin.what] = rows
    return found


def joined() -> Estimate:
    """Return the terms of the model."""
    estimate = model().estimate
    assert estimate is not None
    return estimate


def shared() -> tuple[tuple[Key, ...], dict[str, Array], dict[str, Array]]:
    """Return the keys of the model, and what the unknowns of the thermal test change in what each test found."""
    keys = joined().keys
    thermal, rate = (terms_of(name).estimate for name in (THERMAL, RATE))
    assert thermal is not None
    assert rate is not None
    return keys, of_thermal(thermal, keys), of_thermal(rate, keys)


def test_three_tests_give_one_model() -> None:
    made = model()
    assert set(made.tests) == {THERMAL, RATE, NOISE}
    assert {"scale_factor_error", "misalignment", "bias", "bias_temperature"} <= {k.quantity for k in joined().keys}
    own = terms_of(NOISE).noise
    assert made.noise is not None
    assert own is not None
    assert made.noise.keys == own.keys
    np.testing.assert_array_equal(made.noise.values, own.values)
    np.testing.assert_array_equal(made.noise.covariance, own.covariance)


def test_a_term_of_two_tests_is_their_sum() -> None:
    made, thermal, rate = joined(), terms_of(THERMAL).estimate, terms_of(RATE).estimate
    assert thermal is not None
    assert rate is not None
    for axis in "xyz":
        key = Key("bias", axis)
        both = thermal.values[thermal.index(key)] + rate.values[rate.index(key)]
        assert made.values[made.index(key)] == pytest.approx(both, rel=1e-12)


def test_covariances_follow_the_shared_unknowns() -> None:
    """Of each unknown of the thermal test: (what it changes there + what it changes on the table), squared."""
    keys, there, later = shared()
    assert set(later) <= set(there)
    assert "scatter between runs" in later
    made = {one.origin.what: one for one in joined().components if one.origin.test == THERMAL}
    for what, rows in there.items():
        joint = rows + later.get(what, 0.0)
        expected = joint.T @ joint
        size = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
        np.testing.assert_allclose(made[what].covariance, expected, rtol=1e-9, atol=1e-9 * float(size.max()))
    # bias and slope: other than by the thermal test alone
    first, second = keys.index(Key("bias", "x")), keys.index(Key("bias_temperature", "x", power=1))
    alone = there["scatter between runs"]
    scatter = made["scatter between runs"].covariance
    assert abs(scatter[first, second] - (alone.T @ alone)[first, second]) > 0.01 * abs(scatter[first, second])


def test_what_the_thermal_test_missed_cancels_where_the_table_was_read() -> None:
    """At the temperature of the table the bias of the model is what the table read, whatever was taken off it."""
    keys, there, later = shared()
    rows = there["scatter between runs"] + later["scatter between runs"]
    for axis in "xyz":
        at = [k for k, key in enumerate(keys) if key.axis == axis and key.quantity in ("bias", "bias_temperature")]
        temperatures = np.linspace(10.0, 40.0, 601)
        powers = np.array([[(T - REFERENCE) ** keys[k].power for k in at] for T in temperatures])
        u = np.sqrt(np.sum((powers @ rows[:, at].T) ** 2, axis=1))
        alone = np.sqrt(np.sum((powers @ there["scatter between runs"][:, at].T) ** 2, axis=1))
        assert u.min() < 0.05 * alone[np.argmin(u)]
