"""Clean files of the independent simulators: the commands read them, warn of nothing new, and hold the truth."""

from __future__ import annotations

import pytest

from sized import sized

from . import moved_mass
from .coverage import HEAD, binomial, keeps, lines
from .gate import ALL, tried_clean, tried_lines
from .records.bases import BASES
from .studies import Figure, Study, Tried, every, like
from .trial import hits, tried

SEEDS = 2
NAMES = set(BASES) - {"allan:real", "allan:hour"}  # a real record has no truth
# Warnings that a clean file deserves: what the case does not state, or how few runs it has.
DESERVED = {
    "relative_to_fixture", "few_runs", "no_runs", "not_repeated_between_runs", "short_record", "bias_not_applied",
    "no_null_run", "axis_not_turned", "position_alone", "attitude_unknown",
    "cut_off_disagrees",  # the header of these archive records states a cut-off, their noise is white
}  # fmt: skip


@pytest.mark.parametrize("name", sorted(NAMES))
def test_clean_files_are_read_without_a_warning_and_intervals_hold_the_truth(name: str) -> None:
    held = stated = 0
    for seed in range(1, SEEDS + 1):
        case = BASES[name](seed)
        outcome = tried(case)
        assert outcome.exit in (0, 4), outcome.printed
        assert not outcome.errors, outcome.printed
        assert set(outcome.codes) <= DESERVED, outcome.printed
        a, b = hits(case, outcome)
        held, stated = held + a, stated + b
    assert stated >= SEEDS
    assert binomial(held, stated)[1] > 0.93


def test_the_binomial_interval_is_the_exact_one() -> None:
    low, high = binomial(10, 10, 0.95)
    assert low == pytest.approx(0.025**0.1)
    assert high == 1.0
    assert binomial(5, 10, 0.95) == pytest.approx((0.1871, 0.8129), abs=1e-4)


def test_a_line_of_coverage_counts_hits_and_refusals() -> None:
    study = Study("mass", "known", moved_mass.moved, {"scale factor": like("scale_factor x")})
    (row,) = lines(study, [study.tried(seed) for seed in (1, 2)])
    assert row.count("|") == HEAD.splitlines()[0].count("|")
    assert "/2 |" in row
    assert "| 0x2 |" in row


def test_a_hit_rate_that_is_not_what_is_asked_is_bold() -> None:
    assert keeps("holds", 950, 1000)
    assert keeps("holds", 1000, 1000)
    assert not keeps("holds", 900, 1000)
    assert keeps("few", 925, 1000)
    study = Study("table", "", moved_mass.moved, {"one": like("x")})
    (row,) = lines(study, [Tried(0, [Figure("one", held=seed % 2 == 0)], []) for seed in range(40)])
    assert "**50.0**" in row


def test_names_of_studies_are_unique() -> None:
    names = [one.name for one in every()]
    assert len(set(names)) == len(names)


@pytest.mark.parametrize(("kind", "seed"), [("filtered at 1/10", 18), ("rate table, recordings", 31)])
def test_clean_records_that_ended_in_an_internal_error(kind: str, seed: int) -> None:
    """An end of an interval that the search did not enclose; a closed loop whose uncertainty is not finite."""
    assert tried_clean(kind, seed).exit in (0, 4)


def test_a_rough_end_of_an_interval_at_the_estimate_is_no_endless_loop() -> None:
    (found,) = tried_lines("allan:counts", 2, [ALL["v_bursts_5"]])
    assert found.exit == 0


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(NAMES))
def test_clean_files_hold_the_truth_in_more_campaigns(name: str) -> None:
    held = stated = 0
    for seed in range(1, sized(40, 15) + 1):
        a, b = hits(case := BASES[name](seed), tried(case))
        held, stated = held + a, stated + b
    low, high = binomial(held, stated)
    assert high > 0.93, f"{held} of {stated}: {low:.3f} to {high:.3f}"
