"""Terms that a record cannot separate, in what filters take; records too short for terms."""

from __future__ import annotations

import numpy as np
import pytest

import inertialcal as ic
from inertialcal.campaign.calls.call import Reduced
from inertialcal.core.units import factor
from inertialcal.procedures.static_noise.filters import filter_block
from inertialcal.sensors.noise.simulate import simulate
from inertialcal.sensors.noise.terms import RandomWalk, RateRandomWalk

WHITE = RandomWalk(0.24 * factor("deg/sqrt(h)", "rad/sqrt(s)"))
WALK = RateRandomWalk(9.0 * factor("deg/h/sqrt(h)", "rad/s/sqrt(s)"))  # as visible as flicker in an hour
TARGETS = ("kalibr", "px4", "gtsam", "kf-gins")


def noise(*terms: RandomWalk | RateRandomWalk, n: int = 72_000, seed: int = 1) -> Reduced:
    samples = simulate(terms, n, 0.05, np.random.default_rng(seed))
    return ic.allan(samples, sample_rate=20.0, units="rad/s")


@pytest.fixture(scope="module")
def alike() -> Reduced:
    return next(
        found for seed in range(1, 40) if (found := noise(WHITE, WALK, seed=seed)).tested[0].result.axes[0].fit.rivals
    )


@pytest.mark.parametrize("target", TARGETS)
def test_no_export_takes_one_of_several_terms_silently(alike: Reduced, target: str) -> None:
    assert any(remark.code == "terms_alike" for remark in alike.remarks)
    head = filter_block(alike, target).text.splitlines()[0]
    assert head.startswith("# gyro x: the record does not tell which: ")
    assert head.endswith("taken, the largest drive; --take NAME takes another")
    assert "as wanted" in filter_block(alike, target, take=["bias_instability"]).text


def test_the_largest_drive_is_taken_or_what_is_wanted(alike: Reduced) -> None:
    def drive(*take: str) -> float:
        values = {one.key: one.values for one in filter_block(alike, "kalibr", take=take).settings}
        return values["gyroscope_random_walk"][0] if values["gyroscope_random_walk"] else 0.0

    ways = alike.tested[0].result.axes[0].alternatives
    walks = [term.coefficient for terms in ways for term in terms if isinstance(term, RateRandomWalk)]
    assert drive() >= max(walks)
    assert drive("rate_random_walk") == next(iter(walks))
    assert drive("bias_instability") == 0.0


def test_a_walk_that_is_not_found_is_a_comment_with_its_limit_or_that_limit() -> None:
    found = noise(WHITE)
    limit = found.tested[0].result.axes[0].fit.term("rate_random_walk").upper_limit
    block = filter_block(found, "kalibr")
    assert f"# gyro x: rate random walk not found, below {limit:.3g} rad/s/sqrt(s) (95 %)" in block.text
    assert "gyroscope_random_walk" in block.missing
    wanted = filter_block(found, "kalibr", take=["upper_limit"])
    assert "its upper limit (95 %) stands in its place" in wanted.text
    assert {one.key: one.values for one in wanted.settings}["gyroscope_random_walk"] == (limit,)


@pytest.mark.parametrize("n", [3, 9, 20])
def test_a_record_too_short_for_terms_gives_its_deviations(n: int) -> None:
    found = noise(WHITE, n=n)
    assert {row.status for row in found.rows} == {"not_estimated"}
    assert all("degrees of freedom" in row.reason.text for row in found.rows)
    (curve,) = (one for one in found.results["curves"] if one["name"] == "allan")
    columns = {name: np.array(one["values"], dtype=float) for name, one in curve["columns"].items()}
    assert np.all(columns["lo"] < columns["deviation"])
    assert np.all(columns["hi"] > columns["deviation"])
