"""Every line of issue 20 on some seeds, and clean records of every kind; `make gate` takes 60 and 900."""

from __future__ import annotations

import pytest

from sized import sized

from .faults import FAULTS, spoiled
from .gate import ALL, failures, lines, tried_clean, tried_lines
from .gate import BASES as ALL_BASES
from .records.clean import KINDS
from .trial import estimates, tried

QUICK = ("mass_attraction", "rate_table:means", "rate_table:unlabelled", "rate_table:fast", "allan:pad")
BASES = list(dict.fromkeys(on for fault, on in lines(list(FAULTS)) if fault.issue))


@pytest.mark.parametrize("on", QUICK)
def test_a_fault_is_named_with_its_recording(on: str) -> None:
    assert failures(tried_lines(on, 1, [fault for fault, base in lines(list(FAULTS), [on]) if fault.issue])) == []


def test_figures_stand_with_and_without_what_was_left_out() -> None:
    case = ALL_BASES["allan"](1)
    clean, after = estimates(tried(case)), tried(spoiled(case, "glitch"))
    walk = {row["axis"]: row["value"] for row in after.rows
            if row["quantity"] == "angle_random_walk" and row["method"] == "unscreened"}  # fmt: skip
    ratios = {axis: walk[axis] / clean[f"angle_random_walk {axis}"]["value"] for axis in walk}
    assert max(ratios.values()) > 3.0  # with the glitch
    assert min(ratios.values()) == pytest.approx(1.0)  # on the other axis
    assert "unscreened" in {code for code, _ in after.said}


@pytest.mark.parametrize("kind", [kind.name for kind in KINDS[::3]])
def test_a_clean_record_passes(kind: str) -> None:
    assert tried_clean(kind, 1).verdict == "clean"


def test_a_change_of_unit_is_named_where_its_samples_are_beyond_the_range() -> None:
    (found,) = tried_lines("rate_table:three", 1, [ALL["v_unit_radians"]])
    assert found.passed


def test_a_shaken_turn_changes_no_gain() -> None:
    assert tried_clean("flip", 15).verdict == "clean"


@pytest.mark.slow
@pytest.mark.parametrize("on", BASES)
def test_each_fault_is_named_with_its_recording(on: str) -> None:
    faults = [fault for fault, base in lines(list(FAULTS), [on]) if fault.issue]
    assert failures([one for seed in sized((2, 3), (2,)) for one in tried_lines(on, seed, faults)]) == []


@pytest.mark.slow
def test_clean_records_pass() -> None:
    found = [tried_clean(kind.name, seed) for kind in KINDS for seed in (2, 3)]
    assert [one for one in found if one.verdict != "clean"] == []
