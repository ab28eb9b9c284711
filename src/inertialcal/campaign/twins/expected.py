"""How many of a campaign's intervals hold the truth, by their own statement: a range that holds 95 % of such counts.

Of independent 95 % intervals 19 of 20 hold the truth, and the count scatters little. Figures of a campaign are not
independent: all scale factors miss together with the rate of their table, values at several temperatures with their
polynomial, a model with the tests that it is made of. The count is simulated as results state it::

    error of figure j / u_j = Gaussian with the correlations of all figures / sqrt(chi2_dof / dof)

- of one test: by its covariance (``covariances``), which has scatter and standards;
- of two tests: by what one standard uncertainty of a standard changes in each (``shared``);
- one number in several rows (a test and the model that takes it) is one figure, which counts in each of them;
- figures of one axis of a test with the same scatter: one draw of how well that scatter was estimated.

Each figure by itself misses in 5 %, whatever it shares. Draws are the same for the same results.

References
----------
.. [1] JCGM 101:2008, Propagation of distributions using a Monte Carlo method, 6.4.8 (multivariate normal).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from scipy import special

from ...core.estimate import Array
from ...core.key import Key
from ...core.results import key_of
from ...statistics.intervals import coverage_factor

DRAWS, SEED = 20_000, 1
P = 0.95  # of the counts

Row = Mapping[str, Any]


def expected_range(rows: Sequence[Row], covariances: Sequence[Row] = ()) -> tuple[int, int]:
    """Return the least and the largest count of intervals that hold the truth, for 95 % of such campaigns.

    Parameters
    ----------
    rows : sequence of mapping
        Of ``results.json``, each with an interval.
    covariances : sequence of mapping
        Of ``results.json``: of the values of a test.
    """
    if not rows:
        return 0, 0
    names = [_figure(row) for row in rows]
    firsts = {name: number for number, name in reversed(list(enumerate(names)))}
    order = sorted(firsts.values())
    figures = [rows[number] for number in order]
    times = np.array([names.count(names[number]) for number in order])
    inside = _simulated(figures, _correlations(figures, covariances))
    counts = inside @ times
    tail = 50.0 * (1.0 - P)
    low = np.percentile(counts, tail, method="lower")
    return int(low), int(np.percentile(counts, 100.0 - tail, method="higher"))


def _figure(row: Row) -> tuple[Any, ...]:
    """Return what tells a figure from others, whichever row it stands in."""
    return row["quantity"], row["axis"], row["power"], row["value"], row["u"]


def _correlations(rows: Sequence[Row], covariances: Sequence[Row]) -> Array:
    """Return the correlations of the errors of figures, shape (n, n)."""
    n = len(rows)
    names = sorted({name for row in rows for name in row["shared"]})
    changes = np.zeros((n, len(names)))
    for i, row in enumerate(rows):
        if row["u"]:
            changes[i] = [row["shared"].get(name, 0.0) / row["u"] for name in names]
    sizes = np.sqrt(np.sum(changes**2, axis=1))
    changes /= np.maximum(sizes, 1.0)[:, None]  # of no figure the standards make more than all of its uncertainty
    found = changes @ changes.T
    for one in covariances:
        places = {_key(key): j for j, key in enumerate(one["keys"])}
        mine = [(i, places[key]) for i, row in enumerate(rows)
                if row["test"] == one["test"] and (key := key_of(row)) in places]  # fmt: skip
        if not mine:
            continue
        at, of = (np.array(each) for each in zip(*mine, strict=True))
        matrix = np.array(one["matrix"], dtype=float)[np.ix_(of, of)]
        u = np.sqrt(np.diag(matrix))
        known = u > 0.0
        scaled = matrix[np.ix_(known, known)] / np.outer(u[known], u[known])
        found[np.ix_(at[known], at[known])] = scaled
    np.fill_diagonal(found, 1.0)
    return found


def _key(written: Mapping[str, Any]) -> Key:
    return key_of(written)  # type: ignore[arg-type]


def _simulated(rows: Sequence[Row], correlations: Array) -> Array:
    """Return whether each figure holds its truth, campaign by campaign, shape (draws, n)."""
    rng = np.random.default_rng(SEED)
    values, vectors = np.linalg.eigh(correlations)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    root /= np.maximum(np.sqrt(np.sum(root**2, axis=1)), 1e-12)[:, None]  # what was clipped must not narrow an error
    errors = rng.standard_normal((DRAWS, len(rows))) @ root.T
    groups: dict[tuple[str, str, str], Array] = {}
    inside = np.empty((DRAWS, len(rows)), dtype=bool)
    for j, row in enumerate(rows):
        dof = math.inf if row["dof"] is None else float(row["dof"])
        which = (row["test"], row["sensor"], row["axis"][:1])
        if which not in groups:
            groups[which] = rng.random(DRAWS)
        scale = np.ones(DRAWS)
        if math.isfinite(dof):
            scale = np.sqrt(special.chdtri(dof, 1.0 - groups[which]) / dof)
        inside[:, j] = np.abs(errors[:, j]) <= coverage_factor(max(dof, 1e-3)) * scale
    return inside
