"""What is refused before any deviation is taken."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...core.errors import DataError, PlanError
from ...core.estimate import Numbers
from .deviations import KINDS, Kind
from .edf import BLUEST
from .prefix import QUANTITIES

FEW = 3  # channels that are named x, y, z where nobody says


def checked_kind(quantity: str, deviation: str, p: float, noise: Literal["auto"] | int) -> Kind:
    """Return the deviation asked for.

    Raises
    ------
    PlanError
        If quantity, deviation, probability or noise type is not among the possible ones.
    """
    if quantity not in QUANTITIES:
        raise PlanError(
            f"quantity {quantity!r}",
            why="rates, increments and their integral have other deviations, and numbers do not tell them apart",
            do=f"There are: {', '.join(QUANTITIES)}",
            code="wrong_quantity",
        )
    if deviation not in KINDS:
        raise PlanError(f"deviation {deviation!r}", do=f"There are: {', '.join(KINDS)}", code="wrong_deviation")
    if not 0.0 < p < 1.0:
        raise PlanError(
            f"probability {p}", do="Need more than 0 and less than 1, such as 0.95", code="wrong_probability"
        )
    kind = KINDS[deviation]
    if noise != "auto" and not (isinstance(noise, int | np.integer) and kind.reddest <= noise <= BLUEST):
        raise PlanError(
            f"noise type {noise!r} for the {kind.words}",
            do=f"Need 'auto' or an exponent from {kind.reddest} to {BLUEST}",
            code="wrong_noise",
        )
    return kind


def checked_samples(x: ArrayLike, interval: float, scale: float) -> Numbers:
    """Return samples as an array, shape (n, axes), in their type.

    Raises
    ------
    DataError
        If they are no real numbers or have another shape, or interval or scale are not positive and finite.
    """
    for name, value in (("sample interval", interval), ("scale", scale)):
        if not (np.isfinite(value) and value > 0.0):
            raise DataError(f"a {name} of {value}", do="It must be positive", code="wrong_interval")
    samples = np.asarray(x)
    if samples.dtype.kind not in "iuf":
        raise DataError(f"samples of type {samples.dtype}", do="Need real numbers", code="wrong_type")
    if samples.dtype == np.float16:  # compiled loops know none
        samples = samples.astype(np.float32)
    if samples.dtype == np.uint64 and samples.size and samples.max() <= np.iinfo(np.int64).max:
        samples = samples.astype(np.int64)  # compiled loops take a float for the difference of the two
    if samples.ndim not in {1, 2} or not samples.size:
        raise DataError(f"samples of shape {samples.shape}", do="Need (n,) or (n, axes), not empty", code="wrong_shape")
    return samples[:, None] if samples.ndim == 1 else samples


def checked_present(present: NDArray[np.bool_] | None, samples: Numbers) -> NDArray[np.bool_] | None:
    """Return which samples are there, shape (n, axes).

    Raises
    ------
    DataError
        If the shape is another one.
    """
    if present is None:
        return None
    there = np.asarray(present, dtype=bool)
    if there.shape not in {samples.shape, (len(samples),), (len(samples), 1)}:
        raise DataError(f"present of shape {there.shape} for samples of shape {samples.shape}", code="wrong_shape")
    return np.broadcast_to(there if there.ndim == 2 else there[:, None], samples.shape)


def checked_names(names: tuple[str, ...] | None, axes: int) -> tuple[str, ...]:
    """Return the names of the channels: x, y, z, or numbers, where nobody says.

    Raises
    ------
    PlanError
        If there are more or fewer.
    """
    if names is None:
        return tuple("xyz"[:axes]) if axes <= FEW else tuple(str(i) for i in range(axes))
    if len(names) != axes:
        raise PlanError(f"{len(names)} name(s) for {axes} channel(s)", code="wrong_names")
    return tuple(names)
