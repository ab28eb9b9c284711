"""What filters hold of a sensor's terms, and a block of settings with what it does not hold."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ...core.errors import PlanError
from .allan_of_terms import expected_variance
from .terms import BiasInstability, GaussMarkov, RandomWalk, RateRandomWalk, Term

STEPS = 4096  # of an averaging time, so short that samples are as good as continuous
Axes = Sequence[Sequence[Term]]
Target = Literal["kalibr", "px4", "gtsam", "kf_gins"]


@dataclass(frozen=True)
class Setting:
    """One value of a block.

    Parameters
    ----------
    key : str
        The filter's word.
    values : tuple of float
        One, or one an axis; none where the terms do not tell it.
    unit : str
        The filter's unit.
    source : str
        How it follows from the terms.
    """

    key: str
    values: tuple[float, ...]
    unit: str
    source: str


@dataclass(frozen=True)
class FilterBlock:
    """Settings of one filter.

    Parameters
    ----------
    target : str
        Which filter.
    text : str
        To paste; lines of what is missing are comments.
    settings : tuple of Setting
        Its values.
    cannot_hold : tuple of str
        What the terms say and the filter has no word for.
    missing : tuple of str
        What the filter wants and the terms do not say.
    """

    target: Target
    text: str
    settings: tuple[Setting, ...]
    cannot_hold: tuple[str, ...]
    missing: tuple[str, ...]

    def __str__(self) -> str:
        """Return the block, and under it as comments what it does not hold."""
        lines = [f"# not held: {one}" for one in self.cannot_hold] + [f"# missing: {one}" for one in self.missing]
        return "\n".join([self.text.rstrip("\n"), *lines])


@dataclass(frozen=True)
class SensorNoise:
    """What filters hold of a sensor.

    Parameters
    ----------
    kind : str
        ``"gyro"`` or ``"accelerometer"``.
    white, drive : tuple of float
        White noise [unit sqrt(s)] and driving noise of the bias [unit/sqrt(s)] of each axis; NaN where not told.
    times : tuple of float
        Correlation time of each axis [s]; NaN where there is none.
    source : str
        What the driving noise was taken from.
    left : tuple of str
        Terms that no filter holds.
    """

    kind: str
    white: tuple[float, ...]
    drive: tuple[float, ...]
    times: tuple[float, ...]
    source: str
    left: tuple[str, ...]


def sensor_noise(kind: str, axes: Axes, horizon: float | None = None) -> SensorNoise:
    """Sort the terms of a sensor into what filters hold, and what is left.

    Parameters
    ----------
    kind : str
        ``"gyro"`` or ``"accelerometer"``.
    axes : sequence of sequences of Term
        Terms of each axis [SI]; one axis stands for all.
    horizon : float, optional
        If said, the bias is a walk that has, at this averaging time, the Allan variance of all that wanders [s].

    Raises
    ------
    PlanError
        If there are not one or three axes, an axis has a term twice, or the horizon is not positive.
    """
    if not len(axes) or len(axes) not in {1, 3}:
        raise PlanError(f"{len(axes)} axes of the {kind}, need one for all, or three")
    if horizon is not None and not (np.isfinite(horizon) and horizon > 0.0):
        raise PlanError(f"a horizon of {horizon} s", do="It must be positive")
    white, biases = [], []
    for terms in axes:
        names = [term.name for term in terms]
        if len(set(names)) != len(names):
            raise PlanError(f"{kind}: a term appears twice in {names}", do="Give the terms of each axis once")
        white.append(next((t.coefficient for t in terms if isinstance(t, RandomWalk)), np.nan))
        biases.append(_bias(terms) if horizon is None else _matched(terms, horizon))
    left = dict.fromkeys(f"{kind}: {said}" for one in biases for said in one.left)
    sources = dict.fromkeys(one.source for one in biases)
    return SensorNoise(
        kind, tuple(white), tuple(one.drive for one in biases), tuple(one.time for one in biases),
        " or ".join(sources), tuple(left),
    )  # fmt: skip


@dataclass(frozen=True)
class _Bias:
    """What drives the bias of one axis, its correlation time, where both come from, and what is left."""

    drive: float
    time: float
    source: str
    left: tuple[str, ...]


def _bias(terms: Sequence[Term]) -> _Bias:
    """Take the walk, else a Gauss-Markov term."""
    left = [_words(t.name) for t in terms if not isinstance(t, RandomWalk | RateRandomWalk | GaussMarkov)]
    walk = next((t for t in terms if isinstance(t, RateRandomWalk)), None)
    markov = next((t for t in terms if isinstance(t, GaussMarkov)), None)
    if walk is not None:
        beside = [f"{_words(markov.name)} beside {_words(walk.name)}"] if markov else []
        return _Bias(walk.coefficient, np.nan, "K", (*left, *beside))
    if markov is not None:
        drive = markov.sigma * float(np.sqrt(2.0 / markov.correlation_time))
        return _Bias(drive, markov.correlation_time, "sigma sqrt(2 / t_c)", tuple(left))
    return _Bias(np.nan, np.nan, "not told", tuple(left))


def _matched(terms: Sequence[Term], horizon: float) -> _Bias:
    """Take a walk of the same Allan variance, K^2 tau / 3, as all that wanders."""
    wandering = tuple(t for t in terms if isinstance(t, BiasInstability | RateRandomWalk | GaussMarkov))
    left = [_words(t.name) for t in terms if not isinstance(t, RandomWalk) and t not in wandering]
    if not wandering:
        return _Bias(np.nan, np.nan, "not told", tuple(left))
    variance = float(expected_variance(wandering, [STEPS], horizon / STEPS)[0])
    names = " and ".join(_words(t.name) for t in wandering)
    if {t.name for t in wandering} != {RateRandomWalk.name}:
        left.append(f"{names}: a walk stands in, right at {horizon:g} s, too small before and too large after")
    source = f"walk with the Allan deviation of {names} at {horizon:g} s"
    return _Bias(float(np.sqrt(3.0 * variance / horizon)), np.nan, source, tuple(left))


def _words(name: str) -> str:
    return name.replace("_", " ")


def filter_block(
    target: Target, lines: list[str], settings: Sequence[Setting], rate: SensorNoise, acc: SensorNoise,
    held: tuple[str, ...] = (), missing: tuple[str, ...] = (),
) -> FilterBlock:  # fmt: skip
    """Return a block of a filter, its settings without values counted as missing."""
    untold = tuple(one.key for one in settings if not one.values)
    text = "\n".join(lines) + "\n"
    return FilterBlock(target, text, tuple(settings), (*rate.left, *acc.left, *held), (*untold, *missing))
