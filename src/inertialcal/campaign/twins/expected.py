"""How many of a campaign's intervals hold the truth, by their own statement: a range that holds 95 % of such counts.

Of independent 95 % intervals 19 of 20 hold the truth, and the count scatters little. Figures of a campaign are not
independent: all scale factors miss together with the rate of their table, values at several temperatures with their
polynomial, a model with the tests that it is made of. The count is simulated as results state it::

    error of figure j / u_j = (what the standards did + Gaussian with the correlations that are left) / sqrt(chi2 / dof)

- of one test, and of the model that takes it: by its covariance (``covariances``), of scatter and standards;
- of two tests: by what one standard uncertainty of a standard changes in each (``shared``);
- one number in several rows is one figure, which counts in each of them;
- figures of one axis of a test rest on the same scatter: one draw of how well it was estimated.

Errors of standards that the truth holds are taken as they were drawn: they are no chance any more, and are judged by
themselves, each once. Without them each figure misses in 5 %. Draws are the same for the same results.

References
----------
.. [1] JCGM 101:2008, Propagation of distributions using a Monte Carlo method, 6.4.8 (multivariate normal).
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from typing import Any

import numpy as np
from scipy import special

from ...core.estimate import Array
from ...core.key import Key
from ...core.results import key_of
from ...statistics.intervals import coverage_factor

DRAWS, SEED = 20_000, 1
P = 0.95  # of the counts
LEAST_DOF = 1.0

Row = Mapping[str, Any]


def expected_range(
    rows: Sequence[Row],
    covariances: Sequence[Row] = (),
    made_of: Mapping[str, Sequence[str]] | None = None,
    drawn: Mapping[str, float] | None = None,
) -> tuple[int, int]:
    """Return the least and the largest count of intervals that hold the truth, for 95 % of such campaigns.

    Parameters
    ----------
    rows : sequence of mapping
        Of ``results.json``, each with an interval.
    covariances : sequence of mapping
        Of ``results.json``: of the values of a test.
    made_of : mapping of str to sequence of str, optional
        Tests behind each model, by the name of its rows.
    drawn : mapping of str to float, optional
        Errors of standards that are known, by influence, in standard uncertainties.
    """
    if not rows:
        return 0, 0
    known = {(str(one["test"]), _key(key)) for one in covariances for key in one["keys"]}
    homes = [_home(row, known, made_of or {}) for row in rows]
    names = [_figure(row) for row in rows]
    firsts = {name: number for number, name in reversed(list(enumerate(names)))}
    order = sorted(firsts.values())
    times = np.array([names.count(names[number]) for number in order])
    figures, at = [rows[number] for number in order], [homes[number] for number in order]
    counts = _simulated(figures, at, *_stated(figures, at, covariances, drawn or {})) @ times
    tail = 50.0 * (1.0 - P)
    low = np.percentile(counts, tail, method="lower")
    return int(low), int(np.percentile(counts, 100.0 - tail, method="higher"))


def _home(row: Row, known: Collection[tuple[str, Key]], made_of: Mapping[str, Sequence[str]]) -> str:
    """Return the test whose covariance has a figure: of a model, the test that it is taken from."""
    places = [str(row["test"]), *made_of.get(row["test"], ())]
    return next((one for one in places if (one, key_of(row)) in known), places[0])


def _figure(row: Row) -> tuple[Any, ...]:
    """Return what tells a figure from others, whichever row it stands in."""
    return row["quantity"], row["axis"], row["power"], row["value"], row["u"]


def _key(written: Mapping[str, Any]) -> Key:
    return key_of(written)


def _stated(
    rows: Sequence[Row], homes: Sequence[str], covariances: Sequence[Row], drawn: Mapping[str, float]
) -> tuple[Array, Array]:
    """Return what known errors do to figures, (n,), and the covariance of what is left, (n, n): both over u."""
    n = len(rows)
    names = sorted({name for row in rows for name in row["shared"]})
    changes = np.zeros((n, len(names)))
    for i, row in enumerate(rows):
        if row["u"]:
            changes[i] = [row["shared"].get(name, 0.0) / row["u"] for name in names]
    changes /= np.maximum(np.sqrt(np.sum(changes**2, axis=1)), 1.0)[:, None]  # at most all of its uncertainty
    found = changes @ changes.T
    for one in covariances:
        places = {_key(key): j for j, key in enumerate(one["keys"])}
        mine = [(i, places[key]) for i, row in enumerate(rows)
                if homes[i] == one["test"] and (key := key_of(row)) in places]  # fmt: skip
        if not mine:
            continue
        at, of = (np.array(each) for each in zip(*mine, strict=True))
        matrix = np.array(one["matrix"], dtype=float)[np.ix_(of, of)]
        u = np.sqrt(np.diag(matrix))
        known = u > 0.0
        found[np.ix_(at[known], at[known])] = matrix[np.ix_(known, known)] / np.outer(u[known], u[known])
    np.fill_diagonal(found, 1.0)
    taken = np.array([name in drawn for name in names], dtype=bool)
    errors = np.array([drawn[name] for name in names if name in drawn])
    return changes[:, taken] @ errors, found - changes[:, taken] @ changes[:, taken].T


def _simulated(rows: Sequence[Row], homes: Sequence[str], moved: Array, covariance: Array) -> Array:
    """Return whether each figure holds its truth, campaign by campaign, shape (draws, n)."""
    rng = np.random.default_rng(SEED)
    values, vectors = np.linalg.eigh(covariance)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    sizes = np.sqrt(np.sum(root**2, axis=1))  # what was clipped must not change the size of an error
    root *= (np.sqrt(np.maximum(np.diag(covariance), 0.0)) / np.where(sizes > 0.0, sizes, 1.0))[:, None]
    errors = moved + rng.standard_normal((DRAWS, len(rows))) @ root.T
    groups: dict[tuple[str, str, str], Array] = {}
    inside = np.empty((DRAWS, len(rows)), dtype=bool)
    for j, (row, home) in enumerate(zip(rows, homes, strict=True)):
        which = (home, row["sensor"], row["axis"][:1])
        if which not in groups:
            groups[which] = rng.random(DRAWS)
        dof = math.inf if row["dof"] is None else max(float(row["dof"]), LEAST_DOF)
        scale = np.sqrt(special.chdtri(dof, groups[which]) / dof) if math.isfinite(dof) else 1.0
        inside[:, j] = np.abs(errors[:, j]) <= coverage_factor(dof) * scale
    return inside
