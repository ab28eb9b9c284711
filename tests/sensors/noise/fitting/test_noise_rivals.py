"""Terms that a record cannot separate: intervals hold all the same, a remark gives both, limits allow for it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from noise_records import curve

from inertialcal.sensors.noise.fitting.estimator import fit
from inertialcal.sensors.noise.fitting.noise_fit import NoiseFit
from inertialcal.sensors.noise.terms import BiasInstability, Quantization, RandomWalk, RateRandomWalk, Term
from inertialcal.statistics.intervals import contains, covers
from sized import sized

SHORT = (RandomWalk(1.0), BiasInstability(0.3), RateRandomWalk(0.04))  # 20 Hz: flicker, a walk, or both
ROUNDED = (*SHORT[:1], Quantization(0.02), BiasInstability(0.25), RateRandomWalk(0.02))  # an angle: hidden by N
SLOW = ("bias_instability", "rate_random_walk")


def fits(terms: tuple[Term, ...], n: int, records: int) -> Iterator[NoiseFit]:
    for seed in range(1, records + 1):
        yield fit(curve(terms, n, 0.05, seed), None)


def rates(terms: tuple[Term, ...], n: int, records: int) -> dict[str, list[bool]]:
    """How often intervals, and limits by themselves, hold the truth; zero of a term that is not there."""
    truth = {term.name: getattr(term, term.parameters[0]) for term in terms}
    found: dict[str, list[bool]] = {}
    for one in fits(terms, n, records):
        for term in one.found:
            true = truth.get(term.name, 0.0)
            if term.status == "estimated" and (true or term.name in SLOW):
                found.setdefault(term.name, []).append(contains(term.parameters[0].interval, true))
            elif term.upper_limit is not None and true:
                found.setdefault(f"limit of {term.name}", []).append(true <= term.upper_limit)
    return found


def test_what_cannot_be_separated_is_said_with_both_sizes() -> None:
    alike = clear = 0
    for one in fits(SHORT, 10_000, 7):
        taken = [term for term in one.found if term.name in SLOW and term.status == "estimated"]
        for term, other in ((a, b) for a in taken for b in one.rivals if a.name not in {t.name for t in b.terms}):
            alike += 1
            assert term.parameters[0].interval.lo == 0.0
            assert term.code == "like_another"
            assert {t.name for t in other.terms} & {*SLOW, "rate_ramp", "gauss_markov"}
        assert bool(one.rivals) == any(remark.code == "terms_alike" for remark in one.remarks)
    for one in fits((RandomWalk(1.0), RateRandomWalk(0.2)), 20_000, 2):
        walk = one.term("rate_random_walk")
        assert walk is not None
        clear += walk.status == "estimated" and walk.parameters[0].interval.lo not in {None, 0.0}
    assert alike > 3
    assert clear == 2


@pytest.mark.slow
def test_the_interval_of_white_noise_allows_for_a_rounded_angle_that_stays_hidden() -> None:
    held = rates(ROUNDED, 72_000, 40)["random_walk"]
    assert np.mean(held) > 0.8  # 0.41 with the chosen terms alone


@pytest.mark.slow
@pytest.mark.parametrize(
    ("terms", "n"),
    [
        (SHORT, 10_000), (ROUNDED, 72_000), ((RandomWalk(1.0), RateRandomWalk(0.01)), 72_000),
        ((RandomWalk(1.0), BiasInstability(0.15)), 72_000),
        ((RandomWalk(1.0), BiasInstability(0.25), RateRandomWalk(0.02)), 72_000),
    ],
    ids=["short", "rounded", "walk", "flicker", "both"],
)  # fmt: skip
def test_intervals_and_limits_hold_the_truth_where_terms_are_chosen(terms: tuple[Term, ...], n: int) -> None:
    found = rates(terms, n, sized(400, 100))
    kept = {name: covers(sum(held), len(held)) or np.mean(held) > 0.95 for name, held in found.items()}
    assert all(kept.values()), {name: (np.mean(held), len(held)) for name, held in found.items()}
