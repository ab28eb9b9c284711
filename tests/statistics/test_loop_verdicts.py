"""Verdicts of the closed loop by hand: t tests of the gain, what a model may be off by, its mixed-up forms."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from scipy import stats

from inertialcal.statistics.closed_loop import RISK, AxisLoop, judged, overall

ONE = AxisLoop("x", 20, 4, 2.0, 1.0, 3.0, 1.0, 10.0, 0.5)
NEAR = 1e-6  # relative: just beyond a limit, and just within


def with_t(t: float, **change: Any) -> AxisLoop:
    """Return an axis whose gain is so many standard uncertainties above zero."""
    return replace(ONE, gain=t * ONE.u, **change)


@pytest.mark.parametrize("share", [1.0, 0.5])
def test_better_is_a_one_sided_t_test(share: float) -> None:
    limit = float(stats.t.isf(RISK * share, ONE.dof))
    words = [judged([with_t(limit * (1.0 + sign * NEAR))], share)[0].verdict for sign in (1, -1)]
    assert words == ["PASS", "INCONCLUSIVE"]


@pytest.mark.parametrize("share", [1.0, 0.5])
def test_worse_counts_beyond_what_the_model_may_be_off_by(share: float) -> None:
    limit = -float(stats.t.isf(RISK * share, ONE.dof)) - ONE.allowed / ONE.u
    words = [judged([with_t(limit * (1.0 + sign * NEAR))], share)[0].verdict for sign in (1, -1)]
    assert words == ["FAIL", "INCONCLUSIVE"]


def test_worse_has_half_of_the_risk_where_mixed_up_forms_have_the_other() -> None:
    limit = -float(stats.t.isf(RISK / 2.0, ONE.dof)) - ONE.allowed / ONE.u
    axes = [replace(with_t(limit * (1.0 + sign * NEAR)), rivals={"transposed": 1.0}) for sign in (1, -1)]
    assert [judged([one])[0].verdict for one in axes] == ["FAIL", "INCONCLUSIVE"]
    assert judged([replace(axes[1], rivals={})])[0].verdict == "FAIL"


@pytest.mark.parametrize(("p", "word"), [(RISK / 4.0 * 0.99, "FAIL"), (RISK / 4.0 * 1.01, "PASS")])
def test_a_mixed_up_form_that_does_better_fails_by_holm_over_all_of_them(p: float, word: str) -> None:
    one = replace(with_t(20.0), rivals={"transposed": p, "turned": 1.0})
    (found,) = judged([one])
    assert found.verdict == word
    assert found.reason.startswith("transposed does better" if word == "FAIL" else "")


def test_the_form_that_does_best_is_named() -> None:
    (found,) = judged([replace(ONE, rivals={"turned": 1e-5, "transposed": 1e-9, "exchanged": 1e-4})])
    assert found.reason.startswith("transposed does better on hold-out readings")


def test_holm_holds_the_risk_over_the_axes() -> None:
    once, twice = (float(stats.t.isf(RISK / n, ONE.dof)) for n in (1, 2))
    assert once < twice
    between = with_t(0.5 * (once + twice))
    assert judged([between])[0].verdict == "PASS"
    assert [one.verdict for one in judged([between, with_t(0.0)])] == ["INCONCLUSIVE"] * 2
    assert [one.verdict for one in judged([between, with_t(9.0)])] == ["PASS", "PASS"]  # step-down


@pytest.mark.parametrize("u", [0.0, float("inf"), float("nan")])
def test_without_an_uncertainty_nothing_is_shown(u: float) -> None:
    for gain in (5.0, -5.0):
        assert judged([replace(ONE, gain=gain, u=u)])[0].verdict == "INCONCLUSIVE"


def test_over_all_axes_the_worst_word_counts() -> None:
    good, bad, open_one = (replace(ONE, verdict=word) for word in ("PASS", "FAIL", "INCONCLUSIVE"))
    assert overall([good, good]) == "PASS"
    assert overall([good, open_one]) == "INCONCLUSIVE"
    assert overall([open_one, bad, good]) == "FAIL"
    assert overall([]) == "INCONCLUSIVE"
    assert judged([]) == ()
