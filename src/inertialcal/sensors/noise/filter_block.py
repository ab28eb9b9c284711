"""What filters hold of a sensor's terms, and a block of settings with what it does not hold."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ...core.errors import PlanError
from .terms import GaussMarkov, RandomWalk, RateRandomWalk, Term

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


def sensor_noise(kind: str, axes: Axes) -> SensorNoise:
    """Sort the terms of a sensor into what filters hold, and what is left.

    Raises
    ------
    PlanError
        If there are not one or three axes, or an axis has a term twice.
    """
    if not len(axes) or len(axes) not in {1, 3}:
        raise PlanError(f"{len(axes)} axes of the {kind}, need one for all, or three")
    white, drive, times = [], [], []
    left: dict[str, None] = {}
    sources: dict[str, None] = {}
    for terms in axes:
        names = [term.name for term in terms]
        if len(set(names)) != len(names):
            raise PlanError(f"{kind}: a term appears twice in {names}", do="Give the terms of each axis once")
        walk = next((t.coefficient for t in terms if isinstance(t, RateRandomWalk)), None)
        markov = next((t for t in terms if isinstance(t, GaussMarkov)), None)
        white.append(next((t.coefficient for t in terms if isinstance(t, RandomWalk)), np.nan))
        of_markov = markov.sigma * float(np.sqrt(2.0 / markov.correlation_time)) if markov else np.nan
        drive.append(of_markov if walk is None else walk)
        sources["K" if walk is not None else "sigma sqrt(2 / t_c)" if markov else "not told"] = None
        times.append(markov.correlation_time if markov and walk is None else np.nan)
        both = markov is not None and walk is not None
        other = [n for n in names if n not in {"random_walk", "rate_random_walk", "gauss_markov"}]
        left.update(dict.fromkeys([*other, *(["gauss_markov beside rate_random_walk"] if both else [])]))
    said = tuple(f"{kind}: {name.replace('_', ' ')}" for name in left)
    return SensorNoise(kind, tuple(white), tuple(drive), tuple(times), " or ".join(sources), said)


def filter_block(
    target: Target, lines: list[str], settings: Sequence[Setting], rate: SensorNoise, acc: SensorNoise,
    held: tuple[str, ...] = (), missing: tuple[str, ...] = (),
) -> FilterBlock:  # fmt: skip
    """Return a block of a filter, its settings without values counted as missing."""
    untold = tuple(one.key for one in settings if not one.values)
    text = "\n".join(lines) + "\n"
    return FilterBlock(target, text, tuple(settings), (*rate.left, *acc.left, *held), (*untold, *missing))
