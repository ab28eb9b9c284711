"""Fingerprints of a record: whether two hold the same samples, and where, without keeping either.

Each sample is the values of all channels, to the last bit. A polynomial hash rolls over 32 samples [1]_; those of every
eighth value, wherever they stand, are kept. A stretch that two records share has the same ones at the same distances,
whatever stands before it.

What hardly changes (fewer than 8 changes in 32 samples), and what a record holds more than once, is no fingerprint: two
quiet records of coarse codes share such stretches by chance.

References
----------
.. [1] Karp and Rabin, IBM J. Res. Develop. 31, 1987, pages 249-260; Manber, USENIX Winter 1994, pages 1-10.
"""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .time.samples import Flags, Indices

Words = NDArray[np.uint64]
WINDOW = 32  # samples of a fingerprint
CHANGES = 8  # from sample to sample, in a fingerprint
SHARE = 3  # bits that are zero: one fingerprint in 8 is kept
SHORTEST = 160  # samples from the first to the last fingerprint of a stretch that counts: 256 samples have as many
FEWEST = 6  # fingerprints of it
PIECE = 2**16  # samples that are worked on at once
MIX = (np.uint64(0x9E3779B97F4A7C15), np.uint64(0xBF58476D1CE4E5B9))  # odd, from the golden ratio and splitmix64
BASE = 0xD1342543DE82EF95  # of the polynomial, odd


class Shared(NamedTuple):
    """Samples that two records share: the first in each, and how many at least."""

    first: int
    other: int
    samples: int


@dataclass(frozen=True, eq=False)
class Fingerprints:
    """What is kept of a record."""

    samples: int
    digest: bytes  # of all samples; empty where they hardly change
    values: Words  # ascending, shape (k,)
    places: Indices  # first sample of each, shape (k,)

    def shared(self, other: Fingerprints) -> Shared | None:
        """Return the longest stretch that both hold; None where there is none."""
        if self.digest and self.digest == other.digest:
            return Shared(0, 0, self.samples)
        _, mine, its = np.intersect1d(self.values, other.values, assume_unique=True, return_indices=True)
        if len(mine) < FEWEST:
            return None
        first, second = self.places[mine], other.places[its]
        order = np.lexsort((first, first - second))
        first, second = first[order], second[order]
        cuts = np.flatnonzero(np.diff(first - second)) + 1
        starts, stops = np.append(0, cuts), np.append(cuts, len(first)) - 1
        length = np.where(stops - starts + 1 >= FEWEST, first[stops] - first[starts] + WINDOW, 0)
        best = int(np.argmax(length))
        if length[best] < SHORTEST:
            return None
        return Shared(int(first[starts[best]]), int(second[starts[best]]), int(length[best]))


def alike(records: Sequence[Fingerprints | None]) -> set[tuple[int, int]]:
    """Return the pairs of records that may share a stretch, by number, the lower one first: the others share none."""
    digests: dict[bytes, list[int]] = {}
    for number, one in enumerate(records):
        if one is not None and one.digest:
            digests.setdefault(one.digest, []).append(number)
    found = {pair for same in digests.values() for pair in combinations(same, 2)}
    values = [np.zeros(0, dtype=np.uint64) if one is None else one.values for one in records]
    every = np.concatenate([*values, np.zeros(0, dtype=np.uint64)])
    owner = np.repeat(np.arange(len(values)), [len(one) for one in values])
    order = np.argsort(every, kind="stable")
    every, owner = every[order], owner[order]
    cuts = np.flatnonzero(every[1:] != every[:-1]) + 1
    counts: Counter[tuple[int, int]] = Counter()
    for first, last in zip([0, *cuts.tolist()], [*cuts.tolist(), len(every)], strict=True):
        if last - first > 1:
            counts.update(combinations(owner[first:last].tolist(), 2))
    return found | {pair for pair, count in counts.items() if count >= FEWEST}


def fingerprints(columns: Sequence[NDArray[Any]], chosen: Flags | None = None) -> Fingerprints:
    """Return the fingerprints of a record.

    Parameters
    ----------
    columns : sequence of ndarray, shape (n,)
        Its channels, as stored.
    chosen : ndarray of bool, shape (n,), optional
        Samples that count.

    Examples
    --------
    >>> import numpy as np
    >>> rng = np.random.default_rng(1)
    >>> one, two = rng.normal(size=5000), rng.normal(size=5000)
    >>> two[3000:3300] = one[100:400]
    >>> found = fingerprints([one]).shared(fingerprints([two]))
    >>> found.other - found.first
    2900
    >>> 250 < found.samples <= 300
    True
    """
    at = None if chosen is None else np.flatnonzero(chosen)
    n = (len(columns[0]) if columns else 0) if at is None else len(at)
    powers, inverse = _powers(min(n, PIECE + WINDOW))
    digest = hashlib.blake2b(digest_size=16)
    values: list[Words] = []
    places: list[Indices] = []
    changes = 0
    for first in range(0, n, PIECE):
        part = slice(first, min(first + PIECE + WINDOW, n)) if at is None else at[first : first + PIECE + WINDOW]
        words = _words([column[part] for column in columns])
        digest.update(words[:PIECE].tobytes())
        found, where, own = _kept(words, powers, inverse)
        changes += own
        values.append(found)
        places.append(where + first)
    if changes < CHANGES:
        return Fingerprints(n, b"", np.zeros(0, dtype=np.uint64), np.zeros(0, dtype=np.int64))
    every, index, count = np.unique(np.concatenate(values), return_index=True, return_counts=True)
    return Fingerprints(n, digest.digest(), every[count == 1], np.concatenate(places)[index[count == 1]])


def _powers(n: int) -> tuple[Words, Words]:
    """Return the powers of the base and of its inverse, modulo 2^64."""
    forward, back = (np.full(n, one, dtype=np.uint64) for one in (BASE, pow(BASE, -1, 2**64)))
    return np.cumprod(forward, dtype=np.uint64), np.cumprod(back, dtype=np.uint64)


def _words(columns: Sequence[NDArray[Any]]) -> Words:
    """Return a word a sample, of all its values."""
    words = np.zeros(len(columns[0]), dtype=np.uint64)
    for column in columns:
        bits = (np.asarray(column, dtype=np.float64) + 0.0).view(np.uint64)
        words = (words ^ bits) * MIX[0]
        words = (words ^ (words >> np.uint64(29))) * MIX[1]
        words ^= words >> np.uint64(32)
    return words


def _kept(words: Words, powers: Words, inverse: Words) -> tuple[Words, Indices, int]:
    """Return the fingerprints that are kept of a piece, where they begin, and how often its samples change."""
    changes = np.concatenate(([0], np.cumsum(words[1:] != words[:-1])))
    if len(words) < WINDOW:
        return np.zeros(0, dtype=np.uint64), np.zeros(0, dtype=np.int64), int(changes[-1])
    sums = np.concatenate((np.zeros(1, dtype=np.uint64), np.cumsum(words * powers[: len(words)])))
    last = len(sums) - WINDOW
    rolled = (sums[WINDOW:] - sums[:last]) * inverse[:last]
    rolled = (rolled ^ (rolled >> np.uint64(31))) * MIX[0]
    kept = (rolled >> np.uint64(64 - SHARE) == 0) & (changes[WINDOW - 1 :] - changes[:last] >= CHANGES)
    at = np.flatnonzero(kept[:PIECE])
    return rolled[at], at.astype(np.int64), int(changes[-1])
