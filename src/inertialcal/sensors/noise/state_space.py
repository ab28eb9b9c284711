"""State space of noise terms, and of the bias of a sensor in a filter: F, Q, Qd, H.

A term is written, with states x and white noise w of two-sided density Q::

    dx/dt = F x + w,     bias = H x,     reading = bias + v,     var(v) = R at samples dt apart

and over one step ``x' = Phi x + w_d`` with ``cov(w_d) = Qd``, the integral of ``expm(F t) Q expm(F t)'`` over the step
[1]_. Densities are two-sided, as the coefficients N and K are: Q of a random walk of the rate is K^2, R of white noise
is N^2 / dt.

What a filter can hold only in part: *bias instability* has no finite state; it is stood in for by Gauss-Markov states
whose Allan deviations add up to its flat between two averaging times, with the largest difference stated.
*Quantisation* has a step from sample to sample alone, no F and Q. A *rate ramp* and a *sinusoid* have no noise: their
start is what is not known. A reading of what wanders is its value at an instant, not its mean over dt: its Allan
variance over m steps is 1 + 1 / (2 m^2) times that of means.

References
----------
.. [1] A. Gelb (ed.), Applied Optimal Estimation, MIT Press, 1974, chapter 3. Here by its Taylor series over a part of
   the step in which that converges fast, then doubled.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import singledispatch

import numpy as np
from scipy import linalg

from ...core.errors import DataError, PlanError
from ...core.estimate import Array
from .expected import expected_variance
from .terms import (
    BiasInstability,
    GaussMarkov,
    Quantization,
    RandomWalk,
    RateRamp,
    RateRandomWalk,
    Sinusoid,
    Term,
)

SHORT_STEP = 0.5  # norm of F times the part of a step that the series is taken over
ORDERS = 20  # of the series: what is left out is below 1 / 20! of what is kept
PEAK = 1.89  # averaging time over correlation time at which the Allan deviation of Gauss-Markov noise is largest
GRID = 25  # averaging times a decade at which flicker is compared
FLAT = 2.0 * np.log(2.0) / np.pi  # Allan variance of bias instability over B^2


@dataclass(frozen=True, eq=False)
class StateSpace:
    """States of noise."""

    names: tuple[str, ...]  # One a state; none for white noise
    F: Array | None  # shape (n, n): of the differential equation [1/s]; None where there is only a step
    Q: Array | None  # shape (n, n): of the differential equation [unit^2/s]; None where there is only a step
    Phi: Array  # shape (n, n): transition over one step
    Qd: Array  # shape (n, n): process noise of one step
    H: Array  # shape (1, n): of the reading
    R: float  # Variance of the white part of a reading [unit^2]
    start: Array  # shape (n,): variance of the states at rest; infinite where they have none, and the user must say it
    dt: float  # Length of a step [s]
    remarks: tuple[str, ...] = ()  # What is not exact


def discretise(F: Array, Q: Array, dt: float) -> tuple[Array, Array]:
    """Return Phi and Qd of one step, exact whatever its length.

    Parameters
    ----------
    F, Q : ndarray, shape (n, n)
        Of the differential equation; Q is the two-sided density of the noise on the states.
    dt : float
        Length of the step [s].

    Raises
    ------
    PlanError
        If the step is not positive, or the shapes do not fit.
    """
    n = len(F)
    if not (np.isfinite(dt) and dt > 0.0):
        raise PlanError(f"a step of {dt} s", do="It must be positive")
    if np.shape(F) != (n, n) or np.shape(Q) != (n, n):
        raise PlanError(f"F of shape {np.shape(F)} and Q of shape {np.shape(Q)}, need two equal square matrices")
    if not n:
        return np.zeros((0, 0)), np.zeros((0, 0))
    F, Q = np.asarray(F, dtype=np.float64), np.asarray(Q, dtype=np.float64)
    largest = float(np.linalg.norm(F, 1)) * dt / SHORT_STEP
    doublings = int(np.ceil(np.log2(max(largest, 1.0))))
    part = dt / 2.0**doublings
    phi, added = linalg.expm(F * part), Q * part
    qd = added
    for order in range(2, ORDERS):
        added = (F @ added + added @ F.T) * (part / order)
        qd = qd + added
    for _ in range(doublings):
        phi, qd = phi @ phi, phi @ qd @ phi.T + qd
    return np.asarray(phi), np.asarray(0.5 * (qd + qd.T))


def state_space(
    term: Term, dt: float, *, flat: tuple[float, float] | None = None, states: int | None = None
) -> StateSpace:
    """Return the state space of one term.

    Parameters
    ----------
    term : Term
        With values in SI.
    dt : float
        Length of a step [s].
    flat : (float, float), optional
        Averaging times between which bias instability is stood in for [s]; needed for that term alone.
    states : int, optional
        Gauss-Markov states that stand in for it; by default one a decade and one more.

    Raises
    ------
    PlanError
        If the step is not positive, or bias instability has no range of averaging times.
    """
    if not (np.isfinite(dt) and dt > 0.0):
        raise PlanError(f"a step of {dt} s", do="It must be positive")
    if isinstance(term, BiasInstability):
        if flat is None:
            raise PlanError(
                "bias instability has no finite state",
                do="Give flat=(shortest, longest) averaging time between which Gauss-Markov states stand in for it",
            )
        bank, largest = flicker_bank(term.coefficient, *flat, states=states)
        said = (
            f"bias instability: {len(bank)} Gauss-Markov state(s), whose Allan deviation differs from the flat by at "
            f"most {100.0 * largest:.2g} % between {flat[0]:g} and {flat[1]:g} s"
        )
        return replace(combined([_space(one, dt) for one in bank]), remarks=(said,))
    return _space(term, dt)


def bias_state(
    terms: Iterable[Term],
    dt: float,
    *,
    integrated: bool = True,
    flat: tuple[float, float] | None = None,
) -> StateSpace:
    """Return the error model of a sensor in a filter: its bias, and the angle or velocity that it runs up.

    Parameters
    ----------
    terms : iterable of Term
        Of one axis [SI].
    dt : float
        Length of a step [s].
    integrated : bool
        Whether the first state is the integral of the reading's error (angle, velocity): white noise then enters its
        Q as N^2. Else it stays in R.
    flat : (float, float), optional
        As in `state_space`.

    Returns
    -------
    StateSpace
        States of all terms below each other.

    Raises
    ------
    PlanError
        As `state_space`; or for an integral with quantisation, which is not noise of a rate.
    """
    chosen = list(terms)
    if integrated and any(isinstance(term, Quantization) for term in chosen):
        raise PlanError(
            "quantisation has no differential equation",
            do="Leave it out and add Q^2 to the variance of the integrated reading, or use integrated=False",
        )
    space = combined([state_space(term, dt, flat=flat) for term in chosen])
    if not integrated:
        return space
    if space.F is None or space.Q is None:
        raise PlanError("a term has no differential equation", do="Use integrated=False")
    n = len(space.names)
    F, Q = np.zeros((n + 1, n + 1)), np.zeros((n + 1, n + 1))
    F[0, 1:], F[1:, 1:] = space.H[0], space.F
    Q[0, 0], Q[1:, 1:] = space.R * dt, space.Q
    H = np.eye(1, n + 1)
    start = np.concatenate(([0.0], space.start))
    return StateSpace(("integral", *space.names), F, Q, *discretise(F, Q, dt), H, 0.0, start, dt, space.remarks)


def combined(spaces: Iterable[StateSpace]) -> StateSpace:
    """Return independent noises as one: states below each other, readings added.

    Raises
    ------
    PlanError
        If there is none, or their steps differ.
    """
    parts = list(spaces)
    if not parts or len({part.dt for part in parts}) > 1:
        raise PlanError(f"{len(parts)} state space(s) of steps {sorted({part.dt for part in parts})} s to combine")
    names = [name for part in parts for name in part.names]
    numbered = tuple(f"{n}_{names[:i].count(n) + 1}" if names.count(n) > 1 else n for i, n in enumerate(names))
    stepped = any(part.F is None for part in parts)
    return StateSpace(
        numbered,
        None if stepped else _diagonal([part.F for part in parts]),
        None if stepped else _diagonal([part.Q for part in parts]),
        _diagonal([part.Phi for part in parts]),
        _diagonal([part.Qd for part in parts]),
        np.concatenate([part.H for part in parts], axis=1),
        float(sum(part.R for part in parts)),
        np.concatenate([part.start for part in parts]),
        parts[0].dt,
        tuple(said for part in parts for said in part.remarks),
    )


def _diagonal(blocks: list[Array | None]) -> Array:
    sizes = [len(block) for block in blocks if block is not None]
    out, at = np.zeros((sum(sizes), sum(sizes))), 0
    for block in blocks:
        if block is not None:
            out[at : at + len(block), at : at + len(block)] = block
            at += len(block)
    return out


def _continuous(
    names: tuple[str, ...], F: Array, Q: Array, H: Array, start: Array, dt: float, remarks: tuple[str, ...] = ()
) -> StateSpace:
    return StateSpace(names, F, Q, *discretise(F, Q, dt), H, 0.0, start, dt, remarks)


@singledispatch
def _space(term: Term, dt: float) -> StateSpace:
    raise DataError(f"no state space of {type(term).__name__}")


@_space.register
def _(term: RandomWalk, dt: float) -> StateSpace:
    none = np.zeros((0, 0))
    return StateSpace((), none, none, none, none, np.zeros((1, 0)), term.coefficient**2 / dt, np.zeros(0), dt)


@_space.register
def _(term: RateRandomWalk, dt: float) -> StateSpace:
    return _continuous(
        ("rate_random_walk",), np.zeros((1, 1)), np.array([[term.coefficient**2]]), np.eye(1), np.array([np.inf]), dt
    )


@_space.register
def _(term: GaussMarkov, dt: float) -> StateSpace:
    variance, time = term.sigma**2, term.correlation_time
    F, Q = np.array([[-1.0 / time]]), np.array([[2.0 * variance / time]])
    return _continuous(("gauss_markov",), F, Q, np.eye(1), np.array([variance]), dt)


@_space.register
def _(term: RateRamp, dt: float) -> StateSpace:
    F = np.array([[0.0, 1.0], [0.0, 0.0]])
    start = np.array([np.inf, term.coefficient**2])
    return _continuous(("ramp_bias", "ramp_slope"), F, np.zeros((2, 2)), np.array([[1.0, 0.0]]), start, dt)


@_space.register
def _(term: Sinusoid, dt: float) -> StateSpace:
    omega = 2.0 * np.pi * term.frequency
    F = np.array([[0.0, omega], [-omega, 0.0]])
    start = np.full(2, 0.5 * term.amplitude**2)
    return _continuous(("sine", "cosine"), F, np.zeros((2, 2)), np.array([[1.0, 0.0]]), start, dt)


@_space.register
def _(term: Quantization, dt: float) -> StateSpace:
    """Two errors of the integral, one now and one a step ago: the reading has their difference over dt."""
    variance = term.coefficient**2
    phi, qd = np.array([[0.0, 0.0], [1.0, 0.0]]), np.diag([variance, 0.0])
    H = np.array([[1.0, -1.0]]) / dt
    names = ("quantization_now", "quantization_before")
    return StateSpace(names, None, None, phi, qd, H, 0.0, np.full(2, variance), dt)


def flicker_bank(
    coefficient: float, shortest: float, longest: float, states: int | None = None
) -> tuple[tuple[GaussMarkov, ...], float]:
    """Return Gauss-Markov terms that stand in for bias instability, and their largest relative difference.

    Parameters
    ----------
    coefficient : float
        B [unit].
    shortest, longest : float
        Averaging times between which the Allan deviation is to be 0.664 B [s].
    states : int, optional
        Number of terms; by default one a decade and one more.

    Returns
    -------
    terms : tuple of GaussMarkov
        Correlation times in geometric steps; those that get no part are left out.
    largest : float
        Difference of the Allan deviation from the flat between both times, relative.

    Raises
    ------
    PlanError
        If the times are not ascending, or there is no state.
    """
    if not 0.0 < shortest < longest:
        raise PlanError(f"averaging times from {shortest:g} to {longest:g} s, need ascending positive ones")
    decades = float(np.log10(longest / shortest))
    count = int(np.ceil(decades)) + 1 if states is None else states
    from scipy import optimize  # noqa: PLC0415 - starts slowly

    if count < 1:
        raise PlanError(f"{count} states, need 1 or more")
    tau = np.geomspace(shortest, longest, max(GRID, int(GRID * decades)))
    ends = np.geomspace(shortest, longest, 2 * count + 1)[1::2]  # middles of equal parts of the range

    def stretched(stretch: float) -> tuple[Array, Array, float]:
        middle = np.sqrt(shortest * longest)
        times = middle * (ends / middle) ** stretch / PEAK
        bank = [expected_variance(GaussMarkov(1.0, float(time)), tau / shortest, shortest) for time in times]
        shape = np.stack(bank, axis=1) / FLAT
        parts = optimize.nnls(shape, np.ones(len(tau)))[0]
        return times, parts, float(np.max(np.abs(np.sqrt(shape @ parts) - 1.0)))

    best = optimize.minimize_scalar(lambda s: stretched(s)[2], bounds=(0.5, 1.5), method="bounded").x
    times, parts, largest = stretched(float(best))
    terms = [GaussMarkov(float(coefficient * np.sqrt(w)), float(t)) for w, t in zip(parts, times, strict=True) if w > 0]
    return tuple(terms), largest
