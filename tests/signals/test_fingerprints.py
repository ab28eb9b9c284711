"""Fingerprints: shared stretches are found wherever they stand, and chance makes none."""

from __future__ import annotations

import numpy as np
import pytest

from inertialcal.signals.fingerprints import alike, fingerprints


def triad(seed: int, n: int = 4000) -> list[np.ndarray]:
    rng = np.random.default_rng(seed)
    return [rng.normal(size=n) for _ in range(3)]


def test_a_copy_is_one_to_the_last_sample() -> None:
    found = fingerprints(triad(1)).shared(fingerprints(triad(1)))
    assert found == (0, 0, 4000)


def test_256_samples_are_found_at_any_place() -> None:
    places = np.random.default_rng(5).integers(0, 3700, size=(30, 2))
    for seed, (first, other) in enumerate(places):
        one, two = triad(seed), triad(seed + 100)
        for a, b in zip(one, two, strict=True):
            b[other : other + 256] = a[first : first + 256]
        found = fingerprints(one).shared(fingerprints(two))
        assert found is not None
        assert found.first - found.other == first - other
        assert 160 <= found.samples <= 256


def test_samples_that_differ_in_one_axis_are_others() -> None:
    one = triad(1)
    two = [*one[:2], one[2] + 1e-9]
    assert fingerprints(one).shared(fingerprints(two)) is None


def test_only_chosen_samples_count() -> None:
    early = np.arange(4000) < 2000
    assert fingerprints(triad(1), early).shared(fingerprints(triad(1), ~early)) is None
    found = fingerprints(triad(1), ~early).shared(fingerprints(triad(1)))
    assert found is not None
    assert found.other - found.first == 2000


@pytest.mark.parametrize("noise", [0.0, 0.05, 0.2, 0.5, 2.0])
def test_coarse_codes_make_no_copy_by_chance(noise: float) -> None:
    rng = np.random.default_rng(3)
    every = [fingerprints([np.round(rng.normal(scale=noise, size=20_000)).astype(np.int16)]) for _ in range(12)]
    assert not [1 for i, one in enumerate(every) for two in every[:i] if one.shared(two)]


def test_the_type_of_the_numbers_does_not_matter() -> None:
    codes = np.random.default_rng(1).integers(-100, 100, size=1000)
    assert fingerprints([codes.astype(np.int16)]).shared(fingerprints([codes.astype(np.float64)])) == (0, 0, 1000)


def test_pairs_that_share_a_stretch_are_among_those_that_may() -> None:
    columns = [triad(seed, 1000) for seed in range(12)]
    columns[7] = columns[2]
    for a, b in zip(columns[4], columns[9], strict=True):
        b[500:800] = a[100:400]
    records = [None, *map(fingerprints, columns), fingerprints([np.zeros(1000)])]
    pairs = [(i, j) for i in range(1, 14) for j in range(i + 1, 14)]
    shared = {(i, j) for i, j in pairs if records[i].shared(records[j]) is not None}  # type: ignore[union-attr,arg-type]
    assert shared == {(3, 8), (5, 10)} == alike(records)
    assert alike([]) == alike([None, records[-1]]) == set()
